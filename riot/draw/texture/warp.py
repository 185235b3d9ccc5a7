"""Warp: a smooth map of the whole shape that pieces make to the input it is meant to be (theory §9). Ours.

The boundary comes first: every arc of the made outline is matched with the input's arc between the same two trunk
corners, monotonely, near points with near points. Inside, the map is harmonic on a triangulation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import shapely
from scipy import sparse
from scipy.optimize import linprog
from scipy.sparse.linalg import splu
from scipy.spatial import Delaunay, cKDTree

from riot.errors import RiotError
from riot.geometry.polyline import arc_length, at_length, is_simple

if TYPE_CHECKING:
    from riot.draw.texture.names import Side
    from riot.transform.transform import Transform
    from riot.types import FloatArray, IntArray

SPACING = 0.022
"""Distance of the triangulation's points, in the unit-area frame: some 2,500 points a shape."""

MATCH_STEP = 0.012
"""Arcs are matched at points so far apart."""

CALM = 1e-5
"""What a step costs that stretches one arc against the other, as a squared distance: ties go to even arc length."""

ROUNDS = 40
"""Rounds in which boundary edges are split until the triangulation has them all."""

SWEEPS = 12
"""Most sweeps over the points of triangles that lie wrong way round."""

LEAST = 1e-3
"""A triangle that shrinks by more than this counts as lying wrong way round, and is mended."""

_STEPS = ((1, 1), (1, 2), (2, 1), (1, 3), (3, 1))
"""Steps (made, input) of a match; an arc is stretched against the other by three at most, and never stands still."""


class WarpError(RiotError, ValueError):
    """Outlines between which no map can be made."""


@dataclass(frozen=True, eq=False)
class Warp:
    """A piecewise linear map of a made shape to its input, both in the unit-area frame of the input.

    Parameters
    ----------
    points : (k, 2) float64
        Of the made shape: the first ``boundary`` run counter-clockwise along its outline, its vertices among them.
    images : (k, 2) float64
        Where they are in the input; those of the boundary run once around its outline, its vertices among them.
    triangles : (t, 3) int64
        Counter-clockwise in the made shape, which they fill.
    boundary : int
    """

    points: FloatArray
    images: FloatArray
    triangles: IntArray
    boundary: int

    @property
    def folded(self) -> float:
        """Share of the made shape, by area, whose triangles lie in the input wrong way round; 0 for a proper map."""
        sizes = _areas(self.points, self.triangles)
        return float(sizes[_areas(self.images, self.triangles) <= 0.0].sum() / sizes.sum())

    def __call__(self, xy: FloatArray) -> FloatArray:
        """Map (m, 2) points of the made shape to the input; points outside move as the nearest place of the outline."""
        found = np.empty_like(xy)
        owner = self._owners(xy)
        inside = owner >= 0
        corners = self.triangles[owner[inside]]
        weights = _barycentric(self.points[corners], xy[inside])
        found[inside] = np.einsum("mk,mkd->md", weights, self.images[corners])
        if not inside.all():
            found[~inside] = self._beyond(xy[~inside])
        return found

    def _owners(self, xy: FloatArray) -> IntArray:
        """(m,) the triangle that holds each point, −1 outside."""
        from matplotlib.tri import Triangulation

        finder = Triangulation(self.points[:, 0], self.points[:, 1], self.triangles).get_trifinder()
        return np.asarray(finder(xy[:, 0], xy[:, 1]), dtype=np.int64)

    def _beyond(self, xy: FloatArray) -> FloatArray:
        """Where (m, 2) points outside the made shape go: the image of the nearest place beside the nearest vertex."""
        outline, images = self.points[: self.boundary], self.images[: self.boundary]
        nearest = cKDTree(outline).query(xy)[1]
        found, least = np.empty_like(xy), np.full(len(xy), np.inf)
        for beside in (-1, 1):
            other = (nearest + beside) % self.boundary
            edge = outline[other] - outline[nearest]
            share = ((xy - outline[nearest]) * edge).sum(axis=1) / (edge**2).sum(axis=1)
            share = np.clip(share, 0.0, 1.0)[:, None]
            far = ((xy - outline[nearest] - share * edge) ** 2).sum(axis=1)
            moved = images[nearest] + share * (images[other] - images[nearest])
            found[far < least] = moved[far < least]
            least = np.minimum(least, far)
        return found


