"""Segments in a polygon: necks (paper §5.1), and the share of a trunk edge that is inside (paper §4.1.2)."""

from __future__ import annotations

import numpy as np

from riot.kernels.options import inner, kernel
from riot.types import BoolArray, FloatArray, IntArray

_ROUNDING = 1e-12
"""Greater than any rounding of coordinates in the unit-area frame. Ours."""


@kernel
def contains(points: FloatArray, x: float, y: float, tolerance: float) -> bool:
    """Whether (x, y) lies in the closed polygon (m, 2), or within ``tolerance`` of its boundary."""
    m = points.shape[0]
    reach = 2.0 * tolerance + _ROUNDING
    low, high, left, right = y - reach, y + reach, x - reach, x + reach
    inside = False
    ax, ay = points[m - 1, 0], points[m - 1, 1]
    for i in range(m):
        bx, by = points[i, 0], points[i, 1]
        # Most edges are well above or below: they neither pass near nor cross the line to the left.
        if (ay > low or by > low) and (ay < high or by < high):
            ex, ey = bx - ax, by - ay
            if (ax > left or bx > left) and (ax < right or bx < right):
                squared = ex * ex + ey * ey
                t = 0.0
                if squared > 0.0:
                    t = min(1.0, max(0.0, ((x - ax) * ex + (y - ay) * ey) / squared))
                dx, dy = x - ax - t * ex, y - ay - t * ey
                if dx * dx + dy * dy <= tolerance * tolerance:
                    return True
            if (ay > y) != (by > y) and x < ax + (y - ay) * ex / ey:
                inside = not inside
        ax, ay = bx, by
    return inside


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
def _crossing(
    points: FloatArray, i: int, x: float, y: float, dx: float, dy: float, side_0: float, side_1: float
) -> float:
    """Where the edge that ends in vertex i crosses the line from (x, y) along d, by its ends' distances from it."""
    along_0 = (points[i - 1, 0] - x) * dx + (points[i - 1, 1] - y) * dy  # before vertex 0 comes the last
    along_1 = (points[i, 0] - x) * dx + (points[i, 1] - y) * dy
    return float(along_0 + (along_1 - along_0) * side_0 / (side_0 - side_1))


@kernel
def inscribed(points: FloatArray, first: int, second: int, tolerance: float) -> bool:
    """Whether the segment between two vertices of the simple polygon (m, 2) lies in the closed polygon.

    Without a proper crossing the segment can leave the polygon only where it touches a vertex. So it is cut at the
    vertices nearer than ``tolerance``, and the middle of every interval must be inside.
    """
    m = points.shape[0]
    px, py = points[first, 0], points[first, 1]
    dx, dy = points[second, 0] - px, points[second, 1] - py
    length = np.sqrt(dx * dx + dy * dy)
    if length <= tolerance:
        return True
    dx, dy = dx / length, dy / length

    touching = np.empty(m + 2, dtype=np.float64)
    touching[0], touching[1] = 0.0, length
    touches = 2
    side_a = (points[m - 1, 1] - py) * dx - (points[m - 1, 0] - px) * dy
    for i in range(m):
        side_b = (points[i, 1] - py) * dx - (points[i, 0] - px) * dy
        if abs(side_b) <= tolerance:
            along = (points[i, 0] - px) * dx + (points[i, 1] - py) * dy
            if 0.0 < along < length:
                touching[touches] = along
                touches += 1
        elif (side_a > 0.0) != (side_b > 0.0) and abs(side_a) > tolerance:
            # The edge crosses the segment's line at a point of its own interior.
            along = _crossing(points, i, px, py, dx, dy, side_a, side_b)
            if 0.0 < along < length:
                return False
        side_a = side_b

    _sort(touching, 0, touches)
    for k in range(touches - 1):
        if touching[k + 1] - touching[k] > tolerance:
            middle = 0.5 * (touching[k] + touching[k + 1])
            if not contains(points, px + middle * dx, py + middle * dy, tolerance):
                return False
    return True


