"""The least-squares system of a dissection tree, and checks of its solution (theory §8; methods ours).

The unknowns of one tree are the samples inside its arcs, arc by arc, then its junctions. The row of a sample
reaches two samples back, that of a junction to the first arc that ends in it. Such a skyline matrix is factored here,
without a library, so that results are the same to the last bit on every machine.
"""

from __future__ import annotations

import numpy as np

from riot.kernels.options import inner, kernel
from riot.types import BoolArray, FloatArray, IntArray

BENDABLE = 0.2
"""Turn of a line, radians, at which its resistance to bending is halved, so that displacements bend at corners.
Ours."""

_FOLDED = 1e-4
"""Sine over cosine of the angle, about, below which two segments that run the same way lie on each other. Ours."""


@kernel
def solved(
    targets: FloatArray,
    offsets: IntArray,
    which: IntArray,
    known: FloatArray,
    wanted: FloatArray,
    weights: FloatArray,
    softness: FloatArray,
    least: float,
) -> FloatArray:
    """(k, 2) samples x that minimise Σ over arcs of ∫ b |d''|² + softness ∫ |d|², plus Σ weights |x − wanted|².

    d = x − ``targets`` (k, 2) is the displacement along an arc; arc i has the samples ``offsets[i]`` to ``offsets[i +
    1]``; b is 1, and less where ``targets`` turn. ``which`` (k,) is a sample's unknown, shared by the ends that meet in
    a junction, or −1: then it is ``known`` (k, 2). ``softness`` (k,), 1 / length⁴, weighs positions; ``weights`` (k,)
    draw single samples to ``wanted`` (k, 2). Samples nearer to each other than ``least`` count as that far apart, since
    the system would be too stiff otherwise.
    """
    count, size = len(targets), 0
    for k in range(count):
        size = max(size, which[k] + 1)
    first = np.empty(size, dtype=np.int64)
    for row in range(size):
        first[row] = row
    for i in range(len(offsets) - 1):
        for k in range(offsets[i], offsets[i + 1]):
            for other in range(max(k - 2, offsets[i]), k):
                unknown, earlier = which[k], which[other]
                if unknown >= 0 and earlier >= 0:
                    first[max(unknown, earlier)] = min(first[max(unknown, earlier)], min(unknown, earlier))
    starts = np.zeros(size + 1, dtype=np.int64)
    for row in range(size):
        starts[row + 1] = starts[row] + row - first[row] + 1
    matrix, right = np.zeros(starts[size]), np.zeros((size, 2))
    single, second = np.array([1.0]), np.empty(3)  # factors of a position, of a second difference
    for i in range(len(offsets) - 1):
        low, high = offsets[i], offsets[i + 1] - 1
        for k in range(low, high + 1):
            before = max(_distance(targets, k - 1, k), least) if k > low else 0.0
            after = max(_distance(targets, k, k + 1), least) if k < high else 0.0
            mean = 0.5 * (before + after)
            _add(matrix, starts, right, which, known, targets, k, single, softness[k] * mean)
            if weights[k] > 0.0:
                _add(matrix, starts, right, which, known, wanted, k, single, weights[k])
            if low < k < high:
                second[0], second[2] = 1.0 / before, 1.0 / after
                second[1] = -second[0] - second[2]
                bent = _turn(targets, k) / BENDABLE
                _add(matrix, starts, right, which, known, targets, k - 1, second, 1.0 / (mean * (1.0 + bent * bent)))
    _factor(matrix, starts, first)
    _substitute(matrix, starts, first, right)
    out = known.copy()
    for k in range(count):
        if which[k] >= 0:
            out[k, 0], out[k, 1] = right[which[k], 0], right[which[k], 1]
    return out


@inner
def _turn(points: FloatArray, k: int) -> float:
    """Change of direction at vertex k, radians."""
    ax, ay = points[k, 0] - points[k - 1, 0], points[k, 1] - points[k - 1, 1]
    bx, by = points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1]
    return float(np.arctan2(ax * by - ay * bx, ax * bx + ay * by))


@inner
def _distance(points: FloatArray, i: int, j: int) -> float:
    x, y = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1]
    return float(np.sqrt(x * x + y * y))


@inner
def _add(
    matrix: FloatArray,
    starts: IntArray,
    right: FloatArray,
    which: IntArray,
    known: FloatArray,
    wanted: FloatArray,
    k: int,
    factors: FloatArray,
    weight: float,
) -> None:
    """Add weight |Σ factors (x − wanted)|² over the samples from k on to the normal equations."""
    for axis in range(2):
        rest = 0.0
        for i in range(len(factors)):
            rest += factors[i] * wanted[k + i, axis]
            if which[k + i] < 0:
                rest -= factors[i] * known[k + i, axis]
        for i in range(len(factors)):
            if which[k + i] >= 0:
                right[which[k + i], axis] += weight * factors[i] * rest
    for i in range(len(factors)):
        for j in range(len(factors)):
            row, column = which[k + i], which[k + j]
            if row >= column >= 0:
                matrix[starts[row + 1] - 1 - (row - column)] += weight * factors[i] * factors[j]


