"""All convex polygons over admissible edges: depth-first, the hot loop of the trunk search (paper §4.1.2)."""

from __future__ import annotations

import numpy as np

from riot.kernels.options import inner, kernel
from riot.types import BoolArray, FloatArray, IntArray

_LEAST_TURN = 1e-9
"""Cross product of two edges, unit-area frame, up to which they count as straight on. Ours: far above rounding."""

_FIRST_CAPACITY = 64
"""Polygons that the result has space for at first; it grows fourfold. Any number gives the same result."""


@kernel
def enumerate_convex(points: FloatArray, admissible: BoolArray, n: int, limit: int) -> tuple[IntArray, bool]:
    """The convex n-gons v_0 < v_1 < … over vertices ``points`` (c, 2), (count, n), and whether greater n are possible.

    ``admissible[i, j]``: the edge from i to j, with the boundary between them in cyclic order, is allowed. The
    vertices are in boundary order, counter-clockwise. Polygons come in lexicographic order, at most ``limit``. The
    second result is True if some path of n vertices exists: without one there is no polygon of more vertices.
    """
    c = points.shape[0]
    followers, firsts = _followers(admissible)
    chosen = np.empty(n, dtype=np.int64)
    cursor = np.empty(n, dtype=np.int64)
    polygons = np.empty((_FIRST_CAPACITY, n), dtype=np.int64)
    count = 0
    longer = False
    for first in range(c):
        chosen[0] = first
        depth = 1
        cursor[1] = firsts[first]
        while depth > 0:
            last = chosen[depth - 1]
            if cursor[depth] >= firsts[last + 1]:
                depth -= 1
                continue
            nxt = followers[cursor[depth]]
            cursor[depth] += 1
            if depth >= 2 and not _left(points, chosen[depth - 2], last, nxt):
                continue
            if depth >= 2 and not _left(points, first, chosen[1], nxt):
                continue
            if depth >= 2 and not _left(points, last, nxt, first):
                continue
            chosen[depth] = nxt
            if depth < n - 1:
                depth += 1
                cursor[depth] = firsts[nxt]
                continue
            longer = True
            if admissible[nxt, first] and _left(points, nxt, first, chosen[1]):
                if count == len(polygons):
                    larger = np.empty((4 * count, n), dtype=np.int64)
                    for k in range(count):
                        for i in range(n):
                            larger[k, i] = polygons[k, i]
                    polygons = larger
                for i in range(n):
                    polygons[count, i] = chosen[i]
                count += 1
                if count >= limit:
                    return polygons[:count], longer
    return polygons[:count], longer


@kernel
def _followers(admissible: BoolArray) -> tuple[IntArray, IntArray]:
    """The later vertices to which an edge is allowed, vertex by vertex, and the first entry of each vertex, (c +
    1,)."""
    c = admissible.shape[0]
    followers = np.empty(c * c, dtype=np.int64)
    firsts = np.zeros(c + 1, dtype=np.int64)
    count = 0
    for i in range(c):
        for j in range(i + 1, c):
            if admissible[i, j]:
                followers[count] = j
                count += 1
        firsts[i + 1] = count
    return followers[:count], firsts


@inner
def _left(points: FloatArray, a: int, b: int, c: int) -> bool:
    """Whether c lies strictly to the left of the line from a to b."""
    ux, uy = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
    vx, vy = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1]
    return bool(ux * vy - uy * vx > _LEAST_TURN)


def warm() -> None:
    """Compile on a square."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    allowed = ~np.eye(4, dtype=np.bool_)
    enumerate_convex(square, allowed, 3, 100)
