"""The region of a polygon that is visible from a boundary point, for the binary score (paper eq. 1)."""

from __future__ import annotations

import numpy as np

from riot.kernels.options import inner, kernel
from riot.types import FloatArray, IntArray

_SAME_ANGLE = 1e-12
"""Directions closer than this, radians, are one direction. Ours."""

_STRAIGHT = 1e-9
"""A section of boundary that is longer than its chord by at most this share is straight. Ours."""

_WIDER = 1e-12
"""An edge is tried for rays beyond the angle that it spans by this, radians. Ours: far above rounding, 1e-15 or so."""

_FLAT = 1e-6
"""Rounding decides on which side of the point an edge passes that spans an angle nearer to π than this, radians.
Ours."""

_BESIDE = 1e-9
"""The same holds for an edge with an end nearer to the point than this, in the unit-area frame. Ours."""


@inner
def _turn(angle: float) -> float:
    """The angle, in [−2π, 2π], as one in [0, 2π]: what ``% (2π)`` gives, without its division."""
    if angle < 0.0:
        return angle + 2.0 * np.pi
    return angle if angle < 2.0 * np.pi else angle - 2.0 * np.pi


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
def _rays(around: FloatArray, forward: float, angles: FloatArray, mids: FloatArray, directions: FloatArray) -> int:
    """Fill the rays between neighbouring directions of vertices within the interior angle; returns their number.

    ``around`` (m,) directions of the vertices after the point, radians from ``forward``, the last the cone's end.
    Ray a runs at ``mids[a]`` between ``angles[a]`` and ``angles[a + 1]``; ``directions`` (m, 2) its cosine and sine.
    """
    last = around.shape[0] - 1
    cone = around[last]
    count = 1
    for j in range(2, last):
        if around[j] < cone:
            angles[count] = around[j]
            count += 1
    _sort(angles, 1, count)
    angles[0], angles[count] = 0.0, cone
    rays = 0
    for a in range(1, count + 1):
        if angles[a] - angles[rays] < _SAME_ANGLE:
            continue
        mids[rays] = 0.5 * (angles[rays] + angles[a])
        directions[rays, 0], directions[rays, 1] = np.cos(forward + mids[rays]), np.sin(forward + mids[rays])
        rays += 1
        angles[rays] = angles[a]
    return rays


@inner
def _meet(
    local: FloatArray, j: int, first: int, last: int, directions: FloatArray, nearest: FloatArray, edges: IntArray
) -> None:
    """Store the distance and number of edge j for the rays first … last − 1 that it meets before all earlier edges."""
    x0, y0, x1, y1 = local[j, 0], local[j, 1], local[j + 1, 0], local[j + 1, 1]
    for a in range(first, last):
        dx, dy = directions[a, 0], directions[a, 1]
        c0, c1 = dx * y0 - dy * x0, dx * y1 - dy * x1
        if (c0 <= 0.0) != (c1 <= 0.0):
            share = c0 / (c0 - c1)
            far = dx * (x0 + share * (x1 - x0)) + dy * (y0 + share * (y1 - y0))
            if 0.0 < far < nearest[a]:
                nearest[a], edges[a] = far, j


@inner
def _first_edges(
    local: FloatArray,
    around: FloatArray,
    mids: FloatArray,
    directions: FloatArray,
    rays: int,
    nearest: FloatArray,
    edges: IntArray,
) -> None:
    """Fill ``edges`` (rays,): the edge that each ray meets first, −1 if none; edge j runs from vertex j to j + 1.

    ``local`` (m, 2) the vertices from the point on, relative to it. An edge is tried only for the rays in the angle
    that it spans. An index into the sorted ``mids`` follows the boundary, so that the work grows with the number of
    crossings, not with rays times edges.
    """
    none = int(np.int64(0))  # a literal would have `_meet` compiled once more
    for a in range(rays):
        nearest[a], edges[a] = np.inf, -1
    at = 0  # how many rays lie before the current vertex
    for j in range(1, local.shape[0] - 1):
        start, end = around[j], around[j + 1]
        before = at
        while at < rays and mids[at] < end:
            at += 1
        while at > 0 and mids[at - 1] >= end:
            at -= 1
        low, high = min(start, end) - _WIDER, max(start, end) + _WIDER
        after_low, after_high = min(before, at), max(before, at)
        spans = high - low
        if abs(spans - np.pi) < _FLAT or _beside(local, j) or _beside(local, j + 1):
            _meet(local, j, none, rays, directions, nearest, edges)
        elif spans < np.pi:
            while after_low > 0 and mids[after_low - 1] >= low:
                after_low -= 1
            while after_high < rays and mids[after_high] <= high:
                after_high += 1
            _meet(local, j, after_low, after_high, directions, nearest, edges)
        else:  # over the forward direction
            low, high = low + 2.0 * _WIDER, high - 2.0 * _WIDER
            while after_low < rays and mids[after_low] <= low:
                after_low += 1
            while after_high > 0 and mids[after_high - 1] >= high:
                after_high -= 1
            _meet(local, j, none, after_low, directions, nearest, edges)
            _meet(local, j, after_high, rays, directions, nearest, edges)


