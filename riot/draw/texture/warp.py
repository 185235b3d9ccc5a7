"""Warp: a smooth map of the whole shape that pieces make to the input it stands for (theory §9). Ours.

The boundary comes first (`riot.draw.texture.outline_match`). Inside, the map is harmonic on a triangulation
(`riot.draw.texture.triangulation`), and mended where it folds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy import sparse
from scipy.optimize import linprog
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree

from riot.draw.texture.outline_match import WarpError as WarpError
from riot.draw.texture.outline_match import match_outlines
from riot.draw.texture.triangulation import barycentric, signed_areas, triangulate
from riot.draw.texture.tuning import LEAST_AREA_RATIO, UNFOLD_SWEEPS
from riot.geometry.polyline import is_simple

if TYPE_CHECKING:
    from riot.draw.texture.names import Side
    from riot.geometry.bend import Bend
    from riot.transform.transform import Transform
    from riot.types import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Warp:
    """A piecewise linear map of a assembled shape to its input, both in the unit-area frame of the input.

    Parameters
    ----------
    points : (k, 2) float64
        Of the assembled shape: the first ``boundary`` run counter-clockwise along its outline, its vertices among them.
    images : (k, 2) float64
        Where they are in the input; those of the boundary run once around its outline, its vertices among them.
    triangles : (t, 3) int64
        Counter-clockwise in the assembled shape, which they fill.
    boundary : int
    """

    points: FloatArray
    images: FloatArray
    triangles: IntArray
    boundary: int

    @property
    def folded(self) -> float:
        """Share of the assembled shape's area whose triangles are mirrored in the input; 0 for a proper map."""
        sizes = signed_areas(self.points, self.triangles)
        return float(sizes[signed_areas(self.images, self.triangles) <= 0.0].sum() / sizes.sum())

    def __call__(self, xy: FloatArray) -> FloatArray:
        """Map (m, 2) points of the assembled shape to the input; points outside move as the nearest of the outline."""
        mapped = np.empty_like(xy)
        owner = self._owners(xy)
        inside = owner >= 0
        corners = self.triangles[owner[inside]]
        weights = barycentric(self.points[corners], xy[inside])
        mapped[inside] = np.einsum("mk,mkd->md", weights, self.images[corners])
        if not inside.all():
            mapped[~inside] = self._beyond(xy[~inside])
        return mapped

    def _owners(self, xy: FloatArray) -> IntArray:
        """(m,) the triangle in which each point lies, −1 outside."""
        from matplotlib.tri import Triangulation

        finder = Triangulation(self.points[:, 0], self.points[:, 1], self.triangles).get_trifinder()
        return np.asarray(finder(xy[:, 0], xy[:, 1]), dtype=np.int64)

    def _beyond(self, xy: FloatArray) -> FloatArray:
        """Images of (m, 2) points outside: that of the nearest point on the two edges at the nearest vertex."""
        outline, images = self.points[: self.boundary], self.images[: self.boundary]
        nearest = cKDTree(outline).query(xy)[1]
        mapped, least = np.empty_like(xy), np.full(len(xy), np.inf)
        for beside in (-1, 1):
            other = (nearest + beside) % self.boundary
            edge = outline[other] - outline[nearest]
            share = ((xy - outline[nearest]) * edge).sum(axis=1) / (edge**2).sum(axis=1)
            share = np.clip(share, 0.0, 1.0)[:, None]
            far = ((xy - outline[nearest] - share * edge) ** 2).sum(axis=1)
            moved = images[nearest] + share * (images[other] - images[nearest])
            mapped[far < least] = moved[far < least]
            least = np.minimum(least, far)
        return mapped


def warp_side(transform: Transform, side: Side) -> Warp:
    """The map of the assembled P to the input P (side "p"), or of Q to Q ("q"); a bend of the input is taken back.

    Raises WarpError if the assembled shape's outline crosses itself: such a transform has no certificate. Also if the
    bend of the input cannot be taken back.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> warp = warp_side(exact_transform(dudeney()), "p")
    >>> bool(abs(warp(np.zeros((1, 2)))).max() < 1e-9)  # an exact transform moves nothing
    True
    """
    n = len(transform)
    if side == "p":
        arcs, corners, shape = [len(piece.lower) - 1 for piece in transform.pieces], transform.trunk_p, transform.p
        assembled = transform.outline_p()
    else:
        arcs, shape = [len(piece.upper) - 1 for piece in transform.pieces[::-1]], transform.q
        # Q's outline runs through the chain backwards: its first arc starts at the last piece's end, hinge 0.
        corners, assembled = transform.trunk_q[-np.arange(n) % n], transform.outline_q()
    starts = np.concatenate([[0], np.cumsum(arcs)[:-1]]).astype(np.int64)
    warp = make_warp(assembled, starts, shape.points, corners)
    bend = transform.bend_p if side == "p" else transform.bend_q
    return warp if bend is None else replace(warp, images=_unbent(bend, warp.images))


