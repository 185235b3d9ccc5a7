"""A triangulation of a shape's interior, as coarse as limbs and inner corners let it be (ours).

Vertices are some of the outline's points, and points of a triangular grid in the interior. The outline is followed
where that matters: a chord keeps to its section of outline within a share of the width of the shape there, so that a
thin limb has its width. Triangles are small at concave corners, where strain concentrates.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from scipy.spatial import Delaunay

from riot.errors import SilhouetteError
from riot.geometry import polyline
from riot.types import BoolArray, FloatArray, IntArray
from riot.units import L_C

SPACING = L_C / 22.0
"""Length: distance of interior points where nothing asks for less. With elements of second order the sixteen softest
modes need no finer ones."""

TOLERANCE = L_C / 350.0
"""Length: Douglas–Peucker tolerance of the chords that the triangulation begins with."""

WIDTH_SHARE = 0.04
"""A chord lies this close to its section of outline, as a share of the height of the triangle on it."""

ASPECT = 4.0
"""A boundary edge is no longer than so many heights of the triangle on it: thin limbs bend in waves."""

CONCAVE_TURN = 0.4
"""Radians: a vertex that turns inwards by more is a concave corner."""

LEVELS = 3
"""How often the spacing is halved towards a concave corner."""

LEVEL_REACH = 0.7
"""Spacings of the level before: so far from a concave corner a level reaches."""

CLEARANCE = 0.25
"""Spacings: an interior point keeps this distance from the outline."""

LONGEST_EDGE = 1.3
"""Spacings of its level: a longer boundary edge near a concave corner is divided."""

LEAST_TRIANGLE = 1e-9
"""Area: what is smaller lies on a straight side and is no triangle."""

MOST_POINTS = 20_000
"""Points of a boundary at most; a shape's outline has some hundreds."""

MOST_ROUNDS = 40
"""Rounds of division; an outline that never appears among the edges is refused. Some five are usual."""


@dataclass(frozen=True, eq=False)
class Triangulation:
    """Triangles that tile a polygon which follows a shape's outline.

    Parameters
    ----------
    points : (k, 2) float64
        The first ``boundary`` are on the outline, in its order; the others inside.
    triangles : (t, 3) int64
        Counter-clockwise.
    boundary : int
        How many points are on the outline; every two consecutive ones are an edge.
    """

    points: FloatArray
    triangles: IntArray
    boundary: int


def triangulate(outline: FloatArray) -> Triangulation:
    """Triangulate the interior of a simple counter-clockwise outline (m, 2) of unit area about the origin (ours).

    The grid is laid along the direction of the first point, so that the triangulation turns with the outline. Raises
    SilhouetteError ``degenerate`` if triangles cannot follow the outline: it is too thin somewhere for its coordinates.

    >>> mesh = triangulate(house.points)
    >>> 20 < len(mesh.triangles) < 200
    True
    """
    kept = polyline.spread(outline, polyline.simplify(outline, TOLERANCE), SPACING)
    corners = outline[kept][polyline.interior_angles(outline[kept]) > np.pi + CONCAVE_TURN]
    kept = _graded(outline, kept, corners)
    inner = _interior_points(outline, corners)
    for _ in range(MOST_ROUNDS):
        boundary = outline[kept]
        points = np.concatenate([boundary, inner])
        triangles, doubled = _inside_triangles(points, boundary)
        lengths = polyline.edge_lengths(boundary)
        heights, missing = _heights(triangles, doubled, lengths)
        counts = np.diff(np.append(kept, kept[0] + len(outline)))
        off = _deviations(outline, kept, counts)
        across = np.where(missing, np.inf, heights)
        pieces = np.ceil(np.maximum(np.sqrt(off / (WIDTH_SHARE * across)), lengths / (ASPECT * across)))
        pieces = np.maximum(pieces, np.where(missing, 2, 1)).astype(np.int64)
        if (pieces[counts > 1] > 1).any():
            # First, since chords that cross each other hide edges that are there.
            kept = _divided(len(outline), kept, counts, np.minimum(pieces, counts))
        elif missing.any():
            outline, kept = _with_middles(outline, kept, np.flatnonzero(missing))
        else:
            return Triangulation(points, triangles, len(boundary))
        if len(kept) > MOST_POINTS:
            break
    raise SilhouetteError("degenerate", "the outline is too thin somewhere to be filled with triangles")


def _graded(outline: FloatArray, kept: IntArray, corners: FloatArray) -> IntArray:
    """The kept points, with more of the outline's near concave corners."""
    if len(corners) == 0:
        return kept
    for level in range(1, LEVELS + 1):
        boundary = outline[kept]
        middles = 0.5 * (boundary + polyline.shifted(boundary, 1))
        spacing = SPACING / 2**level
        split = polyline.edge_lengths(boundary) > LONGEST_EDGE * spacing
        split &= _near(middles, corners, 2.0 * LEVEL_REACH * spacing)
        counts = np.diff(np.append(kept, kept[0] + len(outline)))
        kept = _divided(len(outline), kept, counts, np.where(split, np.minimum(2, counts), 1))
    return kept


