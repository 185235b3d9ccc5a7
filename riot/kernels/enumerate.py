"""All convex polygons over admissible edges: depth-first, the hot loop of the trunk search (paper §4.1.2)."""

from __future__ import annotations

import numpy as np

from riot.kernels.options import kernel
from riot.shape import BoolArray, FloatArray, IntArray


@kernel
def enumerate_convex(points: FloatArray, admissible: BoolArray, n: int, limit: int, out: IntArray) -> int:
    """Count, and list in ``out``, the convex n-gons v_0 < v_1 < … over vertices ``points`` (c, 2).

    ``admissible[i, j]``: the edge from i to j, with the boundary between them in cyclic order, is allowed. The
    vertices are in boundary order, counter-clockwise. Polygons come in lexicographic order; ``out`` (rows, n) int64 is
    filled as far as it reaches; counting stops at ``limit``.
    """
    c = points.shape[0]
    chosen = np.empty(n, dtype=np.int64)
    cursor = np.empty(n, dtype=np.int64)
    count = 0
    for first in range(c):
        chosen[0] = first
        depth = 1
        cursor[1] = first + 1
        while depth > 0:
            nxt = cursor[depth]
            if nxt >= c:
                depth -= 1
                continue
            cursor[depth] = nxt + 1
            last = chosen[depth - 1]
            if not admissible[last, nxt]:
                continue
            if depth >= 2 and not _left(points, chosen[depth - 2], last, nxt):
                continue
            if depth >= 2 and not _left(points, first, chosen[1], nxt):
                continue
            if depth >= 2 and not _left(points, last, nxt, first):
                continue
            chosen[depth] = nxt
            if depth == n - 1:
                if admissible[nxt, first] and _left(points, nxt, first, chosen[1]):
                    if count < out.shape[0]:
                        for d in range(n):
                            out[count, d] = chosen[d]
                    count += 1
                    if count >= limit:
                        return count
            else:
                depth += 1
                cursor[depth] = nxt + 1
    return count


@kernel
def _left(points: FloatArray, a: int, b: int, c: int) -> bool:
    """Whether c lies strictly to the left of the line from a to b."""
    ux, uy = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
    vx, vy = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1]
    return bool(ux * vy - uy * vx > 1e-9)


@kernel
def inside_share(points: FloatArray, ax: float, ay: float, bx: float, by: float, cuts: FloatArray) -> float:
    """Share of the segment a–b that lies inside the polygon ``points`` (m, 2); ``cuts`` (≥ m + 2,) is scratch.

    The segment is cut where the boundary crosses its line; a part is inside if its middle is, by ray parity.
    """
    m = points.shape[0]
    dx, dy = bx - ax, by - ay
    cuts[0], cuts[1] = 0.0, 1.0
    count = 2
    c0 = dx * (points[m - 1, 1] - ay) - dy * (points[m - 1, 0] - ax)
    i0 = m - 1
    for i in range(m):
        c1 = dx * (points[i, 1] - ay) - dy * (points[i, 0] - ax)
        if (c0 <= 0.0) != (c1 <= 0.0):
            share = c0 / (c0 - c1)
            x = points[i0, 0] + share * (points[i, 0] - points[i0, 0]) - ax
            y = points[i0, 1] + share * (points[i, 1] - points[i0, 1]) - ay
            u = (x * dx + y * dy) / (dx * dx + dy * dy)
            if 0.0 < u < 1.0:
                cuts[count] = u
                count += 1
        c0, i0 = c1, i
    cuts[:count].sort()
    share_inside = 0.0
    for k in range(count - 1):
        if cuts[k + 1] - cuts[k] < 1e-9:
            continue
        u = 0.5 * (cuts[k] + cuts[k + 1])
        if _contains(points, ax + u * dx, ay + u * dy):
            share_inside += cuts[k + 1] - cuts[k]
    return share_inside


@kernel
def _contains(points: FloatArray, x: float, y: float) -> bool:
    inside = False
    j = points.shape[0] - 1
    for i in range(points.shape[0]):
        if (points[i, 1] > y) != (points[j, 1] > y):
            at = points[i, 0] + (y - points[i, 1]) / (points[j, 1] - points[i, 1]) * (points[j, 0] - points[i, 0])
            if x < at:
                inside = not inside
        j = i
    return inside


@kernel
def inside_shares(points: FloatArray, indices: IntArray, wanted: BoolArray) -> FloatArray:
    """(c, c) share of the segment between vertices ``indices[i]`` and ``indices[j]`` inside; nan if not ``wanted``."""
    c = len(indices)
    found = np.full((c, c), np.nan)
    cuts = np.empty(points.shape[0] + 2)
    for i in range(c):
        for j in range(c):
            if not wanted[i, j]:
                continue
            if wanted[j, i] and j < i:
                found[i, j] = found[j, i]
                continue
            a, b = indices[i], indices[j]
            found[i, j] = inside_share(points, points[a, 0], points[a, 1], points[b, 0], points[b, 1], cuts)
    return found


def warm() -> None:
    """Compile on a square."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    allowed = ~np.eye(4, dtype=np.bool_)
    enumerate_convex(square, allowed, 3, 100, np.empty((4, 3), dtype=np.int64))
    inside_shares(square, np.arange(4, dtype=np.int64), allowed)
