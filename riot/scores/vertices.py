"""Candidate trunk vertices: the binary score and the congruency score of boundary points (paper §4.1.1)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from riot.geometry.polyline import arc_length, interior_angles, simplify, spread
from riot.geometry.shape import Shape
from riot.kernels.congruency import local_turns, longest_congruent
from riot.kernels.simplify import TIE
from riot.kernels.visibility import seen_from
from riot.parameters import TrunkParameters
from riot.types import BoolArray, FloatArray, IntArray
from riot.units import D_C, L_C

CURVE_SPACING = L_C / 100
"""Sampling step of the two sides whose Fréchet distance is computed. Paper §6: the spacing of the boundary."""


@dataclass(frozen=True, eq=False)
class Congruency:
    """Congruency of the boundary on the two sides of k points.

    Parameters
    ----------
    score : (k,) float64
        S_c of eq. (2): 0 where no length is long enough and congruent enough.
    length : (k,) float64
        Length ℓ of the longest congruent sides; 0 without them.
    turn : (k,) float64
        Outside angle θ, radians: the turn that brings the boundary behind the point onto that ahead of it.
    """

    score: FloatArray
    length: FloatArray
    turn: FloatArray


def sparse_points(shape: Shape, parameters: TrunkParameters) -> IntArray:
    """Indices, (k,) int64 sorted, of the sparse boundary points: feature points, then midpoints (paper §4.1.2).

    >>> len(sparse_points(house, TrunkParameters()))
    24
    """
    features = simplify(shape.points, parameters.sparse_tolerance * L_C)
    return spread(shape.points, features, L_C / parameters.spacing)


def break_points(shape: Shape, parameters: TrunkParameters) -> IntArray:
    """Indices, (b,) int64 sorted, of the boundary simplified with τ_s.

    >>> len(break_points(house, TrunkParameters()))
    5
    """
    return simplify(shape.points, parameters.tau_s)


def convex_points(shape: Shape, parameters: TrunkParameters) -> IntArray:
    """Indices of the convex points of the boundary simplified with τ_s; their number is the paper's K.

    >>> len(convex_points(house, TrunkParameters()))
    5
    """
    breaks = break_points(shape, parameters)
    if len(breaks) < 3:
        return breaks
    return breaks[interior_angles(shape.points[breaks]) < math.pi]


def passes_visibility(shape: Shape, indices: IntArray) -> BoolArray:
    """(k,) the binary score of eq. (1): False at points from which too much of the shape is hidden.

    Too much is the area of a circle with the perimeter of the visible region, or half the boundary in one hidden
    region.

    >>> bool(passes_visibility(house, np.arange(3)).all())
    True
    """
    lengths = arc_length(shape.points)
    area, perimeter, hidden = seen_from(shape.points, lengths, indices).T
    invisible = 1.0 - area
    passes: BoolArray = (invisible < perimeter**2 / (4.0 * math.pi)) & (hidden < (0.5 - TIE) * lengths[-1])
    return passes


def congruency(shape: Shape, indices: IntArray, parameters: TrunkParameters) -> Congruency:
    """S_c, length ℓ and robust outside angle at boundary points (eq. 2; how ℓ is found is ours).

    Candidates for ℓ are the distances along the boundary to the break points of the simplified boundary. The boundary
    of length ℓ behind the point is turned about it onto that ahead, by the least-squares angle. The longest ℓ whose
    discrete Fréchet distance gives S_c ≥ τ_c counts.

    >>> corner = sparse_points(house, TrunkParameters())[:1]
    >>> congruency(house, corner, TrunkParameters()).score.shape
    (1,)
    """
    lengths = arc_length(shape.points)
    sigma = parameters.sigma_c * D_C
    limit = sigma * math.sqrt(-2.0 * math.log(parameters.tau_c)) if parameters.tau_c > 0.0 else math.inf
    breaks = lengths[break_points(shape, parameters)]
    shortest = 0.5 * parameters.min_congruent * lengths[-1]
    length, distance, turn = longest_congruent(shape.points, lengths, indices, breaks, CURVE_SPACING, limit, shortest).T
    return Congruency(np.exp(-(distance**2) / (2.0 * sigma**2)), length, turn)


def local_outside_angles(shape: Shape, indices: IntArray, parameters: TrunkParameters) -> FloatArray:
    """(k,) θ, radians, from the boundary next to each point (paper §5.2).

    >>> angles = local_outside_angles(house, convex_points(house, TrunkParameters()), TrunkParameters())
    >>> sorted(np.degrees(angles).round().tolist())
    [225.0, 225.0, 270.0, 270.0, 270.0]
    """
    return local_turns(shape.points, arc_length(shape.points), indices, L_C / parameters.local)