def warp_side(transform: Transform, side: Side) -> Warp:
    """The map of the assembled P to the input P (side "p"), or of Q to Q ("q").

    Raises WarpError if the assembled shape's outline crosses itself: such a transform has no certificate.
    """
    n = len(transform)
    if side == "p":
        arcs, corners, shape = [len(piece.lower) - 1 for piece in transform.pieces], transform.trunk_p, transform.p
        made = transform.outline_p()
    else:
        arcs, shape = [len(piece.upper) - 1 for piece in transform.pieces[::-1]], transform.q
        # Q's outline runs through the chain backwards: its first arc starts at the last piece's end, hinge 0.
        corners, made = transform.trunk_q[-np.arange(n) % n], transform.outline_q()
    starts = np.concatenate([[0], np.cumsum(arcs)[:-1]]).astype(np.int64)
    return make_warp(made, starts, shape.points, corners)


def make_warp(made: FloatArray, starts: IntArray, target: FloatArray, corners: FloatArray) -> Warp:
    """A map between two shapes whose outlines correspond at a few points.

    Parameters
    ----------
    made, target : (k, 2) and (m, 2) float64
        Simple counter-clockwise outlines, areas about 1.
    starts : (n,) int64
        Vertices of ``made``, in order.
    corners : (n, 2) float64
        Points on ``target`` to which they go, in the same order around.

    Raises
    ------
    WarpError
        If ``made`` crosses itself, or the corners are not in order around ``target``.
    """
    if not is_simple(made):
        raise WarpError("the outline that the pieces make crosses itself: texture needs a certified transform")
    outline, images = match_outlines(made, starts, target, corners)
    points, images, triangles, boundary = _triangulation(outline, images)
    images = _unfolded(points, _harmonic(points, images, triangles, boundary), triangles, boundary)
    return Warp(points, images, triangles, boundary)


