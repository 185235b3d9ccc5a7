"""A regular mesh over a convex polygon: concentric rings of its own shape (theory §8, ours)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from riot.construction.tuning import LEAST_RINGS
from riot.geometry.polyline import signed_area
from riot.kernels.dissection import ring_mesh
from riot.types import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles over a convex n-gon.

    Parameters
    ----------
    points : (k, 2) float64
        Rings around the polygon's middle, from the outermost inwards, each counter-clockwise from the spoke of corner
        0, with as many points on every side as the ring's number. The first n · ``rings`` are the boundary; the last
        is the middle.
    triangles : (t, 3) int64
        Counter-clockwise.
    rings : int
        How many rings there are, and into how many equal segments every edge of the polygon is divided.
    corners : (n,) int64
        The polygon's corners among the points.
    spacing : float
        Typical distance of neighbouring points.
    """

    points: FloatArray
    triangles: IntArray
    rings: int
    corners: IntArray
    spacing: float

    @property
    def edge(self) -> IntArray:
        """(n · rings,) polygon edge of each boundary vertex; a corner belongs to the edge that starts there."""
        return np.repeat(np.arange(len(self.corners)), self.rings)


def mesh_convex(polygon: FloatArray, spacing: float) -> Mesh:
    """Mesh a counter-clockwise convex (n, 2) polygon with about as many points as a grid of the given spacing has.

    The triangles between the polygon's middle and its edges are all divided alike, into r² similar ones, so that they
    fit together and need no search: the mesh turns, moves and grows with the polygon.

    >>> mesh = mesh_convex(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), 0.1)
    >>> bool(mesh.points.shape[0] > 100)
    True
    """
    n = len(polygon)
    triangle = np.sqrt(0.1875) * spacing**2  # half a cell of the triangular grid
    rings = max(LEAST_RINGS, int(np.ceil(np.sqrt(signed_area(polygon) / (n * triangle)))))
    # The dissection's leaves are the corners: they are kept to the last bit.
    points, triangles = ring_mesh(np.ascontiguousarray(polygon), polygon.mean(axis=0), rings)
    return Mesh(points, triangles, rings, np.arange(n) * rings, spacing)
