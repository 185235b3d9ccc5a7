"""Monotone correspondences of polylines, corners on corners (theory §8; methods ours).

Two polylines that run the same way are sampled evenly and matched by dynamic time warping: of all monotone
correspondences the one with the least sum of squared distances and differences of direction.
"""

from __future__ import annotations

import numpy as np

from riot.kernels.options import inner, kernel
from riot.types import FloatArray

MATCH_SIGMA = 0.03
"""Distance, unit-area frame, that costs as much as directions that differ by a right angle. Ours."""

MATCH_SKEW = 0.02
"""Extra cost of a step on one polyline only, so that straight lines correspond evenly. Ours."""

CORNER_TURN = 0.35
"""A vertex where the direction changes by more than this, radians, is a corner; corners go to corners. Ours."""

CORNER_STEPS = 8.0
"""A corner goes to a corner at most this many sample steps from its image by the warp. Ours."""

_COINCIDENT = 1e-9
"""Positions nearer than this, unit-area frame, are one position. Ours: far above rounding."""


@kernel
def along(points: FloatArray) -> FloatArray:
    """(m,) length along a polyline (m, 2) to each vertex."""
    m = len(points)
    lengths = np.zeros(m)
    for k in range(1, m):
        x, y = points[k, 0] - points[k - 1, 0], points[k, 1] - points[k - 1, 1]
        lengths[k] = lengths[k - 1] + np.sqrt(x * x + y * y)
    return lengths


@kernel
def at(points: FloatArray, lengths: FloatArray, positions: FloatArray) -> FloatArray:
    """(k, 2) points at ascending ``positions`` (k,) along a polyline; a vertex's own position gives the vertex."""
    k = len(positions)
    out = np.empty((k, 2))
    m = len(points)
    s = 0
    for i in range(k):
        while s < m - 2 and lengths[s + 1] <= positions[i]:
            s += 1
        span = lengths[s + 1] - lengths[s]
        share = 0.0 if span == 0.0 else min(1.0, max(0.0, (positions[i] - lengths[s]) / span))
        for axis in range(2):
            out[i, axis] = (
                points[s + 1, axis]
                if share == 1.0
                else points[s, axis] + share * (points[s + 1, axis] - points[s, axis])
            )
    return out


@kernel
def _directions(samples: FloatArray) -> FloatArray:
    """(k, 2) unit direction from the sample before to the sample after."""
    k = len(samples)
    out = np.zeros((k, 2))
    for i in range(k):
        before, after = max(i - 1, 0), min(i + 1, k - 1)
        x, y = samples[after, 0] - samples[before, 0], samples[after, 1] - samples[before, 1]
        size = np.sqrt(x * x + y * y)
        if size > 0.0:
            out[i, 0], out[i, 1] = x / size, y / size
    return out


