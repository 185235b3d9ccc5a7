"""How congruent the boundary is on both sides of a point: the hot loop of the congruency score (paper eq. 2)."""

from __future__ import annotations

import numpy as np

from riot.kernels.options import inner, kernel
from riot.types import FloatArray, IntArray

_LOCAL_SAMPLES = 9
"""Samples on either side of a vertex that give its local outside angle. Ours."""


@inner
def _sort(values: FloatArray, start: int, stop: int) -> None:
    """Sort ``values[start:stop]``, ascending (Shell's method; numpy's takes long to compile)."""
    gap = 1
    while gap < (stop - start) // 3:
        gap = 3 * gap + 1
    while gap > 0:
        for k in range(start + gap, stop):
            value, at = values[k], k
            while at >= start + gap and values[at - gap] > value:
                values[at] = values[at - gap]
                at -= gap
            values[at] = value
        gap //= 3


@inner
def walk(points: FloatArray, lengths: FloatArray, k: int, step: float, back: bool, out: FloatArray) -> None:
    """Fill ``out`` (c, 2) with the boundary at arc lengths 0, step, 2·step, … from vertex k, relative to it.

    Forwards, or backwards if ``back``. ``lengths`` (m + 1,) is the arc length at each vertex; the curve is at most once
    around.
    """
    m = points.shape[0]
    i = k
    travelled = 0.0
    edge = lengths[(i - 1) % m + 1] - lengths[(i - 1) % m] if back else lengths[i + 1] - lengths[i]
    for c in range(out.shape[0]):
        wanted = c * step
        while travelled + edge < wanted and edge >= 0.0:
            travelled += edge
            i = (i - 1) % m if back else (i + 1) % m
            edge = lengths[(i - 1) % m + 1] - lengths[(i - 1) % m] if back else lengths[i + 1] - lengths[i]
        j = (i - 1) % m if back else (i + 1) % m
        share = (wanted - travelled) / edge
        out[c, 0] = points[i, 0] + share * (points[j, 0] - points[i, 0]) - points[k, 0]
        out[c, 1] = points[i, 1] + share * (points[j, 1] - points[i, 1]) - points[k, 1]


@inner
def _walk_both(
    points: FloatArray, lengths: FloatArray, k: int, step: float, left: FloatArray, right: FloatArray
) -> None:
    """`walk` backwards into ``left`` and forwards into ``right``."""
    for way in range(2):  # a literal would have `walk` compiled once more
        if way == 0:
            walk(points, lengths, k, step, way == 0, left)
        else:
            walk(points, lengths, k, step, way == 0, right)


@inner
def best_turn(left: FloatArray, right: FloatArray, count: int) -> float:
    """Angle in [0, 2π) by which to turn ``left`` about the origin, counter-clockwise, onto ``right``: least squares.

    Only the first ``count`` rows are compared, row by row.
    """
    sine, cosine = 0.0, 0.0
    for c in range(count):
        sine += left[c, 0] * right[c, 1] - left[c, 1] * right[c, 0]
        cosine += left[c, 0] * right[c, 0] + left[c, 1] * right[c, 1]
    return float(np.arctan2(sine, cosine) % (2.0 * np.pi))


@kernel
def frechet(a: FloatArray, b: FloatArray, count: int, row: FloatArray) -> float:
    """Discrete Fréchet distance of the first ``count`` points of two curves; ``row`` (≥ count,) is scratch."""
    for i in range(count):
        diagonal = 0.0
        for j in range(count):
            dx, dy = a[i, 0] - b[j, 0], a[i, 1] - b[j, 1]
            here = dx * dx + dy * dy
            above = row[j]
            if i == 0 and j == 0:
                reach = here
            elif i == 0:
                reach = max(here, row[j - 1])
            elif j == 0:
                reach = max(here, above)
            else:
                reach = max(here, min(above, min(row[j - 1], diagonal)))
            diagonal = above
            row[j] = reach
    return float(np.sqrt(row[count - 1]))


@kernel
def longest_congruent(
    points: FloatArray,
    lengths: FloatArray,
    indices: IntArray,
    breaks: FloatArray,
    step: float,
    limit: float,
    shortest: float,
) -> FloatArray:
    """(k, 3) of the vertices ``indices``: length ℓ of the longest congruent sides, their Fréchet distance, their turn.

    ``breaks`` (b,) are the arc lengths of the simplified boundary's break points. The candidates ℓ are the distances
    from the vertex to each of them, either way, up to half the boundary. A length passes if the discrete Fréchet
    distance of the two sides, sampled every ``step``, with the left one turned onto the right one, is at most
    ``limit``. A row without a passing ℓ > ``shortest`` has length 0, distance inf and the turn of the shortest
    candidate.
    """
    m = points.shape[0]
    perimeter = lengths[m]
    capacity = int(0.5 * perimeter / step) + 2
    left, right, turned = np.empty((capacity, 2)), np.empty((capacity, 2)), np.empty((capacity, 2))
    row = np.empty(capacity)
    candidates = np.empty(2 * len(breaks))
    congruent = np.empty((len(indices), 3))
    for r in range(len(indices)):
        k = indices[r]
        _walk_both(points, lengths, k, step, left, right)
        total = 0
        for b in range(len(breaks)):
            ahead = (breaks[b] - lengths[k]) % perimeter
            for side in range(2):
                length = ahead if side == 0 else perimeter - ahead
                if shortest < length <= 0.5 * perimeter:
                    candidates[total] = length
                    total += 1
        _sort(candidates, 0, total)
        congruent[r, 0], congruent[r, 1], congruent[r, 2] = 0.0, np.inf, 0.0
        for c in range(total - 1, -1, -1):
            count = min(capacity, max(2, int(candidates[c] / step + 0.5) + 1))
            turn = best_turn(left, right, count)
            cosine, sine = np.cos(turn), np.sin(turn)
            end = count - 1
            ex = cosine * left[end, 0] - sine * left[end, 1] - right[end, 0]
            ey = sine * left[end, 0] + cosine * left[end, 1] - right[end, 1]
            congruent[r, 2] = turn
            if ex * ex + ey * ey > limit * limit:
                continue  # the Fréchet distance is at least that of the end points
            for i in range(count):
                turned[i, 0] = cosine * left[i, 0] - sine * left[i, 1]
                turned[i, 1] = sine * left[i, 0] + cosine * left[i, 1]
            distance = frechet(turned, right, count, row)
            if distance <= limit:
                congruent[r, 0], congruent[r, 1] = candidates[c], distance
                break
    return congruent


@kernel
def local_turns(points: FloatArray, lengths: FloatArray, indices: IntArray, reach: float) -> FloatArray:
    """(k,) outside angles in [0, 2π) at vertices: the turn that brings the boundary up to ``reach`` behind the vertex
    onto that ahead of it."""
    left, right = np.empty((_LOCAL_SAMPLES, 2)), np.empty((_LOCAL_SAMPLES, 2))
    count = len(left)  # a constant would have `best_turn` compiled once more
    turns = np.empty(len(indices))
    for r in range(len(indices)):
        _walk_both(points, lengths, indices[r], reach / (count - 1), left, right)
        turns[r] = best_turn(left, right, count)
    return turns


def warm() -> None:
    """Compile on a square."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    lengths, zero = np.arange(5.0), np.array([0], dtype=np.int64)
    longest_congruent(square, lengths, zero, np.array([1.0, 2.0]), 0.1, 0.2, 0.1)
    local_turns(square, lengths, zero, 0.2)
