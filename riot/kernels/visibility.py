"""What a boundary point sees of its own polygon: the hot loop of the binary score (paper eq. 1)."""

from __future__ import annotations

import numpy as np

from riot.kernels.options import kernel
from riot.shape import FloatArray, IntArray

_SAME_ANGLE = 1e-12
"""Directions closer than this, radians, are one ray."""

_STRAIGHT = 1e-9
"""A stretch of boundary no longer than its chord, up to this share, is straight."""


@kernel
def seen(points: FloatArray, lengths: FloatArray, k: int, angles: FloatArray) -> tuple[float, float, float]:
    """(area, perimeter, longest hidden stretch) of the visibility polygon of vertex k.

    ``points`` (m, 2) counter-clockwise simple polygon; ``lengths`` (m + 1,) arc length at each vertex; ``angles``
    (m,) scratch. Between the rays to two vertices neighbouring in angle the visible edge is one and the same, so
    the region is a fan of triangles; as it is walked counter-clockwise, the boundary it shows runs forwards, and a
    jump in arc length is a stretch that a window hides.
    """
    m = points.shape[0]
    perimeter_all = lengths[m]
    px, py = points[k, 0], points[k, 1]
    after, before = (k + 1) % m, (k - 1) % m
    fx, fy = points[after, 0] - px, points[after, 1] - py
    bx, by = points[before, 0] - px, points[before, 1] - py
    forward = np.arctan2(fy, fx)
    cone = (np.arctan2(by, bx) - forward) % (2.0 * np.pi)
    count = 0
    for i in range(m):
        if i in (k, after, before):
            continue
        angle = (np.arctan2(points[i, 1] - py, points[i, 0] - px) - forward) % (2.0 * np.pi)
        if angle < cone:
            angles[count] = angle
            count += 1
    angles[count] = cone
    count += 1
    angles[:count].sort()

    area = 0.0
    perimeter = np.hypot(fx, fy) + np.hypot(bx, by)
    hidden = 0.0
    last_x, last_y, last_s = fx, fy, lengths[k + 1] - lengths[k]
    low = 0.0
    for a in range(count):
        high = angles[a]
        if high - low < _SAME_ANGLE:
            continue
        mid = forward + 0.5 * (low + high)
        dx, dy = np.cos(mid), np.sin(mid)
        nearest, edge = np.inf, -1
        x0, y0 = fx, fy
        c0 = dx * y0 - dy * x0
        for step in range(1, m - 1):
            i = (k + step + 1) % m
            x1, y1 = points[i, 0] - px, points[i, 1] - py
            c1 = dx * y1 - dy * x1
            if (c0 <= 0.0) != (c1 <= 0.0):
                share = c0 / (c0 - c1)
                far = dx * (x0 + share * (x1 - x0)) + dy * (y0 + share * (y1 - y0))
                if 0.0 < far < nearest:
                    nearest, edge = far, (k + step) % m
            x0, y0, c0 = x1, y1, c1
        if edge >= 0:
            end = (edge + 1) % m
            ax, ay = points[edge, 0] - px, points[edge, 1] - py
            ex, ey = points[end, 0] - px - ax, points[end, 1] - py - ay
            start_x, start_y, start_s = _on_edge(ax, ay, ex, ey, forward + low)
            end_x, end_y, end_s = _on_edge(ax, ay, ex, ey, forward + high)
            area += 0.5 * abs(start_x * end_y - start_y * end_x)
            base = (lengths[edge] - lengths[k]) % perimeter_all
            window = np.hypot(start_x - last_x, start_y - last_y)
            hidden = max(hidden, _behind(base + start_s - last_s, window))
            perimeter += window
            perimeter += np.hypot(end_x - start_x, end_y - start_y)
            last_x, last_y, last_s = end_x, end_y, base + end_s
        low = high
    window = np.hypot(bx - last_x, by - last_y)
    perimeter += window
    last_edge = lengths[before + 1] - lengths[before]
    hidden = max(hidden, _behind(perimeter_all - last_edge - last_s, window))
    return area, perimeter, hidden


@kernel
def _behind(stretch: float, window: float) -> float:
    """Length of a stretch of boundary behind a window; a straight one lies in the window itself and is seen."""
    return stretch if stretch > window * (1.0 + _STRAIGHT) else 0.0


@kernel
def _on_edge(ax: float, ay: float, ex: float, ey: float, angle: float) -> tuple[float, float, float]:
    """Where a ray from the origin meets the edge a + u·e, with u kept in [0, 1]: (x, y, length along the edge)."""
    dx, dy = np.cos(angle), np.sin(angle)
    cross = dx * ey - dy * ex
    share = 0.0 if cross == 0.0 else (dy * ax - dx * ay) / cross
    share = min(1.0, max(0.0, share))
    return ax + share * ex, ay + share * ey, share * np.hypot(ex, ey)


@kernel
def seen_from(points: FloatArray, lengths: FloatArray, indices: IntArray) -> FloatArray:
    """(k, 3) area, perimeter and longest hidden stretch of the visibility polygons of the vertices ``indices``."""
    angles = np.empty(points.shape[0])
    found = np.empty((len(indices), 3))
    for row in range(len(indices)):
        area, perimeter, hidden = seen(points, lengths, indices[row], angles)
        found[row, 0] = area
        found[row, 1] = perimeter
        found[row, 2] = hidden
    return found


def warm() -> None:
    """Compile on a square."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    seen_from(square, np.arange(5.0), np.array([0], dtype=np.int64))