@inner
def _beside(local: FloatArray, j: int) -> bool:
    return bool(abs(local[j, 0]) < _BESIDE and abs(local[j, 1]) < _BESIDE)


@inner
def _seen(
    points: FloatArray,
    lengths: FloatArray,
    k: int,
    local: FloatArray,
    around: FloatArray,
    angles: FloatArray,
    mids: FloatArray,
    directions: FloatArray,
    nearest: FloatArray,
    edges: IntArray,
) -> tuple[float, float, float]:
    """(area, perimeter, longest hidden boundary section) of the visibility polygon of vertex k; the other arrays are
    scratch.

    ``points`` (m, 2) counter-clockwise simple polygon; ``lengths`` (m + 1,) arc length at each vertex. Between the
    rays to two vertices neighbouring in angle the visible edge is one and the same, so the region is a fan of
    triangles. Counter-clockwise along it the visible boundary runs forwards, and a jump in arc length is a section of
    boundary that a window hides.
    """
    m = points.shape[0]
    px, py = points[k, 0], points[k, 1]
    for j in range(m):
        i = k + j if k + j < m else k + j - m
        local[j, 0], local[j, 1] = points[i, 0] - px, points[i, 1] - py
    forward = np.arctan2(local[1, 1], local[1, 0])
    for j in range(1, m):
        around[j] = _turn(np.arctan2(local[j, 1], local[j, 0]) - forward)
    rays = _rays(around, forward, angles, mids, directions)
    _first_edges(local, around, mids, directions, rays, nearest, edges)

    perimeter_all = lengths[m]
    fx, fy, bx, by = local[1, 0], local[1, 1], local[m - 1, 0], local[m - 1, 1]
    area = 0.0
    perimeter = np.hypot(fx, fy) + np.hypot(bx, by)
    hidden = 0.0
    last_x, last_y, last_s = fx, fy, lengths[k + 1] - lengths[k]
    low_x, low_y = np.cos(forward), np.sin(forward)
    for a in range(rays):
        high_x, high_y = np.cos(forward + angles[a + 1]), np.sin(forward + angles[a + 1])
        j = edges[a]
        if j >= 0:
            ax, ay = local[j, 0], local[j, 1]
            ex, ey = local[j + 1, 0] - ax, local[j + 1, 1] - ay
            start_x, start_y, start_s = _on_edge(ax, ay, ex, ey, low_x, low_y)
            end_x, end_y, end_s = _on_edge(ax, ay, ex, ey, high_x, high_y)
            area += 0.5 * abs(start_x * end_y - start_y * end_x)
            base = lengths[k + j] - lengths[k] if k + j < m else lengths[k + j - m] - lengths[k] + perimeter_all
            window = np.hypot(start_x - last_x, start_y - last_y)
            hidden = max(hidden, _behind(base + start_s - last_s, window))
            perimeter += window
            perimeter += np.hypot(end_x - start_x, end_y - start_y)
            last_x, last_y, last_s = end_x, end_y, base + end_s
        low_x, low_y = high_x, high_y
    window = np.hypot(bx - last_x, by - last_y)
    perimeter += window
    before = k - 1 if k > 0 else m - 1
    last_edge = lengths[before + 1] - lengths[before]
    hidden = max(hidden, _behind(perimeter_all - last_edge - last_s, window))
    return area, perimeter, hidden


@inner
def _behind(length: float, window: float) -> float:
    """Hidden length of a section of boundary behind a window: 0 if it is straight, since it is the window itself."""
    return length if length > window * (1.0 + _STRAIGHT) else 0.0


@inner
def _on_edge(ax: float, ay: float, ex: float, ey: float, dx: float, dy: float) -> tuple[float, float, float]:
    """Where the ray from the origin along d meets the edge a + u·e, u kept in [0, 1]: (x, y, length along the edge)."""
    cross = dx * ey - dy * ex
    share = 0.0 if cross == 0.0 else (dy * ax - dx * ay) / cross
    share = min(1.0, max(0.0, share))
    return ax + share * ex, ay + share * ey, share * np.hypot(ex, ey)


@kernel
def seen_from(points: FloatArray, lengths: FloatArray, indices: IntArray) -> FloatArray:
    """(k, 3) area, perimeter and longest hidden section of the visibility polygons of the vertices ``indices``."""
    m = points.shape[0]
    local, around = np.empty((m, 2)), np.empty(m)
    angles, mids, directions = np.empty(m), np.empty(m), np.empty((m, 2))
    nearest, edges = np.empty(m), np.empty(m, dtype=np.int64)
    views = np.empty((len(indices), 3))
    for row in range(len(indices)):
        views[row, 0], views[row, 1], views[row, 2] = _seen(
            points, lengths, indices[row], local, around, angles, mids, directions, nearest, edges
        )
    return views


def warm() -> None:
    """Compile on a square."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    seen_from(square, np.arange(5.0), np.array([0], dtype=np.int64))