@inner
def _factor(matrix: FloatArray, starts: IntArray, first: IntArray) -> None:
    """Cholesky's factors in place: row r stores its columns ``first[r]`` to r."""
    for row in range(len(first)):
        base = starts[row] - first[row]
        for column in range(first[row], row + 1):
            other = starts[column] - first[column]
            total = matrix[base + column]
            for k in range(max(first[row], first[column]), column):
                total -= matrix[base + k] * matrix[other + k]
            if column == row:
                matrix[base + row] = np.sqrt(total)
            else:
                matrix[base + column] = total / matrix[other + column]


@inner
def _substitute(matrix: FloatArray, starts: IntArray, first: IntArray, right: FloatArray) -> None:
    size = len(first)
    for row in range(size):
        base = starts[row] - first[row]
        for axis in range(2):
            total = right[row, axis]
            for k in range(first[row], row):
                total -= matrix[base + k] * right[k, axis]
            right[row, axis] = total / matrix[base + row]
    for row in range(size - 1, -1, -1):
        base = starts[row] - first[row]
        for axis in range(2):
            right[row, axis] /= matrix[base + row]
            for k in range(first[row], row):
                right[k, axis] -= matrix[base + k] * right[row, axis]


@kernel
def collisions(points: FloatArray, offsets: IntArray, ends: IntArray, clearance: float) -> BoolArray:
    """(k,) which samples of polylines begin or end a segment that comes within ``clearance`` of another.

    Polyline i is samples ``offsets[i]`` to ``offsets[i + 1]`` with the nodes ``ends[i]`` at its ends. Of segments
    that share a sample or a node only those that fold back on each other collide; so do equal ones.
    """
    count = len(points)
    owner = np.empty(count, dtype=np.int64)
    boxes = np.empty((count, 4))
    segments = np.empty(count - (len(offsets) - 1), dtype=np.int64)
    size = 0
    for i in range(len(offsets) - 1):
        for k in range(offsets[i], offsets[i + 1] - 1):
            owner[k] = i
            segments[size] = k
            size += 1
            for axis in range(2):
                boxes[k, axis] = min(points[k, axis], points[k + 1, axis]) - clearance
                boxes[k, 2 + axis] = max(points[k, axis], points[k + 1, axis])
    _sort(segments, boxes)
    colliding = np.zeros(count, dtype=np.bool_)
    for p in range(size):
        segment = segments[p]
        for q in range(p + 1, size):
            other = segments[q]
            if boxes[other, 0] > boxes[segment, 2]:
                break
            if boxes[other, 1] > boxes[segment, 3] or boxes[segment, 1] > boxes[other, 3]:
                continue
            if _collide(points, offsets, ends, owner, min(segment, other), max(segment, other), clearance):
                colliding[segment] = colliding[segment + 1] = colliding[other] = colliding[other + 1] = True
    return colliding


@inner
def _sort(segments: IntArray, boxes: FloatArray) -> None:
    """Sort segments by the left ends of their boxes, by Shell's method."""
    gap = len(segments) // 2
    while gap > 0:
        for k in range(gap, len(segments)):
            segment, slot = segments[k], k
            while slot >= gap and boxes[segments[slot - gap], 0] > boxes[segment, 0]:
                segments[slot] = segments[slot - gap]
                slot -= gap
            segments[slot] = segment
        gap //= 2


@inner
def _collide(
    points: FloatArray, offsets: IntArray, ends: IntArray, owner: IntArray, segment: int, other: int, clearance: float
) -> bool:
    first, second = owner[segment], owner[other]
    if first == second and other == segment + 1:
        return _folded(points, segment + 1, segment, other + 1)
    shared = False
    for s in range(2):
        first_end = offsets[first] if s == 0 else offsets[first + 1] - 2
        for t in range(2):
            second_end = offsets[second] if t == 0 else offsets[second + 1] - 2
            if (
                (first != second or s != t)
                and ends[first, s] == ends[second, t]
                and segment == first_end
                and other == second_end
            ):
                shared = True
                if _folded(points, segment + s, segment + 1 - s, other + 1 - t):
                    return True
    if shared:
        return False
    return _near(points, segment, other, clearance)