def _interior_points(outline: FloatArray, corners: FloatArray) -> FloatArray:
    """Points of triangular grids, finer near concave corners."""
    region, ring = shapely.Polygon(outline), shapely.LinearRing(outline)
    shapely.prepare(region)
    points, spacings = _grid(outline, SPACING), SPACING
    sizes = np.full(len(points), SPACING)
    for level in range(1, LEVELS + 1 if len(corners) else 1):
        spacings, reach = SPACING / 2**level, 2.0 * LEVEL_REACH * SPACING / 2**level
        fine = _grid(outline, spacings)
        fine = fine[_near(fine, corners, reach)]
        far = ~_near(points, corners, reach)
        points = np.concatenate([points[far], fine])
        sizes = np.concatenate([sizes[far], np.full(len(fine), spacings)])
    inside = shapely.contains_xy(region, points)
    points, sizes = points[inside], sizes[inside]
    distance: FloatArray = shapely.distance(ring, shapely.points(points))
    return np.asarray(points[distance > CLEARANCE * sizes])


def _grid(outline: FloatArray, spacing: float) -> FloatArray:
    """A triangular grid over the outline's box, laid along the direction of its first point."""
    x, y = outline[0] / np.hypot(*outline[0])
    turn = np.array([[x, -y], [y, x]])
    local = outline @ turn
    low, high = local.min(axis=0), local.max(axis=0)
    row_height = np.sqrt(0.75) * spacing
    columns, rows = np.ceil((high - low) / [spacing, row_height]).astype(int) + 1
    row, column = np.divmod(np.arange(rows * columns), columns)
    grid = np.column_stack([spacing * (column + 0.5 * (row % 2)), row_height * (row + 0.5)])
    return np.asarray((low + grid) @ turn.T)


def _near(points: FloatArray, corners: FloatArray, reach: float) -> BoolArray:
    near = np.zeros(len(points), dtype=np.bool_)
    for corner in corners:
        offset = points - corner
        near |= offset[:, 0] * offset[:, 0] + offset[:, 1] * offset[:, 1] < reach * reach
    return near


def _inside_triangles(points: FloatArray, boundary: FloatArray) -> tuple[IntArray, FloatArray]:
    """Delaunay triangles inside a polygon, counter-clockwise, and their doubled areas."""
    triangles = Delaunay(points).simplices.astype(np.int64)
    a, b, c = points[triangles[:, 0]], points[triangles[:, 1]], points[triangles[:, 2]]
    doubled = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    backwards = doubled < 0.0
    triangles[backwards] = triangles[backwards][:, [0, 2, 1]]
    region = shapely.Polygon(boundary)
    shapely.prepare(region)
    middles = (a + b + c) / 3.0
    keep = shapely.contains_xy(region, middles) & (np.abs(doubled) > 2.0 * LEAST_TRIANGLE)
    return triangles[keep], np.abs(doubled[keep])


def _heights(triangles: IntArray, doubled: FloatArray, lengths: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Height of the triangle on each boundary edge, and whether there is none."""
    count = len(lengths)
    heights, missing = np.zeros(count), np.ones(count, dtype=np.bool_)
    for side in range(3):
        start, stop = triangles[:, side], triangles[:, (side + 1) % 3]
        on = (start < count) & (stop == (start + 1) % count)
        heights[start[on]] = doubled[on] / lengths[start[on]]
        missing[start[on]] = False
    return heights, missing


def _deviations(outline: FloatArray, kept: IntArray, counts: IntArray) -> FloatArray:
    """Greatest distance of the outline from the line through each chord between kept points."""
    order = (kept[0] + np.arange(len(outline))) % len(outline)
    chord = np.repeat(np.arange(len(kept)), counts)
    start = outline[kept]
    ahead = polyline.shifted(start, 1) - start
    ahead /= np.hypot(ahead[:, 0], ahead[:, 1])[:, None]
    offset, along = outline[order] - start[chord], ahead[chord]
    off = np.abs(along[:, 0] * offset[:, 1] - along[:, 1] * offset[:, 0])
    return np.asarray(np.maximum.reduceat(off, np.concatenate([[0], np.cumsum(counts)[:-1]])))


def _divided(size: int, kept: IntArray, counts: IntArray, pieces: IntArray) -> IntArray:
    """The kept points, with more where a chord over so many edges of the outline is divided into so many pieces."""
    chord = np.repeat(np.arange(len(kept)), pieces)
    number = np.arange(len(chord)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    return np.asarray(np.sort((kept[chord] + number * counts[chord] // pieces[chord]) % size))


def _with_middles(outline: FloatArray, kept: IntArray, bare: IntArray) -> tuple[FloatArray, IntArray]:
    """Outline and kept points with the middles of the outline's edges that begin at kept points ``bare``."""
    edges = kept[bare]
    middles = 0.5 * (outline[edges] + outline[(edges + 1) % len(outline)])
    longer = np.insert(outline, edges + 1, middles, axis=0)
    moved = kept + np.searchsorted(edges, kept, side="left")
    return longer, np.sort(np.concatenate([moved, moved[bare] + 1]))
