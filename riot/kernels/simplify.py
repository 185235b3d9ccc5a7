"""Douglas–Peucker on polylines and polygons, and midpoints: the loops behind `riot.geometry.polyline`."""

from __future__ import annotations

import numpy as np

from riot.kernels.options import kernel
from riot.types import BoolArray, FloatArray, IntArray

TIE = 1e-9
"""Relative difference below which two ratios, angles or distances count as equal, and a value as on its limit.

So a moved copy of a shape gives the same results although its coordinates round otherwise. Ours: a million times the
rounding of double precision."""


@kernel
def douglas_peucker(points: FloatArray, tolerance: float) -> BoolArray:
    """Mark the vertices of an (m, 2) polyline that are kept; both ends always are.

    The distance of a vertex is that to the chord as a segment, not as a line, so that a spike that runs past the end of
    its chord is kept. Of equally distant vertices, as on a straight side parallel to the chord, the one nearest to an
    end of the chord wins, which is a corner; of these the first. So a turned or mirrored copy keeps the same vertices.
    """
    m = points.shape[0]
    keep = np.zeros(m, dtype=np.bool_)
    keep[0] = True
    keep[m - 1] = True
    # An explicit stack of (first, last): each split pushes two, and there are at most m splits.
    stack = np.empty((m + 1, 2), dtype=np.int64)
    stack[0, 0] = 0
    stack[0, 1] = m - 1
    top = 1
    squares, shares = np.empty(m), np.empty(m)
    while top > 0:
        top -= 1
        first = stack[top, 0]
        last = stack[top, 1]
        ax = points[first, 0]
        ay = points[first, 1]
        dx = points[last, 0] - ax
        dy = points[last, 1] - ay
        square = dx * dx + dy * dy
        worst = tolerance * tolerance
        split = -1
        for i in range(first + 1, last):
            px = points[i, 0] - ax
            py = points[i, 1] - ay
            t = 0.0
            if square > 0.0:
                t = min(1.0, max(0.0, (px * dx + py * dy) / square))
            ex = px - t * dx
            ey = py - t * dy
            squares[i], shares[i] = ex * ex + ey * ey, t
            if squares[i] > worst:
                worst = squares[i]
                split = i
        outermost = -1.0
        for i in range(first + 1, last if split >= 0 else 0):
            if squares[i] >= worst * (1.0 - TIE) and abs(shares[i] - 0.5) > outermost + TIE:
                outermost = abs(shares[i] - 0.5)
                split = i
        if split >= 0:
            keep[split] = True
            stack[top, 0] = first
            stack[top, 1] = split
            stack[top + 1, 0] = split
            stack[top + 1, 1] = last
            top += 2
    return keep


@kernel
def farthest_vertex(points: FloatArray, x: float, y: float) -> int:
    """Index of the vertex (m, 2) farthest from (x, y); of ties the one with least x, then least y, then the first."""
    m = points.shape[0]
    squares = np.empty(m)
    greatest = 0.0
    for i in range(m):
        dx, dy = points[i, 0] - x, points[i, 1] - y
        squares[i] = dx * dx + dy * dy
        greatest = max(greatest, squares[i])
    best = -1
    for i in range(m):
        if squares[i] >= greatest * (1.0 - TIE) and (
            best < 0
            or points[i, 0] < points[best, 0]
            or (points[i, 0] == points[best, 0] and points[i, 1] < points[best, 1])
        ):
            best = i
    return best


@kernel
def simplified(points: FloatArray, x: float, y: float, tolerance: float) -> IntArray:
    """Sorted indices (k,) of the vertices that Douglas–Peucker keeps of a closed polygon (m, 2).

    It is cut at the vertex farthest from (x, y) and at the vertex farthest from that one.
    """
    m = points.shape[0]
    first = farthest_vertex(points, x, y)
    second = farthest_vertex(points, points[first, 0], points[first, 1])
    middle = second - first if second >= first else second - first + m
    turned = np.empty((m + 1, 2))
    for i in range(m + 1):
        k = (first + i) % m
        turned[i, 0], turned[i, 1] = points[k, 0], points[k, 1]
    keep = np.zeros(m, dtype=np.bool_)
    keep[first] = True
    for start, stop in ((0, middle), (middle, m)):
        if start == stop or middle == 0:  # all vertices coincide
            continue
        kept = douglas_peucker(turned[start : stop + 1], tolerance)
        for i in range(stop - start):
            if kept[i]:
                keep[(first + start + i) % m] = True
    kept_indices, count = np.empty(m, dtype=np.int64), 0
    for k in range(m):
        if keep[k]:
            kept_indices[count] = k
            count += 1
    return kept_indices[:count]


@kernel
def halved(starts: FloatArray, perimeter: float, spacing: float) -> tuple[FloatArray, BoolArray]:
    """Arc lengths (n,) of vertices and of the midpoints between them, and which are vertices.

    ``starts`` (k,) are the arc lengths of the vertices, ascending. The interval from a vertex to the next, which for
    the last is the first, is halved until its divisions are shorter than ``spacing``.
    """
    count = len(starts)
    divisions = np.empty(count, dtype=np.int64)
    total = 0
    for k in range(count):
        span = (starts[k + 1] if k + 1 < count else starts[0] + perimeter) - starts[k]
        divisions[k] = 1
        while span / divisions[k] >= spacing:
            divisions[k] *= 2
        total += divisions[k]
    positions, is_start = np.empty(total), np.zeros(total, dtype=np.bool_)
    at = 0
    for k in range(count):
        span = (starts[k + 1] if k + 1 < count else starts[0] + perimeter) - starts[k]
        interval = span / divisions[k]
        is_start[at] = True
        for i in range(divisions[k]):
            positions[at] = starts[k] + i * interval
            at += 1
    return positions, is_start


def warm() -> None:
    """Compile the kernels."""
    douglas_peucker(np.zeros((3, 2)), 1.0)
    farthest_vertex(np.zeros((3, 2)), 0.0, 0.0)
    simplified(np.zeros((3, 2)), 0.0, 0.0, 1.0)
    halved(np.zeros(1), 1.0, 0.3)
