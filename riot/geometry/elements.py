"""Finite elements of second order on triangles: what is smooth on a shape's interior (ours; the elements are standard).

Every triangle has six nodes, its corners and the middles of its edges; a quantity given at the nodes is a polynomial of
second degree on each triangle, and continuous.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from riot.geometry.triangulation import Triangulation
from riot.types import FloatArray, IntArray

_QUADRATURE = np.array([[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]])
"""Barycentric coordinates of the three points whose mean is exact for polynomials of second degree."""

MASS = (
    np.array(
        [
            [6, -1, -1, -4, 0, 0],
            [-1, 6, -1, 0, -4, 0],
            [-1, -1, 6, 0, 0, -4],
            [-4, 0, 0, 32, 16, 16],
            [0, -4, 0, 16, 32, 16],
            [0, 0, -4, 16, 16, 32],
        ],
        dtype=np.float64,
    )
    / 180.0
)
"""(6, 6) integrals of products of the shape functions over a triangle of unit area."""


@dataclass(frozen=True, eq=False)
class Elements:
    """Triangles with six nodes each.

    Parameters
    ----------
    nodes : (k, 2) float64
    triangles : (t, 6) int64
        The corners, counter-clockwise, and the middles of the edges opposite to them.
    boundary : (2 b,) int64
        Nodes on the outline in its order: a corner, the middle of the edge after it, the next corner …
    """

    nodes: FloatArray
    triangles: IntArray
    boundary: IntArray

    @cached_property
    def gradients(self) -> FloatArray:
        """(t, 3, 6, 2) gradients of the six shape functions at three points of each triangle.

        The mean over the three is exact for products of two.
        """
        return np.asarray(np.einsum("qas,tsx->tqax", _slopes(_QUADRATURE), self._barycentric_gradients))

    @cached_property
    def areas(self) -> FloatArray:
        """(t,) areas of the triangles."""
        a, b, c = (self.nodes[self.triangles[:, corner]] for corner in range(3))
        return np.asarray(0.5 * ((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])))

    @cached_property
    def middles(self) -> FloatArray:
        """(t, 2) centres of the triangles."""
        return np.asarray(self.nodes[self.triangles[:, :3]].mean(axis=1))

    @cached_property
    def _barycentric_gradients(self) -> FloatArray:
        corners = self.nodes[self.triangles[:, :3]]
        opposite = np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)
        inward = np.stack([-opposite[..., 1], opposite[..., 0]], axis=-1)
        return np.asarray(inward / (2.0 * self.areas)[:, None, None])

    @cached_property
    def _tree(self) -> shapely.STRtree:
        return shapely.STRtree(shapely.polygons(self.nodes[self.triangles[:, :3]]))

    def locate(self, points: FloatArray) -> tuple[IntArray, FloatArray]:
        """The triangle (m,) that has each point (m, 2), or is nearest to it, and the point's barycentric coordinates
        (m, 3) there; some are negative outside.

        >>> from riot.geometry.triangulation import triangulate
        >>> _, shares = elements_on(triangulate(house.points)).locate(np.zeros((1, 2)))
        >>> bool((shares >= 0).all())
        True
        """
        which, triangle = self._tree.query_nearest(shapely.points(points))
        # Of several triangles at the same distance the first: the nodes' polynomials agree on a common edge.
        first = np.full(len(points), len(self.triangles), dtype=np.int64)
        np.minimum.at(first, which, triangle)
        return first, self._shares(first, points)

    def weights(self, points: FloatArray) -> tuple[IntArray, FloatArray]:
        """Six nodes (m, 6) and their weights (m, 6): a quantity at ``points`` (m, 2) is the weighted sum of the nodes'.

        >>> from riot.geometry.triangulation import triangulate
        >>> elements = elements_on(triangulate(house.points))
        >>> nodes, weights = elements.weights(np.array([[0.1, 0.2]]))
        >>> np.einsum("ma,max->mx", weights, elements.nodes[nodes]).round(9).tolist()
        [[0.1, 0.2]]
        """
        triangle, shares = self.locate(points)
        return self.triangles[triangle], _values(shares)

    def gradient_weights(self, points: FloatArray) -> tuple[IntArray, FloatArray]:
        """Six nodes (m, 6) and the gradients (m, 6, 2) of their weights at ``points`` (m, 2).

        >>> from riot.geometry.triangulation import triangulate
        >>> elements = elements_on(triangulate(house.points))
        >>> nodes, slopes = elements.gradient_weights(np.array([[0.1, 0.2]]))
        >>> gradient = np.einsum("max,may->mxy", elements.nodes[nodes], slopes)  # of the identity
        >>> bool(np.abs(gradient - np.eye(2)).max() < 1e-9)
        True
        """
        triangle, shares = self.locate(points)
        return self.triangles[triangle], self._gradients(triangle, shares)

    def weights_in(self, triangle: IntArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Weights (m, 6), and their gradients (m, 6, 2), at points (m, 2) by the polynomials of given triangles (m,).

        >>> from riot.geometry.triangulation import triangulate
        >>> elements = elements_on(triangulate(house.points))
        >>> weights, _ = elements.weights_in(np.array([0]), elements.nodes[elements.triangles[:1, 4]])
        >>> np.abs(weights).round(9).tolist()
        [[0.0, 0.0, 0.0, 0.0, 1.0, 0.0]]
        """
        shares = self._shares(triangle, points)
        return _values(shares), self._gradients(triangle, shares)

    def _shares(self, triangle: IntArray, points: FloatArray) -> FloatArray:
        offset = points - self.middles[triangle]
        return np.asarray(1.0 / 3.0 + np.einsum("msx,mx->ms", self._barycentric_gradients[triangle], offset))

    def _gradients(self, triangle: IntArray, shares: FloatArray) -> FloatArray:
        return np.asarray(np.einsum("mas,msx->max", _slopes(shares), self._barycentric_gradients[triangle]))

    def moved(self, nodes: FloatArray) -> Elements:
        """The same triangles with straight edges between corners moved to ``nodes`` (k, 2).

        >>> from riot.geometry.triangulation import triangulate
        >>> elements = elements_on(triangulate(house.points))
        >>> round(float(elements.moved(2.0 * elements.nodes).areas.sum()), 9)
        4.0
        """
        straight = nodes.copy()
        for corner in range(3):
            ends = self.triangles[:, [(corner + 1) % 3, (corner + 2) % 3]]
            straight[self.triangles[:, 3 + corner]] = 0.5 * (nodes[ends[:, 0]] + nodes[ends[:, 1]])
        return Elements(straight, self.triangles, self.boundary)