def match_outlines(
    made: FloatArray, starts: IntArray, target: FloatArray, corners: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Matched points of two outlines: (k, 2) on ``made`` and (k, 2) on ``target``, the vertices of both among them.

    Arguments and errors as `make_warp`. Both run around once, counter-clockwise; between the points both outlines are
    straight.
    """
    lengths, around = arc_length(made), arc_length(target)
    at = np.asarray(shapely.line_locate_point(shapely.LinearRing(target), shapely.points(corners)))
    begin = np.concatenate([lengths[starts], [lengths[starts[0]] + lengths[-1]]])
    steps = np.mod(np.diff(np.concatenate([at, at[:1]])), around[-1])
    if len(at) == 1:
        steps[:] = around[-1]
    if abs(float(steps.sum()) - around[-1]) > 1e-9 * around[-1] or not (steps > 0.0).all():
        raise WarpError("the trunk's corners are not in order on the input's outline: no texture can follow them")
    end = at[0] + np.concatenate([[0.0], np.cumsum(steps)])
    s, u = [begin[:1]], [end[:1]]
    for k in range(len(starts)):
        count = max(8, int(np.ceil(max(begin[k + 1] - begin[k], end[k + 1] - end[k]) / MATCH_STEP)))
        here = np.linspace(begin[k], begin[k + 1], count + 1)
        there = np.linspace(end[k], end[k + 1], count + 1)
        match = _aligned(at_length(made, here), at_length(target, there))
        s.append(here[1:])
        u.append(np.interp(match[1:], np.arange(count + 1), there))
    return _common(made, np.concatenate(s), target, np.concatenate(u))


def _aligned(a: FloatArray, b: FloatArray) -> FloatArray:
    """(k,) strictly increasing positions among b's k points for those of a, least in squared distance (dynamic
    programming over `_STEPS`), then smoothed; ends go to ends."""
    count = len(a)
    cost = ((a[:, None] - b[None]) ** 2).sum(axis=2)
    total = np.full((count, count), np.inf)
    choice = np.zeros((count, count), dtype=np.int8)
    total[0, 0] = 0.0
    for i in range(1, count):
        for kind, (di, dj) in enumerate(_STEPS):
            if i < di:
                continue
            way = 0.5 * (di + dj) * cost[i, dj:] + (di != dj) * CALM
            reached = total[i - di, : count - dj] + way
            better = reached < total[i, dj:]
            total[i, dj:][better] = reached[better]
            choice[i, dj:][better] = kind
    i = j = count - 1
    knots = [(i, j)]
    while i > 0:
        di, dj = _STEPS[choice[i, j]]
        i, j = i - di, j - dj
        knots.append((i, j))
    here, there = np.array(knots[::-1], dtype=np.float64).T
    found = np.interp(np.arange(count), here, there)
    # Mirrored about both ends, a moving mean leaves straight lines and the ends as they are.
    reach = min(3, count - 1)
    padded = np.concatenate([2 * found[0] - found[reach:0:-1], found, 2 * found[-1] - found[-2 : -2 - reach : -1]])
    width = 2 * reach + 1
    return np.convolve(padded, np.full(width, 1.0 / width), mode="valid")


def _common(made: FloatArray, s: FloatArray, target: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points of both outlines at the vertices of either, given matched positions s and u, (k,), increasing."""
    lengths, around = arc_length(made), arc_length(target)
    own = np.sort(_unrolled(lengths[:-1], s[0], lengths[-1]))
    other = np.sort(_unrolled(around[:-1], u[0], around[-1]))
    from_own = np.column_stack([own, np.interp(own, s, u)])
    from_other = np.column_stack([np.interp(other, u, s), other])
    # Vertices of both that nearly match are matched: two points so close would only make slivers.
    nearest = np.abs(from_own[:, :1] - from_other[None, :, 0]).argmin(axis=0)
    close = np.abs(from_own[nearest, 0] - from_other[:, 0]) < 0.1 * SPACING
    first = np.zeros(len(other), dtype=np.bool_)
    first[np.unique(np.where(close, nearest, -1 - np.arange(len(other))), return_index=True)[1]] = True
    joined = close & first
    from_own[nearest[joined], 1] = other[joined]
    both = np.concatenate([from_own, from_other[~joined]])
    both = both[np.lexsort((both[:, 1], both[:, 0]))]
    both[:, 1] = np.maximum.accumulate(both[:, 1])
    parts = np.diff(np.concatenate([both, both[:1] + np.array([lengths[-1], around[-1]])]), axis=0)
    keep = (parts > 1e-9).all(axis=1)
    both, parts = both[keep], parts[keep]
    pieces = np.maximum(1, np.ceil(parts.max(axis=1) / SPACING)).astype(np.int64)
    index = np.repeat(np.arange(len(both)), pieces)
    share = (np.arange(len(index)) - np.repeat(np.cumsum(pieces) - pieces, pieces)) / pieces[index]
    fine = both[index] + share[:, None] * parts[index]
    return at_length(made, fine[:, 0]), at_length(target, fine[:, 1])


def _unrolled(positions: FloatArray, first: float, period: float) -> FloatArray:
    return first + np.mod(positions - first, period)


