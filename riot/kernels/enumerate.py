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


def warm() -> None:
    """Compile on a square."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    allowed = ~np.eye(4, dtype=np.bool_)
    enumerate_convex(square, allowed, 3, 100, np.empty((4, 3), dtype=np.int64))