@inner
def _inside_share(
    points: FloatArray, ax: float, ay: float, bx: float, by: float, tolerance: float, cuts: FloatArray
) -> float:
    """Share of the segment a–b that lies in the closed polygon ``points`` (m, 2); ``cuts`` (≥ m + 2,) is scratch.

    The segment is cut as in `inscribed`, and where the boundary crosses it. An interval within ``tolerance`` of the
    boundary is inside, so that rounding does not decide about an edge along a straight side.
    """
    m = points.shape[0]
    dx, dy = bx - ax, by - ay
    length = np.sqrt(dx * dx + dy * dy)
    if length <= tolerance:
        return 1.0
    dx, dy = dx / length, dy / length
    cuts[0], cuts[1] = 0.0, length
    count = 2
    side_0 = (points[m - 1, 1] - ay) * dx - (points[m - 1, 0] - ax) * dy
    for i in range(m):
        side_1 = (points[i, 1] - ay) * dx - (points[i, 0] - ax) * dy
        cut = -1.0
        if abs(side_1) <= tolerance:
            cut = (points[i, 0] - ax) * dx + (points[i, 1] - ay) * dy
        elif (side_0 > 0.0) != (side_1 > 0.0) and abs(side_0) > tolerance:
            cut = _crossing(points, i, ax, ay, dx, dy, side_0, side_1)
        if 0.0 < cut < length:
            cuts[count] = cut
            count += 1
        side_0 = side_1
    _sort(cuts, 0, count)
    inside = 0.0
    for k in range(count - 1):
        if cuts[k + 1] - cuts[k] > tolerance:
            middle = 0.5 * (cuts[k] + cuts[k + 1])
            if contains(points, ax + middle * dx, ay + middle * dy, tolerance):
                inside += cuts[k + 1] - cuts[k]
    return float(inside / length)


@kernel
def inside_shares(points: FloatArray, indices: IntArray, wanted: BoolArray, tolerance: float) -> FloatArray:
    """(c, c) share of the segment between vertices ``indices[i]`` and ``indices[j]`` inside; nan if not ``wanted``."""
    c = len(indices)
    shares = np.empty((c, c))
    cuts = np.empty(points.shape[0] + 2)
    for i in range(c):
        for j in range(c):
            shares[i, j] = np.nan
            if not wanted[i, j]:
                continue
            if wanted[j, i] and j < i:
                shares[i, j] = shares[j, i]
                continue
            a, b = indices[i], indices[j]
            shares[i, j] = _inside_share(
                points, points[a, 0], points[a, 1], points[b, 0], points[b, 1], tolerance, cuts
            )
    return shares


@kernel
def find_necks(
    points: FloatArray, arc: FloatArray, perimeter: float, concave: IntArray, tie: float, tolerance: float
) -> IntArray:
    """Index pairs (k, 2) of all necks, in the order of ``concave``, then of the boundary.

    ``arc`` (m,) is the arc length at each point, ``concave`` the indices to start from. A point is a local
    maximum if neither neighbour exceeds it by more than the relative ``tie``.
    """
    m = points.shape[0]
    ratio = np.empty(m, dtype=np.float64)
    necks = np.empty((concave.shape[0] * m, 2), dtype=np.int64)
    count = 0
    for c in range(concave.shape[0]):
        p1 = concave[c]
        for i in range(m):
            geodesic = abs(arc[i] - arc[p1])
            geodesic = min(geodesic, perimeter - geodesic)
            dx, dy = points[i, 0] - points[p1, 0], points[i, 1] - points[p1, 1]
            distance = np.sqrt(dx * dx + dy * dy)
            ratio[i] = geodesic / distance if distance > 0.0 else 0.0
        for i in range(m):
            left, right = (i - 1) % m, (i + 1) % m
            if p1 in (i, left, right):
                continue
            if (
                ratio[i] * (1.0 + tie) >= ratio[left]
                and ratio[i] * (1.0 + tie) >= ratio[right]
                and ratio[i] > 1.0 + tie
                and inscribed(points, p1, i, tolerance)
            ):
                necks[count, 0], necks[count, 1] = p1, i
                count += 1
    return necks[:count].copy()


def warm() -> None:
    """Compile on a tiny polygon."""
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 0.2], [0.0, 1.0]])
    arc = np.arange(5, dtype=np.float64)
    find_necks(points, arc, 5.0, np.array([3], dtype=np.int64), 1e-9, 1e-9)
    inside_shares(points, np.arange(5, dtype=np.int64), ~np.eye(5, dtype=np.bool_), 1e-9)