def _triangulation(outline: FloatArray, images: FloatArray) -> tuple[FloatArray, FloatArray, IntArray, int]:
    """Points, images (of the boundary), triangles and the number of boundary points of a triangulated outline.

    Delaunay's, with edges of the outline split in the middle until all are there.
    """
    inner = _grid(outline)
    for turn in range(ROUNDS):
        m = len(outline)
        points = np.concatenate([outline, inner])
        triangles = _inside(points, Delaunay(points).simplices.astype(np.int64), outline)
        edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        rim = np.sort(np.column_stack([np.arange(m), (np.arange(m) + 1) % m]), axis=1)
        size = len(points)
        missing = ~np.isin(rim[:, 0] * size + rim[:, 1], edges[:, 0] * size + edges[:, 1])
        # An inner edge between two boundary points could not bend; its middle becomes a point.
        chords = np.unique(edges[(edges < m).all(axis=1)], axis=0)
        chords = chords[~np.isin(chords[:, 0] * size + chords[:, 1], rim[:, 0] * size + rim[:, 1])]
        if not missing.any() and (len(chords) == 0 or turn > ROUNDS // 2):
            return points, images, triangles, m
        if missing.any():
            places = np.flatnonzero(missing)
            outline = _halved(outline, places)
            images = _halved(images, places)
        elif len(chords):
            inner = np.concatenate([inner, 0.5 * (outline[chords[:, 0]] + outline[chords[:, 1]])])
    raise WarpError("the outline that the pieces make is too sharp to be triangulated")


def _halved(points: FloatArray, places: IntArray) -> FloatArray:
    """A polygon with the middles of the edges at ``places`` as vertices."""
    middles = 0.5 * (points[places] + points[(places + 1) % len(points)])
    return np.insert(points, places + 1, middles, axis=0)


def _grid(outline: FloatArray) -> FloatArray:
    """(k, 2) a triangular grid inside, not near the outline."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    rise = 0.5 * np.sqrt(3.0) * SPACING
    rows = np.arange(int((high[1] - low[1]) / rise) + 1)
    columns = np.arange(int((high[0] - low[0]) / SPACING) + 2)
    x = low[0] + SPACING * (columns[None] - 0.5 * (rows % 2)[:, None])
    y = np.broadcast_to((low[1] + rise * (rows + 0.5))[:, None], x.shape)
    points = np.column_stack([x.ravel(), y.ravel()])
    region = shapely.Polygon(outline)
    shapely.prepare(region)
    points = points[shapely.contains_xy(region, points)]
    ring = shapely.LinearRing(outline)
    shapely.prepare(ring)
    kept: FloatArray = points[shapely.distance(ring, shapely.points(points)) > 0.6 * SPACING]
    return kept


def _inside(points: FloatArray, triangles: IntArray, outline: FloatArray) -> IntArray:
    """The triangles whose middles are inside the outline, counter-clockwise."""
    region = shapely.Polygon(outline)
    shapely.prepare(region)
    triangles = triangles[shapely.contains_xy(region, points[triangles].mean(axis=1))]
    turned = _areas(points, triangles) < 0.0
    triangles[turned] = triangles[turned][:, ::-1]
    return triangles[_areas(points, triangles) > 1e-14]


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
    found: FloatArray = points + np.concatenate([moved, inner])
    return found


def _unfolded(points: FloatArray, images: FloatArray, triangles: IntArray, boundary: int) -> FloatArray:
    """The images with the inner corners of triangles that lie wrong way round moved, one by one.

    A harmonic map may fold a little beside a corner that turns from convex to concave. The areas of the triangles
    around a point are linear in its place: linear programming finds where the least, relative to its size, is greatest.
    """
    images, sizes = images.copy(), _areas(points, triangles)
    best, least = images.copy(), np.inf
    for _ in range(SWEEPS + 1):
        folded = _areas(images, triangles) < LEAST * sizes
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
            found = linprog([0.0, 0.0, -1.0], A_ub=rows, b_ub=constant, bounds=box)
            if found.x is not None:
                images[vertex] = found.x[:2]
    return best


def _areas(points: FloatArray, triangles: IntArray) -> FloatArray:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    sizes: FloatArray = 0.5 * ((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))
    return sizes


def _barycentric(corners: FloatArray, xy: FloatArray) -> FloatArray:
    """(m, 3) weights of points in their triangles, (m, 3, 2)."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]

    def cross(u: FloatArray, v: FloatArray) -> FloatArray:
        return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]

    whole = cross(b - a, c - a)
    second, third = cross(xy - a, c - a) / whole, cross(b - a, xy - a) / whole
    return np.column_stack([1.0 - second - third, second, third])
