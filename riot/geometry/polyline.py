"""Polygons and polylines as (m, 2) arrays: measures, simplification, sampling.

A *polygon* is closed: each vertex stands once, and the last joins the first. A *polyline* is open.
Coordinates are finite float64; nothing here requires unit area. Functions are pure and return new arrays.
"""

from __future__ import annotations

import numpy as np
import shapely

from riot import kernels  # lazy: a polygon that nothing simplifies does not wait for Numba
from riot.types import BoolArray, FloatArray, IntArray

TOUCH = 1e-9
"""Distance below which a segment touches the boundary instead of passing it, in the unit-area frame. Ours: far above
rounding, far below any length that is seen."""


def shifted(values: FloatArray, by: int) -> FloatArray:
    """Values of a polygon's vertices, (m, …), from vertex ``by`` on: `numpy.roll` by as much the other way, quicker.

    >>> shifted(np.array([1.0, 2.0, 3.0]), 1).tolist()
    [2.0, 3.0, 1.0]
    """
    return np.concatenate([values[by:], values[:by]])


def extent(points: FloatArray) -> float:
    """The longer side of the upright box around (m, 2) points, m ≥ 1.

    >>> extent(np.array([[0.0, 0.0], [3.0, 4.0], [1.0, 1.0]]))
    4.0
    """
    x, y = points[:, 0], points[:, 1]
    return max(float(x.max() - x.min()), float(y.max() - y.min()))


def signed_area(points: FloatArray) -> float:
    """Area of an (m, 2) polygon, positive when counter-clockwise (y upwards).

    >>> square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    >>> float(signed_area(square)), float(signed_area(square[::-1]))
    (4.0, -4.0)
    """
    local = points - points[0]  # far from the origin the products would cancel
    x, y = local[:, 0], local[:, 1]
    return 0.5 * float(np.dot(x, shifted(y, 1)) - np.dot(y, shifted(x, 1)))


def centroid(points: FloatArray) -> FloatArray:
    """Centre of mass, (2,), of the region inside an (m, 2) polygon; of zero area: the mean vertex.

    >>> centroid(np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]])).round(6).tolist()
    [1.0, 1.0]
    """
    local = points - points[0]
    following = shifted(local, 1)
    cross = local[:, 0] * following[:, 1] - local[:, 1] * following[:, 0]
    doubled = float(cross.sum())
    if doubled == 0.0:
        return np.asarray(points.mean(axis=0), dtype=np.float64)
    sums = local + following
    moment = np.array([(sums[:, 0] * cross).cumsum()[-1], (sums[:, 1] * cross).cumsum()[-1]]) / (3.0 * doubled)
    return np.asarray(points[0] + moment, dtype=np.float64)


def edge_lengths(points: FloatArray) -> FloatArray:
    """Lengths, (m,), of a polygon's edges; edge i runs from vertex i to i + 1, the last to vertex 0.

    >>> edge_lengths(np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]])).tolist()
    [3.0, 4.0, 5.0]
    """
    step = shifted(points, 1) - points
    return np.hypot(step[:, 0], step[:, 1])


def arc_length(points: FloatArray) -> FloatArray:
    """Length along a closed polygon from vertex 0 to each vertex, (m + 1,); the last is the perimeter.

    >>> arc_length(np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]])).tolist()
    [0.0, 3.0, 7.0, 12.0]
    """
    lengths = np.zeros(len(points) + 1)
    np.cumsum(edge_lengths(points), out=lengths[1:])
    return lengths


def swept_area(points: FloatArray) -> FloatArray:
    """Signed area swept by the ray from the origin to a closed polygon, from vertex 0 to each vertex, (m + 1,).

    The last is the polygon's area; the region between a section of boundary and its chord has the difference of two
    entries, plus the area of the chord's triangle with the origin.

    >>> swept_area(np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])).tolist()
    [0.0, 0.0, 2.0, 4.0, 4.0]
    """
    following = shifted(points, 1)
    cross = points[:, 0] * following[:, 1] - points[:, 1] * following[:, 0]
    return np.concatenate([[0.0], np.cumsum(0.5 * cross)])


def interior_angles(points: FloatArray) -> FloatArray:
    """Interior angles, (m,), radians in [0, 2π), of a counter-clockwise polygon; more than π is concave.

    The outside angle θ of the paper is 2π minus this. A vertex that coincides with a neighbour has no angle
    and gets an arbitrary one.

    >>> square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    >>> np.degrees(interior_angles(square)).round(6).tolist()
    [90.0, 90.0, 90.0, 90.0]
    """
    forward = shifted(points, 1) - points
    back = shifted(points, -1) - points
    cross = forward[:, 0] * back[:, 1] - forward[:, 1] * back[:, 0]
    dot = forward[:, 0] * back[:, 0] + forward[:, 1] * back[:, 1]
    angles: FloatArray = np.arctan2(cross, dot)
    angles[angles < 0.0] += 2.0 * np.pi
    return angles


def trunk_angles(points: FloatArray) -> FloatArray:
    """Interior angles, (n,), radians in (0, π), of a convex polygon listed in either orientation.

    >>> triangle = np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]])
    >>> np.degrees(trunk_angles(triangle)).round(6).tolist()
    [90.0, 45.0, 45.0]
    """
    angles = interior_angles(points)
    return np.minimum(angles, 2.0 * np.pi - angles)


