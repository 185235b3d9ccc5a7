"""A triangle mesh of a convex polygon whose boundary vertices lie on the polygon's edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import Delaunay

from riot.shape import FloatArray, IntArray

_BULGE = 1e-5
"""How far, in units of the edge's length, boundary vertices are moved outwards before triangulation, so that rounding
cannot hide one of a row of collinear points behind its neighbours."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles over a convex n-gon.

    Parameters
    ----------
    points : (k, 2) float64
        The first ``len(edge)`` are the boundary, counter-clockwise, from corner 0.
    triangles : (t, 3) int64
    edge : (b,) int64
        Polygon edge of each boundary vertex; a corner belongs to the edge that starts there.
    corners : (n,) int64
        The polygon's corners among the points.
    spacing : float
        Distance of neighbouring grid points.
    """

    points: FloatArray
    triangles: IntArray
    edge: IntArray
    corners: IntArray
    spacing: float


def mesh_convex(polygon: FloatArray, spacing: float) -> Mesh:
    """Mesh a counter-clockwise convex (n, 2) polygon with a triangular grid of the given spacing."""
    boundary, edge, corners = _sample_boundary(polygon, spacing)
    inner = _grid_inside(polygon, spacing)
    points = np.concatenate([boundary, inner])
    bulged = np.concatenate([boundary + _outwards(polygon, boundary, edge), inner])
    triangles = Delaunay(bulged).simplices.astype(np.int64)
    return Mesh(points, triangles, edge, corners, spacing)


def _sample_boundary(polygon: FloatArray, spacing: float) -> tuple[FloatArray, IntArray, IntArray]:
    points, edges, corners = [], [], []
    count = 0
    for k, start in enumerate(polygon):
        step = polygon[(k + 1) % len(polygon)] - start
        parts = max(2, int(np.ceil(np.hypot(*step) / spacing)))
        points.append(start + np.arange(parts)[:, None] / parts * step)
        edges.append(np.full(parts, k))
        corners.append(count)
        count += parts
    return np.concatenate(points), np.concatenate(edges).astype(np.int64), np.array(corners, dtype=np.int64)


def _outwards(polygon: FloatArray, boundary: FloatArray, edge: IntArray) -> FloatArray:
    """A parabola over every edge: strictly convex, zero at the corners."""
    start, stop = polygon[edge], polygon[(edge + 1) % len(polygon)]
    along = stop - start
    lengths = np.hypot(along[:, 0], along[:, 1])
    u = np.hypot(*(boundary - start).T) / lengths
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / lengths[:, None]
    bulge: FloatArray = normal * (4.0 * u * (1.0 - u) * lengths * _BULGE)[:, None]
    return bulge


def _grid_inside(polygon: FloatArray, spacing: float) -> FloatArray:
    """Points of a triangular grid that lie inside, at least half a spacing from every edge.

    The grid hangs on the polygon's first edge, so that the mesh turns with the polygon.
    """
    origin = polygon[0]
    axis = polygon[1] - origin
    axis = axis / np.hypot(*axis)
    frame = np.array([axis, [-axis[1], axis[0]]])
    local = (polygon - origin) @ frame.T
    low, high = local.min(axis=0), local.max(axis=0)
    rows = np.arange(np.floor(low[1] / spacing), np.ceil(high[1] / spacing) / np.sqrt(0.75) + 1)
    columns = np.arange(np.floor(low[0] / spacing) - 1, np.ceil(high[0] / spacing) + 1)
    x = columns[None, :] + 0.5 * np.mod(rows, 2)[:, None]
    y = np.broadcast_to(rows[:, None] * np.sqrt(0.75), x.shape)
    grid = np.stack([x.ravel(), y.ravel()], axis=1) * spacing
    along = np.roll(local, -1, axis=0) - local
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.hypot(along[:, 0], along[:, 1])[:, None]
    depth = (grid[:, None, :] - local[None]) * normal[None]
    inside = (depth.sum(axis=2) > 0.5 * spacing).all(axis=1)
    placed: FloatArray = grid[inside] @ frame + origin
    return placed
