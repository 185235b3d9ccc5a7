"""Construct bent plans and keep the best: the one that people recognise, not that of most area (theory §12; ours)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from riot.construction.pins import Pins
from riot.construction.plan_transform import construct_plan, construct_plans
from riot.errors import ConstructionError
from riot.parameters import BendParameters, ConstructParameters
from riot.transform.centreline import centre_line_overlap
from riot.transform.deformation import overlap_ratios

if TYPE_CHECKING:
    from riot.construction.bend import BentPlan
    from riot.construction.plan import ConstructionPlan
    from riot.transform.transform import Transform


def construct_bent(
    bent: Sequence[BentPlan],
    plans: Sequence[ConstructionPlan],
    unplanned: Sequence[ConstructionError],
    bend: BendParameters,
    construction: ConstructParameters,
    pins: Pins | None = None,
) -> Transform:
    """Construct bent plans of one pair of shapes, the one of most worth first, and keep the transform of most worth.

    Worth is the IoU of the worse shape less what its strain costs, as `riot.construction.bend_objective` has it, and
    the centre-line Dice of the worse shape times ``bend.limbs``: area alone does not see a tail. After so many
    transforms as ``bend.judged`` no more are made. If no bent plan gives one, ``plans`` are constructed as they are.
    ``pins`` are of the inputs, and go along with the bend.

    Raises ConstructionError as `riot.construction.plan_transform.construct_plans` if they give none, either.

    >>> from riot.construction import alternatives, bend_best
    >>> plans, bend = alternatives(house, kite), BendParameters(steps=8)
    >>> construct_bent(bend_best(plans, bend), plans, [], bend, ConstructParameters()).input_p is house
    True
    """
    best, best_worth, judged = None, -1.0, 0
    for one in bent:
        # Nothing has a greater Dice than 1.
        if judged == bend.judged or one.worth + bend.limbs <= best_worth:
            break
        try:
            transform = construct_plan(one.plan, construction, pins and bent_pins(pins, one))
        except ConstructionError:
            continue
        judged += 1
        worth = min(overlap_ratios(transform)) + one.worth - one.plan.bound + bend.limbs * _centre_lines(transform)
        if worth > best_worth:
            best, best_worth = transform, worth
    return construct_plans(plans, unplanned, construction, pins) if best is None else best


def bent_pins(pins: Pins, bent: BentPlan) -> Pins:
    """Where the pins of the inputs lie on the bent shapes.

    >>> from riot.construction import alternatives, bend_best, keep
    >>> bent = bend_best(alternatives(house, kite), BendParameters(steps=8))[0]
    >>> moved = bent_pins(Pins(p=(keep(house.points[3]),)), bent)
    >>> bool(abs(moved.p[0].points - bent.p.bent.points[3]).max() < 1e-9)
    True
    """
    sides = (
        tuple(replace(pin, points=bend.field.at(pin.points)) for pin in of_side)
        for of_side, bend in ((pins.p, bent.p), (pins.q, bent.q))
    )
    return Pins(*sides)


def _centre_lines(transform: Transform) -> float:
    """The centre-line Dice of the worse shape with what is cut."""
    outlines = (transform.outline_p(), transform.p.points), (transform.outline_q(), transform.q.points)
    return min(centre_line_overlap(*both).dice for both in outlines)