def is_simple(points: FloatArray) -> bool:
    """Whether an (m, 2) polygon is a valid region: ≥ 3 vertices, area, no self-crossing or self-touching.

    >>> bow = np.array([[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]])
    >>> is_simple(bow), is_simple(bow[[0, 2, 1, 3]])
    (False, True)
    """
    if len(points) < 3 or not np.isfinite(points).all():
        return False
    return bool(shapely.is_valid(shapely.Polygon(points)))


def simplify_open(points: FloatArray, tolerance: float) -> IntArray:
    """Douglas–Peucker on an (m, 2) polyline: sorted indices, (k,) int64, of the kept vertices.

    Both ends are kept. ``tolerance`` is in the units of ``points``: every dropped vertex lies within it
    of the chord over it.

    >>> simplify_open(np.array([[0.0, 0.0], [1.0, 0.01], [2.0, 0.0], [2.0, 1.0]]), 0.1).tolist()
    [0, 2, 3]
    """
    if len(points) < 3:
        return np.arange(len(points), dtype=np.int64)
    keep = kernels.simplify.douglas_peucker(np.ascontiguousarray(points, dtype=np.float64), float(tolerance))
    return np.flatnonzero(keep).astype(np.int64)


def simplify(points: FloatArray, tolerance: float) -> IntArray:
    """Douglas–Peucker on an (m, 2) closed polygon: sorted indices, (k,) int64, of the kept vertices.

    The boundary is cut at the vertex farthest from the centroid and the vertex farthest from that one, so the
    kept vertices depend neither on the start vertex nor on the polygon's position, rotation or (with the
    tolerance scaled) size. k ≥ 2; k = 2 only for a polygon as thin as the tolerance. A vertex of an exactly
    symmetric polygon may be replaced by its mirror image when the polygon is turned or mirrored. ``tolerance`` is in
    the units of ``points``.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    >>> simplify(square, 0.1).tolist()
    [0, 2, 3, 4]
    """
    m = len(points)
    if m < 3:
        return np.arange(m, dtype=np.int64)
    x, y = centroid(points)
    # A copy: a read-only array would be compiled for anew.
    return kernels.simplify.simplified(
        np.array(points, dtype=np.float64, order="C"), float(x), float(y), float(tolerance)
    )


def at_length(points: FloatArray, positions: FloatArray) -> FloatArray:
    """Points, (k, 2), at arc-length ``positions``, (k,), from vertex 0 of a polygon; they wrap around.

    >>> square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    >>> at_length(square, np.array([1.0, 3.0])).tolist()
    [[1.0, 0.0], [2.0, 1.0]]
    """
    lengths = arc_length(points)
    closed = np.concatenate([points, points[:1]])
    return _interpolate(closed, lengths, np.mod(positions, lengths[-1]))


def insert_midpoints(points: FloatArray, kept: IntArray, spacing: float) -> tuple[FloatArray, BoolArray]:
    """Sample a closed polygon: the ``kept`` vertices and midpoints along the boundary (paper §6).

    Each interval between consecutive kept vertices is halved, by arc length, until its divisions are shorter than
    ``spacing``. ``kept`` are (k,) sorted indices, k ≥ 1.

    Returns
    -------
    samples : (n, 2) float64
        In the polygon's order, starting at ``points[kept[0]]``.
    is_kept : (n,) bool
        True at the kept vertices.

    >>> triangle = np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]])
    >>> points, feature = insert_midpoints(triangle, np.arange(3), 1.5)
    >>> len(points), int(feature.sum())
    (6, 3)
    """
    lengths = arc_length(points)
    positions, is_kept = kernels.simplify.halved(lengths[kept], float(lengths[-1]), float(spacing))
    samples = at_length(points, positions)
    samples[is_kept] = points[kept]  # exactly, without the rounding of the interpolation
    return samples, is_kept


def spread(points: FloatArray, kept: IntArray, spacing: float) -> IntArray:
    """As `insert_midpoints`, but choosing among the polygon's own vertices: sorted indices, (n,) int64.

    The vertex nearest to each midpoint, by arc length, replaces it. Where the polygon has too few vertices, the
    spacing stays wider.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    >>> spread(square, np.array([0, 3]), 2.5).tolist()
    [0, 2, 3, 4]
    """
    lengths = arc_length(points)
    positions, is_kept = kernels.simplify.halved(lengths[kept], float(lengths[-1]), float(spacing))
    wanted = np.mod(positions[~is_kept], lengths[-1])
    after = np.searchsorted(lengths, wanted).clip(1, len(points))
    nearer = np.where(wanted - lengths[after - 1] <= lengths[after] - wanted, after - 1, after)
    return np.unique(np.concatenate([kept, nearer % len(points)])).astype(np.int64)


def _interpolate(points: FloatArray, lengths: FloatArray, positions: FloatArray) -> FloatArray:
    return np.column_stack([np.interp(positions, lengths, points[:, 0]), np.interp(positions, lengths, points[:, 1])])


def farthest(points: FloatArray, origin: FloatArray) -> int:
    """Index of the vertex farthest from ``origin``; ties go to least x, then least y.

    >>> farthest(np.array([[0.0, 0.0], [3.0, 4.0], [1.0, 1.0]]), np.zeros(2))
    1
    """
    return int(
        kernels.simplify.farthest_vertex(
            np.array(points, dtype=np.float64, order="C"), float(origin[0]), float(origin[1])
        )
    )
