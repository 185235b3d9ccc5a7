"""Trunk edges between candidate vertices: which are admissible (paper §4.1.2)."""

from __future__ import annotations

import numpy as np

from riot.geometry.polyline import TOUCH, arc_length, swept_area
from riot.geometry.shape import Shape
from riot.kernels.segments import inside_shares
from riot.kernels.simplify import TIE
from riot.parameters import TrunkParameters
from riot.scores.vertices import convex_points
from riot.types import BoolArray, FloatArray, IntArray


def admissible_edges(
    shape: Shape, candidates: IntArray, parameters: TrunkParameters, convex: IntArray | None = None
) -> BoolArray:
    """(c, c) whether the edge from candidate i to candidate j, with the boundary between them, may be a trunk edge.

    The boundary between them contains a convex point (paper: of the boundary simplified with τ_s; ours: the edge's ends
    do not count) and is shorter than ``max_arc`` of the whole; the exterior piece has area above ``min_area``; at least
    ``min_inside`` of the edge is inside the closed shape. A value within `riot.kernels.simplify.TIE` of a limit counts
    as on it, so that rounding does not choose among the trunks of symmetric shapes (ours). ``convex``: the shape's
    `riot.scores.vertices.convex_points`, computed if not given.

    >>> from riot.scores.vertices import sparse_points
    >>> admissible_edges(house, sparse_points(house, TrunkParameters())[:4], TrunkParameters()).shape
    (4, 4)
    """
    lengths = arc_length(shape.points)
    arcs = _arcs(lengths, candidates)
    admissible: BoolArray = (arcs > 0.0) & (arcs < (parameters.max_arc - TIE) * lengths[-1])
    admissible &= _contains_mark(candidates, convex_points(shape, parameters) if convex is None else convex)
    admissible &= exterior_areas(shape.points, candidates) > parameters.min_area + TIE
    shares = inside_shares(shape.points, candidates, admissible, TOUCH)
    admissible &= np.nan_to_num(shares) >= parameters.min_inside - TIE
    return admissible


def exterior_areas(points: FloatArray, candidates: IntArray) -> FloatArray:
    """(c, c) signed area between the boundary from candidate i to j and the edge i–j; positive outside the edge.

    >>> exterior_areas(house.points, np.array([0, 40, 80])).shape
    (3, 3)
    """
    running = swept_area(points)
    swept = running[candidates][None, :] - running[candidates][:, None]
    swept = np.where(candidates[None, :] < candidates[:, None], swept + running[-1], swept)
    x, y = points[candidates].T
    areas: FloatArray = swept + 0.5 * (x[None, :] * y[:, None] - y[None, :] * x[:, None])
    return areas


def _arcs(lengths: FloatArray, candidates: IntArray) -> FloatArray:
    """(c, c) boundary length from candidate i forwards to candidate j, of the arc ``lengths`` (m + 1,)."""
    at = lengths[candidates]
    arcs: FloatArray = np.mod(at[None, :] - at[:, None], lengths[-1])
    return arcs


def _contains_mark(candidates: IntArray, marks: IntArray) -> BoolArray:
    """(c, c) whether a mark lies strictly between candidates i and j, going forwards."""
    upto = np.searchsorted(marks, candidates, side="right")
    before = np.searchsorted(marks, candidates, side="left")
    between = before[None, :] - upto[:, None]
    between = np.where(candidates[None, :] < candidates[:, None], between + len(marks), between)
    contains: BoolArray = between > 0
    return contains


def shared_lengths(shape: Shape, candidates: IntArray, lengths: FloatArray) -> FloatArray:
    """(c, c) length that the congruent sections of candidates i and j share on the boundary from i to j.

    Beyond the other candidate a section is not on that boundary. Negative if the sections do not meet.
    """
    arcs = _arcs(arc_length(shape.points), candidates)
    overlap: FloatArray = np.minimum(lengths[:, None], arcs) + np.minimum(lengths[None, :], arcs) - arcs
    return overlap
