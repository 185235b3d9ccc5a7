"""The pieces as collision bodies: shrunk by half the outline gap, relieved around their hinges (theory §9). Ours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from riot.geometry.polyline import extent
from riot.motion.tuning import QUARTER_SEGMENTS, SIMPLIFY_SHARE
from riot.parameters import MotionParameters
from riot.transform.transform import Piece, Transform
from riot.types import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Bodies:
    """Bodies 3i (as it is), 3i + 1 (relieved at its start), 3i + 2 (at its end) of every piece i.

    Parameters
    ----------
    points : (p, 2) float64
        All rings, each in its piece's frame.
    rings : (r + 1,) int64
        Offsets of rings into ``points``.
    bodies : (3n + 1,) int64
        Offsets of bodies into ``rings``.
    lengths : (n,) float64
        Of the pieces' edges.
    reaches : (n, 2) float64
        Greatest distance of a point of the body from the piece's start and end.
    gap, relief : float
        Outline gap and radius of relief, in the unit-area frame.
    """

    points: FloatArray
    rings: IntArray
    bodies: IntArray
    lengths: FloatArray
    reaches: FloatArray
    gap: float
    relief: float

    def subchain(self, pieces: IntArray) -> tuple[FloatArray, IntArray, IntArray, FloatArray, FloatArray]:
        """Arrays of some pieces in the given order, as `riot.kernels.collide.clear_share` takes them."""
        rows = (3 * pieces[:, None] + np.arange(3)).ravel()
        rings = [np.arange(self.bodies[row], self.bodies[row + 1]) for row in rows]
        chosen = np.concatenate(rings)
        ring_points = [self.points[self.rings[ring] : self.rings[ring + 1]] for ring in chosen]
        return (
            np.concatenate([np.empty((0, 2)), *ring_points]),
            _offsets([len(points) for points in ring_points]),
            _offsets([len(ring) for ring in rings]),
            self.lengths[pieces],
            self.reaches[pieces],
        )


def make_bodies(transform: Transform, parameters: MotionParameters) -> Bodies:
    """Shrink and relieve the pieces of a transform.

    A body contains its piece shrunk by half the gap (what is narrower than the gap vanishes). It lies in the piece
    shrunk by 0.6 of that, so that no two bodies touch in either closed chain.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> bodies = make_bodies(exact_transform(dudeney()), MotionParameters())
    >>> len(bodies.bodies) - 1  # three of each of four pieces
    12
    """
    side = max(extent(transform.outline_p()), extent(transform.outline_q()))
    gap, relief = parameters.gap * side, parameters.relief * side
    bodies: list[list[FloatArray]] = []
    for piece in transform.pieces:
        whole = shrunk(piece, gap)
        discs = [shapely.Point(x, 0.0).buffer(relief, quad_segs=QUARTER_SEGMENTS) for x in (0.0, piece.length)]
        bodies += [_rings(body) for body in (whole, *(whole.difference(disc) for disc in discs))]
    rings = [ring for body in bodies for ring in body]
    lengths = np.array([piece.length for piece in transform.pieces])
    return Bodies(
        np.concatenate([np.empty((0, 2)), *rings]),
        _offsets([len(ring) for ring in rings]),
        _offsets([len(body) for body in bodies]),
        lengths,
        np.array([_reaches(bodies[3 * i], length) for i, length in enumerate(lengths)]),
        gap,
        relief,
    )


def shrunk(piece: Piece, gap: float) -> shapely.Geometry:
    """A piece, in its frame, less half the gap all round, its outline simplified outwards."""
    polygon = shapely.Polygon(piece.polygon)
    polygon = polygon if polygon.is_valid else polygon.buffer(0.0)
    slack = SIMPLIFY_SHARE * 0.5 * gap
    return polygon.buffer(slack - 0.5 * gap, quad_segs=QUARTER_SEGMENTS).simplify(slack, preserve_topology=True)


def _rings(body: shapely.Geometry) -> list[FloatArray]:
    """The outer rings (k, 2) of the polygons of a body."""
    polygons = [shape for shape in shapely.get_parts(body) if shape.geom_type == "Polygon" and not shape.is_empty]
    return [shapely.get_coordinates(polygon.exterior)[:-1] for polygon in polygons]


def _reaches(body: list[FloatArray], length: float) -> tuple[float, float]:
    points = np.concatenate([np.empty((0, 2)), *body])
    if len(points) == 0:
        return 0.0, 0.0
    start, end = np.hypot(points[:, 0], points[:, 1]), np.hypot(points[:, 0] - length, points[:, 1])
    return float(start.max()), float(end.max())


def _offsets(sizes: list[int]) -> IntArray:
    return np.concatenate([[0], np.cumsum(np.array(sizes, dtype=np.int64))]).astype(np.int64)