def elements_on(mesh: Triangulation) -> Elements:
    """Put nodes on the corners and the middles of the edges of a triangulation.

    >>> from riot.geometry.triangulation import triangulate
    >>> round(float(elements_on(triangulate(house.points)).areas.sum()), 6)
    1.0
    """
    corners, count = mesh.triangles, len(mesh.points)
    ends = np.concatenate([corners[:, [1, 2]], corners[:, [2, 0]], corners[:, [0, 1]]])
    ends.sort(axis=1)
    keys, edge = np.unique(ends[:, 0] * count + ends[:, 1], return_inverse=True)
    first, second = np.divmod(keys, count)
    nodes = np.concatenate([mesh.points, 0.5 * (mesh.points[first] + mesh.points[second])])
    start = np.arange(mesh.boundary)
    stop = (start + 1) % mesh.boundary
    between = count + np.searchsorted(keys, np.minimum(start, stop) * count + np.maximum(start, stop))
    return Elements(
        nodes,
        np.concatenate([corners, count + edge.reshape(3, -1).T], axis=1),
        np.column_stack([start, between]).ravel(),
    )


def _values(shares: FloatArray) -> FloatArray:
    """(m, 6) shape functions at barycentric coordinates (m, 3)."""
    others = np.roll(shares, -1, axis=1) * np.roll(shares, 1, axis=1)
    return np.concatenate([shares * (2.0 * shares - 1.0), 4.0 * others], axis=1)


def _slopes(shares: FloatArray) -> FloatArray:
    """(m, 6, 3) derivatives of the shape functions by the barycentric coordinates (m, 3)."""
    slopes = np.zeros((len(shares), 6, 3))
    for corner in range(3):
        following, before = (corner + 1) % 3, (corner + 2) % 3
        slopes[:, corner, corner] = 4.0 * shares[:, corner] - 1.0
        slopes[:, 3 + corner, following] = 4.0 * shares[:, before]
        slopes[:, 3 + corner, before] = 4.0 * shares[:, following]
    return slopes