def make_warp(assembled: FloatArray, starts: IntArray, target: FloatArray, corners: FloatArray) -> Warp:
    """A map between two shapes whose outlines correspond at a few points.

    Parameters
    ----------
    assembled, target : (k, 2) and (m, 2) float64
        Simple counter-clockwise outlines, areas about 1.
    starts : (n,) int64
        Vertices of ``assembled``, in order.
    corners : (n, 2) float64
        Points on ``target`` to which they go, in the same order around.

    Raises
    ------
    WarpError
        If ``assembled`` crosses itself, or the corners are not in order around ``target``.
    """
    if not is_simple(assembled):
        raise WarpError("the outline that the pieces make crosses itself: texture needs a certified transform")
    outline, images = match_outlines(assembled, starts, target, corners)
    points, images, triangles, boundary = triangulate(outline, images)
    images = _unfolded(points, _harmonic(points, images, triangles, boundary), triangles, boundary)
    return Warp(points, images, triangles, boundary)


def _unbent(bend: Bend, points: FloatArray) -> FloatArray:
    """Points (k, 2) of a bent input where they lie before."""
    try:
        images = bend.field.back(points)
    except np.linalg.LinAlgError:
        images = np.full_like(points, np.nan)
    if not np.isfinite(images).all():
        raise WarpError("the map that bends the input folds: texture needs one that can be taken back")
    return images


def _harmonic(points: FloatArray, images: FloatArray, triangles: IntArray, boundary: int) -> FloatArray:
    """(k, 2) images of all points: the given ones on the boundary, harmonic inside (cotangent weights)."""
    size = len(points)
    rows, columns, values = [], [], []
    for k in range(3):
        i, j, o = triangles[:, (k + 1) % 3], triangles[:, (k + 2) % 3], triangles[:, k]
        a, b = points[i] - points[o], points[j] - points[o]
        weight = 0.5 * (a * b).sum(axis=1) / (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
        rows += [i, j, i, j]
        columns += [j, i, i, j]
        values += [-weight, -weight, weight, weight]
    matrix = sparse.csc_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(size, size)
    )
    # The displacement is solved for, so that no displacement gives the identity to the last bit.
    moved = images - points[:boundary]
    inner = splu(matrix[boundary:, boundary:]).solve(np.asarray(-(matrix[boundary:, :boundary] @ moved)))
    harmonic: FloatArray = points + np.concatenate([moved, inner])
    return harmonic


def _unfolded(points: FloatArray, images: FloatArray, triangles: IntArray, boundary: int) -> FloatArray:
    """The images, with the inner corners of mirrored triangles moved one by one.

    A harmonic map may fold a little beside a corner that turns from convex to concave. The areas of the triangles
    around a point are linear in its position: linear programming finds where the least of them, relative to its size,
    is greatest.
    """
    images, sizes = images.copy(), signed_areas(points, triangles)
    best, least = images.copy(), np.inf
    for _ in range(UNFOLD_SWEEPS + 1):
        folded = signed_areas(images, triangles) < LEAST_AREA_RATIO * sizes
        # Where too much is folded sweeps only carry the folds about: the best is kept.
        if float(sizes[folded].sum()) < least:
            best, least = images.copy(), float(sizes[folded].sum())
        moving = np.unique(triangles[folded])
        moving = moving[moving >= boundary]
        if len(moving) == 0:
            break
        for vertex in moving:
            around, corner = np.nonzero(triangles == vertex)
            a = images[triangles[around, (corner + 1) % 3]]
            b = images[triangles[around, (corner + 2) % 3]]
            # Twice the area is cross(a − v, b − v) = cross(a, b) − cross(v, b − a).
            edge = (b - a) / sizes[around, None]
            constant = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / sizes[around]
            rows = np.column_stack([edge[:, 1], -edge[:, 0], np.ones(len(around))])
            box = [(-10.0, 10.0), (-10.0, 10.0), (None, 1.0)]
            solution = linprog([0.0, 0.0, -1.0], A_ub=rows, b_ub=constant, bounds=box)
            if solution.x is not None:
                images[vertex] = solution.x[:2]
    return best
