"""The plan of a transform that is made already, and the same plan with a corner elsewhere, for editing. Ours."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from riot.construction.given_trunks import insert_vertices
from riot.construction.plan import ConstructionPlan, TrunkPair, plan_on, plan_pair
from riot.construction.tuning import MERGE_DISTANCE
from riot.errors import TrunkError
from riot.geometry.polyline import arc_length
from riot.parameters import RefineParameters
from riot.units import D_C

if TYPE_CHECKING:
    from riot.geometry.shape import Shape
    from riot.transform.transform import Transform
    from riot.types import FloatArray, IntArray

_REACH = 0.5 * D_C
"""A corner that is moved lies on the outline at the point nearest to where it is wanted, if that is not farther."""


def trunks_of(transform: Transform) -> FloatArray:
    """(2, n, 2) the conjugate trunks of a transform: T in P's frame, T̄ in Q's, in corresponding order.

    >>> trunks_of(transform).shape
    (2, 4, 2)
    """
    return np.stack([transform.pose(0.0).origins, transform.pose(1.0).origins])


def plan_of(transform: Transform, refinement: RefineParameters | None = None) -> ConstructionPlan:
    """The plan on which a transform stands: its trunks, and where they part its outlines.

    Of ``refinement`` reach and lines of the bound are read. Raises TrunkError if the transform's trunks are not on
    the outlines of its shapes, as `riot.construction.given_trunks.insert_vertices`.

    >>> plan = plan_of(transform)
    >>> bool(abs(plan.trunks - trunks_of(transform)).max() < 1e-12)
    True
    """
    refinement = refinement or RefineParameters()
    feet = transform.trunk_p, transform.trunk_q
    pair = _pair(transform.p, transform.q, *feet, refinement.reach)
    pair = replace(pair, bend_p=transform.bend_p, bend_q=transform.bend_q)
    return plan_on(pair, trunks_of(transform), refinement.bound_lines)


def with_corner(
    plan: ConstructionPlan, side: Literal["p", "q"], corner: int, to: FloatArray, lines: int
) -> ConstructionPlan:
    """The plan with one trunk vertex moved along the outline to the point nearest to ``to`` (2,), made conjugate again.

    Of the other corners those on that outline stay; all move as little as conjugate trunks allow. ``lines`` are
    scanlines of the bound. Raises TrunkError if ``to`` is far from the outline or past the next corner,
    ConstructionError if the trunks cannot be made conjugate and convex.

    >>> plan = plan_of(transform)
    >>> moved = with_corner(plan, "p", 1, plan.feet[0, 1] + 0.01, lines=128)
    >>> moved.trunks.shape
    (2, 4, 2)
    """
    pair = plan.pair
    feet = plan.feet.copy()
    if not 0 <= corner < feet.shape[1]:
        raise TrunkError(f"there is no corner {corner}: the trunk has {feet.shape[1]}")
    feet["pq".index(side), corner] = to
    moved = _pair(pair.p, pair.q, feet[0], feet[1], pair.reach)
    return plan_pair(replace(moved, bend_p=pair.bend_p, bend_q=pair.bend_q), lines)


def unbent_plan(plan: ConstructionPlan, lines: int) -> ConstructionPlan:
    """The plan on the inputs as they were before they were bent, with corners at the same places along the outlines.

    Raises as `with_corner`.

    >>> unbent_plan(plan_of(transform), 128).pair.p is transform.p
    True
    """
    pair = plan.pair
    if pair.bend_p is None or pair.bend_q is None:
        return plan
    feet_p, feet_q = pair.bend_p.field.back(plan.feet[0]), pair.bend_q.field.back(plan.feet[1])
    return plan_pair(_pair(pair.bend_p.shape, pair.bend_q.shape, feet_p, feet_q, pair.reach), lines)


def _pair(p: Shape, q: Shape, feet_p: FloatArray, feet_q: FloatArray, reach: float) -> TrunkPair:
    outline_p, on_p = insert_vertices(p, feet_p, _REACH)
    outline_q, on_q = insert_vertices(q, feet_q, _REACH)
    for shape, outline, indices in ((p, outline_p, on_p), (q, outline_q, on_q[::-1])):
        _require_order(shape, outline, indices)
    return TrunkPair(p, q, outline_p, outline_q, on_p, on_q, reach)


def _require_order(shape: Shape, outline: FloatArray, indices: IntArray) -> None:
    """Raise TrunkError unless trunk vertices follow one another counter-clockwise, each some way from the next."""
    lengths = arc_length(outline)
    at = np.roll(lengths[indices], -int(indices.argmin()))
    ahead = np.diff([*at, at[0] + lengths[-1]])
    if (ahead <= MERGE_DISTANCE).any():
        raise TrunkError(f"a corner of the trunk would pass the next one on the outline of {shape.name or 'the shape'}")