@inner
def _folded(points: FloatArray, middle: int, before: int, after: int) -> bool:
    """Whether the way from ``before`` over ``middle`` to ``after`` turns back on itself, or does not move."""
    ax, ay = points[before, 0] - points[middle, 0], points[before, 1] - points[middle, 1]
    bx, by = points[after, 0] - points[middle, 0], points[after, 1] - points[middle, 1]
    dot, cross = ax * bx + ay * by, ax * by - ay * bx
    return bool(dot >= 0.0 and abs(cross) <= _FOLDED * dot)


@inner
def _near(points: FloatArray, segment: int, other: int, clearance: float) -> bool:
    """Whether two segments, each from its sample to the next, cross or come within ``clearance``."""
    a, b, c, d = segment, segment + 1, other, other + 1
    if _side(points, a, b, c) * _side(points, a, b, d) < 0.0 and _side(points, c, d, a) * _side(points, c, d, b) < 0.0:
        return True
    square = min(_square(points, a, b, c), _square(points, a, b, d))
    square = min(square, min(_square(points, c, d, a), _square(points, c, d, b)))
    return bool(square <= clearance * clearance)


@inner
def _side(points: FloatArray, a: int, b: int, x: int) -> float:
    """Positive if sample x lies on the left of the line from sample a to sample b, negative on the right."""
    ax, ay = points[a, 0], points[a, 1]
    return float((points[b, 0] - ax) * (points[x, 1] - ay) - (points[b, 1] - ay) * (points[x, 0] - ax))


@inner
def _square(points: FloatArray, a: int, b: int, x: int) -> float:
    """Squared distance of sample x from the segment of samples a and b."""
    ax, ay = points[a, 0], points[a, 1]
    ex, ey = points[b, 0] - ax, points[b, 1] - ay
    square = ex * ex + ey * ey
    u = 0.0 if square == 0.0 else ((points[x, 0] - ax) * ex + (points[x, 1] - ay) * ey) / square
    u = min(1.0, max(0.0, u))
    dx, dy = points[x, 0] - ax - u * ex, points[x, 1] - ay - u * ey
    return float(dx * dx + dy * dy)


@kernel
def difference(path: FloatArray, arc: FloatArray, lines: int) -> float:
    """Area that lies inside just one of two regions, between their common chord and ``path`` (l, 2) or ``arc`` (m, 2).

    Both run from one end of the chord to the other. By horizontal scanlines, with the even-odd rule.
    """
    m, k = len(path), len(arc)
    count = m + k - 2
    points = np.empty((count + 1, 2))
    low, high = np.inf, -np.inf
    for i in range(count + 1):
        x, y = (path[i, 0], path[i, 1]) if i < m else (arc[count - i, 0], arc[count - i, 1])
        points[i, 0], points[i, 1] = x, y
        low, high = min(low, y), max(high, y)
    step = (high - low) / lines
    if step <= 0.0:
        return 0.0
    # An edge crosses the scanlines, at low + (line + ½) step, from its lower end (included) to its upper (excluded).
    starts = np.zeros(lines + 1, dtype=np.int64)
    spans = np.empty((count, 2), dtype=np.int64)
    for i in range(count):
        y0, y1 = min(points[i, 1], points[i + 1, 1]), max(points[i, 1], points[i + 1, 1])
        spans[i, 0] = max(int(np.ceil((y0 - low) / step - 0.5)), 0)
        spans[i, 1] = min(int(np.ceil((y1 - low) / step - 0.5)), lines)
        for line in range(spans[i, 0], spans[i, 1]):
            starts[line + 1] += 1
    for line in range(lines):
        starts[line + 1] += starts[line]
    crossings, stops = np.empty(starts[lines]), starts.copy()
    for i in range(count):
        for line in range(spans[i, 0], spans[i, 1]):
            y = low + (line + 0.5) * step
            share = (y - points[i, 1]) / (points[i + 1, 1] - points[i, 1])
            x = points[i, 0] + share * (points[i + 1, 0] - points[i, 0])
            slot = stops[line]
            while slot > starts[line] and crossings[slot - 1] > x:
                crossings[slot] = crossings[slot - 1]
                slot -= 1
            crossings[slot] = x
            stops[line] += 1
    total = 0.0
    for line in range(lines):
        for s in range(starts[line], starts[line + 1] - 1, 2):
            total += crossings[s + 1] - crossings[s]
    return float(total * step)


def warm() -> None:
    """Compile the kernels on a bent line."""
    points = np.array([[0.0, 0.0], [0.5, 0.1], [1.0, 0.0]])
    solved(points, np.array([0, 3]), np.array([-1, 0, -1]), points, points, np.zeros(3), np.ones(3), 0.1)
    collisions(points, np.array([0, 3]), np.array([[0, 1]]), 1e-6)
    difference(points, points, 4)
