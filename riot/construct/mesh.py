"""A triangle mesh of a convex polygon: rings around its middle, whose last is the polygon itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from riot.polyline import signed_area
from riot.shape import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles over a convex n-gon.

    Parameters
    ----------
    points : (k, 2) float64
        The first ``len(edge)`` are the boundary, counter-clockwise, from corner 0; the last is the middle.
    triangles : (t, 3) int64
        Counter-clockwise.
    edge : (b,) int64
        Polygon edge of each boundary vertex; a corner belongs to the edge that starts there.
    corners : (n,) int64
        The polygon's corners among the points.
    spacing : float
        Typical distance of neighbouring points.
    """

    points: FloatArray
    triangles: IntArray
    edge: IntArray
    corners: IntArray
    spacing: float


def mesh_convex(polygon: FloatArray, spacing: float) -> Mesh:
    """Mesh a counter-clockwise convex (n, 2) polygon with about as many points as a grid of the given spacing has.

    The triangles between the polygon's middle and its edges are all divided alike, into r² similar ones, so that they
    fit together and need no search: the mesh turns, moves and grows with the polygon.
    """
    n = len(polygon)
    triangle = np.sqrt(0.1875) * spacing**2  # half a cell of the triangular grid
    rings = max(4, int(np.ceil(np.sqrt(signed_area(polygon) / (n * triangle)))))
    middle = polygon.mean(axis=0)
    spokes = polygon - middle
    # Ring r has r points on each side, from spoke to spoke; rings are listed from the outermost inwards.
    points = [_ring(spokes, r, rings) for r in range(rings, 0, -1)]
    first = n * (rings * (rings + 1) - np.arange(rings + 2) * (np.arange(rings + 2) + 1)) // 2
    # first[r] is where ring r + 1's points end, that is where ring r's begin.
    triangles = [_between(n, r, int(first[r]), int(first[r + 1])) for r in range(rings)]
    placed = middle + np.concatenate([*points, np.zeros((1, 2))])
    corners = np.arange(n) * rings
    placed[corners] = polygon  # to the last bit: the dissection's leaves are here
    return Mesh(placed, np.concatenate(triangles), np.repeat(np.arange(n), rings), corners, spacing)


def _ring(spokes: FloatArray, r: int, rings: int) -> FloatArray:
    """(n r, 2) points of ring r, relative to the middle."""
    share = np.arange(r)[None, :, None]
    onward = np.roll(spokes, -1, axis=0)
    ring: FloatArray = ((r - share) * spokes[:, None] + share * onward[:, None]) / rings
    return ring.reshape(-1, 2)


def _between(n: int, r: int, inner: int, outer: int) -> IntArray:
    """Triangles between ring r, whose points start at ``inner``, and ring r + 1, whose points start at ``outer``."""
    side = np.repeat(np.arange(n), r + 1)
    step = np.tile(np.arange(r + 1), n)
    within = inner + (side * r + step) % max(n * r, 1)
    beyond = outer + side * (r + 1) + step
    after = outer + (side * (r + 1) + step + 1) % (n * (r + 1))
    outwards = np.stack([within, beyond, after], axis=1)
    rest = step < r
    following = inner + (side * r + step + 1) % max(n * r, 1)
    inwards = np.stack([within, after, following], axis=1)[rest]
    return np.concatenate([outwards, inwards]).astype(np.int64)