@kernel
def _warp(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """For each sample of a (m, 2) the mean index of the samples of b (k, 2) that correspond to it, and the reverse."""
    m, k = len(a), len(b)
    along_a, along_b = _directions(a), _directions(b)
    total = np.empty((m, k))
    step = np.zeros((m, k), dtype=np.int8)
    for i in range(m):
        for j in range(k):
            x, y = a[i, 0] - b[j, 0], a[i, 1] - b[j, 1]
            cost = (x * x + y * y) / (MATCH_SIGMA * MATCH_SIGMA)
            cost += 1.0 - (along_a[i, 0] * along_b[j, 0] + along_a[i, 1] * along_b[j, 1])
            if i == 0 and j == 0:
                total[i, j] = cost
                continue
            best, which = np.inf, 0
            if i > 0 and j > 0:
                best, which = total[i - 1, j - 1] + 2.0 * cost, 0
            if i > 0 and total[i - 1, j] + cost + MATCH_SKEW < best:
                best, which = total[i - 1, j] + cost + MATCH_SKEW, 1
            if j > 0 and total[i, j - 1] + cost + MATCH_SKEW < best:
                best, which = total[i, j - 1] + cost + MATCH_SKEW, 2
            total[i, j], step[i, j] = best, which
    in_b, in_a = np.zeros(m), np.zeros(k)
    count_b, count_a = np.zeros(m), np.zeros(k)
    i, j = m - 1, k - 1
    while True:
        in_b[i] += j
        count_b[i] += 1.0
        in_a[j] += i
        count_a[j] += 1.0
        if i == 0 and j == 0:
            break
        which = step[i, j]
        if which != 2:
            i -= 1
        if which != 1:
            j -= 1
    in_b, in_a = in_b / count_b, in_a / count_a
    in_b[0], in_b[m - 1], in_a[0], in_a[k - 1] = 0.0, k - 1.0, 0.0, m - 1.0
    return in_b, in_a


@kernel
def _even(length: float, step: float) -> FloatArray:
    """Evenly spaced positions from 0 to ``length``, about ``step`` apart."""
    count = max(int(np.ceil(length / step)), 2)
    positions = np.empty(count + 1)
    for k in range(count + 1):
        positions[k] = k * (length / count)
    return positions


@inner
def _interpolate(x: FloatArray, xs: FloatArray, values: FloatArray, scale: float, out: FloatArray) -> None:
    """Fill ``out`` (k,) with the values, times ``scale``, at ascending ``x`` (k,) between ascending ``xs``, as
    `numpy.interp` does, which takes long to compile."""
    last, j = len(xs) - 1, 0
    for i in range(len(x)):
        while j < last - 1 and xs[j + 1] <= x[i]:
            j += 1
        here, ahead = values[j] * scale, values[j + 1] * scale
        if x[i] <= xs[0]:
            out[i] = values[0] * scale
        elif x[i] >= xs[last]:
            out[i] = values[last] * scale
        else:
            out[i] = (ahead - here) / (xs[j + 1] - xs[j]) * (x[i] - xs[j]) + here


@kernel
def corresponding(path: FloatArray, positions: FloatArray, arc: FloatArray, step: float) -> FloatArray:
    """(q,) positions along ``arc`` that correspond to ascending ``positions`` (q,) along ``path``; ends to ends."""
    path_lengths, arc_lengths = along(path), along(arc)
    on_path, on_arc = _even(path_lengths[-1], step), _even(arc_lengths[-1], step)
    in_arc, _ = _warp(at(path, path_lengths, on_path), at(arc, arc_lengths, on_arc))
    matched = np.empty(len(positions))
    _interpolate(positions, on_path, in_arc, on_arc[1], matched)
    return matched


@kernel
def turnings(points: FloatArray, reach: float) -> FloatArray:
    """(m,) change of direction, radians, at each vertex of a polyline, between the points at ``reach`` before and after
    it; 0 at the ends."""
    m = len(points)
    lengths, positions = along(points), np.empty(2)
    turns = np.zeros(m)
    for k in range(1, m - 1):
        positions[0], positions[1] = max(lengths[k] - reach, 0.0), min(lengths[k] + reach, lengths[m - 1])
        ends = at(points, lengths, positions)
        ax, ay = points[k, 0] - ends[0, 0], points[k, 1] - ends[0, 1]
        bx, by = ends[1, 0] - points[k, 0], ends[1, 1] - points[k, 1]
        turns[k] = np.arctan2(ax * by - ay * bx, ax * bx + ay * by)
    return turns


@kernel
def merged(
    a: FloatArray, marks_a: FloatArray, b: FloatArray, marks_b: FloatArray, step: float
) -> tuple[FloatArray, FloatArray]:
    """Corresponding positions along two polylines, (k,) each: all vertices of both, at most ``step`` apart.

    ``marks_*`` are the turnings at features, 0 at other vertices. Between features the correspondence is linear, so
    that straight lines average to straight lines; a corner goes to the other's corner if it has one there. Before
    distances are compared, the offsets of the ends are removed in proportion.
    """
    lengths_a, lengths_b = along(a), along(b)
    end_a, end_b = lengths_a[-1], lengths_b[-1]
    even_a, even_b = _even(end_a, step), _even(end_b, step)
    samples_a, samples_b = at(a, lengths_a, even_a), at(b, lengths_b, even_b)
    for i in range(len(even_a)):
        share = i / (len(even_a) - 1.0)
        for axis in range(2):
            samples_a[i, axis] += (1.0 - share) * (b[0, axis] - a[0, axis]) + share * (b[-1, axis] - a[-1, axis])
    in_b, in_a = _warp(samples_a, samples_b)
    image_a, image_b = np.empty(len(a)), np.empty(len(b))
    _interpolate(lengths_a, even_a, in_b, even_b[1], image_a)
    _interpolate(lengths_b, even_b, in_a, even_a[1], image_b)

    capacity = len(a) + len(b) + 2
    knots = np.empty((capacity, 2))
    knots[0, 0], knots[0, 1], knots[1, 0], knots[1, 1] = 0.0, 0.0, end_a, end_b
    count = int(np.int64(2))  # a literal would have `_insert` compiled once more
    paired = np.zeros(len(b), dtype=np.bool_)
    reach = CORNER_STEPS * step
    done = np.zeros(len(a), dtype=np.bool_)
    for i in range(1, len(a) - 1):
        if abs(marks_a[i]) > CORNER_TURN:
            j = _partner(lengths_b, marks_b, image_a[i], marks_a[i], reach)
            if j >= 0 and _partner(lengths_a, marks_a, image_b[j], marks_b[j], reach) == i:
                count = _insert(knots, count, lengths_a[i], lengths_b[j], _COINCIDENT)
                done[i], paired[j] = True, True
    for i in range(1, len(a) - 1):
        if marks_a[i] != 0.0 and not done[i]:
            count = _insert(knots, count, lengths_a[i], image_a[i], step)
    for j in range(1, len(b) - 1):
        if marks_b[j] != 0.0 and not paired[j]:
            count = _insert(knots, count, image_b[j], lengths_b[j], step)
    return _between(knots, count, lengths_a, lengths_b, step)


@inner
def _partner(lengths: FloatArray, marks: FloatArray, position: float, turning: float, reach: float) -> int:
    """The corner nearest to ``position``, within ``reach``, that turns the same way; −1 if there is none."""
    best, partner = reach, -1
    for j in range(1, len(lengths) - 1):
        if abs(marks[j]) > CORNER_TURN and marks[j] * turning > 0.0 and abs(lengths[j] - position) < best:
            best, partner = abs(lengths[j] - position), j
    return partner


@inner
def _insert(knots: FloatArray, count: int, u: float, v: float, apart: float) -> int:
    """Insert (u, v) into ascending knots unless it is out of order or nearer than ``apart``; returns their number."""
    slot = 1
    while slot < count - 1 and knots[slot, 0] < u:  # rounding may put u beyond the last
        slot += 1
    if u < knots[slot - 1, 0] + apart or u > knots[slot, 0] - apart:
        return count
    if v < knots[slot - 1, 1] + apart or v > knots[slot, 1] - apart:
        return count
    for k in range(count, slot, -1):
        knots[k, 0], knots[k, 1] = knots[k - 1, 0], knots[k - 1, 1]
    knots[slot, 0], knots[slot, 1] = u, v
    return count + 1


@inner
def _shares_between(lengths: FloatArray, start: float, span: float, shares: FloatArray, most: int) -> int:
    """Insert the shares of the way from ``start`` at which vertices lie into ascending shares; returns their number."""
    for s in range(len(lengths)):
        if span > 0.0 and start < lengths[s] < start + span:
            share, slot = (lengths[s] - start) / span, most
            while slot > 0 and shares[slot - 1] > share:
                shares[slot] = shares[slot - 1]
                slot -= 1
            shares[slot] = share
            most += 1
    return most


@kernel
def _between(
    knots: FloatArray, count: int, lengths_a: FloatArray, lengths_b: FloatArray, step: float
) -> tuple[FloatArray, FloatArray]:
    """Merge the vertices between the first ``count`` knots by their share of the way, and divide intervals longer than
    ``step``."""
    capacity = len(lengths_a) + len(lengths_b) + 2 * count
    capacity += int((lengths_a[-1] + lengths_b[-1]) / step) + capacity
    u, v = np.empty(capacity), np.empty(capacity)
    shares = np.empty(len(lengths_a) + len(lengths_b) + 2)
    size = 0
    for k in range(count - 1):
        span_a, span_b = knots[k + 1, 0] - knots[k, 0], knots[k + 1, 1] - knots[k, 1]
        shares[0] = 0.0
        most = _shares_between(lengths_a, knots[k, 0], span_a, shares, int(np.int64(1)))  # no literal: see `merged`
        most = _shares_between(lengths_b, knots[k, 1], span_b, shares, most)
        shares[most] = 1.0
        wide = max(span_a, span_b)
        for s in range(most):
            width = shares[s + 1] - shares[s]
            if width * wide <= _COINCIDENT:
                continue
            divisions = max(1, int(np.ceil(width * wide / step)))
            for division in range(divisions):
                share = shares[s] + width * division / divisions
                u[size], v[size] = knots[k, 0] + share * span_a, knots[k, 1] + share * span_b
                size += 1
    u[size], v[size] = knots[count - 1, 0], knots[count - 1, 1]
    return u[: size + 1].copy(), v[: size + 1].copy()


def warm() -> None:
    """Compile the kernels."""
    a = np.array([[0.0, 0.0], [0.5, 0.5], [1.0, 0.0]])
    lengths = along(a)
    at(a, lengths, lengths)
    corresponding(a, lengths, a, 0.2)
    marks = turnings(a, 0.1)
    merged(a, marks, a, marks, 0.2)
