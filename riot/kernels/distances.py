"""Signed distance of many points to the regions of swung arcs: the hot loop of the partition (theory §8)."""

from __future__ import annotations

import numpy as np

from riot.kernels.options import kernel
from riot.shape import FloatArray, IntArray


@kernel
def signed_distances(x: FloatArray, arcs: FloatArray, offsets: IntArray) -> FloatArray:
    """(k, n) distance of points (k, 2) to arc i, negative inside the region between the arc and its chord.

    ``arcs`` (s, 2) are the concatenated polylines, ``offsets`` (n + 1,) where each starts. The chord belongs to the
    region's parity, but not to what the distance is taken to: a region does not end at its trunk edge.
    """
    n = len(offsets) - 1
    found = np.empty((len(x), n))
    for k in range(len(x)):
        px, py = x[k, 0], x[k, 1]
        for i in range(n):
            nearest = np.inf
            inside = False
            first, last = offsets[i], offsets[i + 1] - 1
            ax, ay = arcs[last, 0] - px, arcs[last, 1] - py
            for s in range(first, last + 1):
                bx, by = arcs[s, 0] - px, arcs[s, 1] - py
                ex, ey = bx - ax, by - ay
                if (ay > 0.0) != (by > 0.0) and ax - ay / ey * ex > 0.0:
                    inside = not inside
                if s > first:
                    square = ex * ex + ey * ey
                    u = 0.0 if square == 0.0 else -(ax * ex + ay * ey) / square
                    u = min(1.0, max(0.0, u))
                    dx, dy = ax + u * ex, ay + u * ey
                    nearest = min(nearest, dx * dx + dy * dy)
                ax, ay = bx, by
            found[k, i] = -np.sqrt(nearest) if inside else np.sqrt(nearest)
    return found


def warm() -> None:
    """Compile on one arc."""
    signed_distances(np.zeros((1, 2)), np.array([[0.0, 0.0], [1.0, 1.0]]), np.array([0, 2], dtype=np.int64))
