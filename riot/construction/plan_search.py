"""Search for plans: trunk pairs of highest CRS, made conjugate and refined, highest bound first (theory §7)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from riot.construction.contact import require_plan_contact
from riot.construction.plan import ConstructionPlan, TrunkPair, plan_pair
from riot.construction.refine import refine
from riot.construction.tuning import LEAST_STARTS, MOST_STARTS
from riot.errors import ConstructionError, TrunkError
from riot.geometry.shape import Shape
from riot.parameters import CrsParameters, RefineParameters, TrunkParameters
from riot.scores.crs import CrossScore, best_trunk_pairs
from riot.scores.trunks import Trunks, full_trunks

PlansAndFailures = tuple[list[ConstructionPlan], list[ConstructionError]]
"""Plans, the one of highest bound first, and why the other trunk pairs gave none."""

PieceCounts = tuple[int, int]
"""Least and greatest number of pieces, which is the number of vertices of either trunk."""


def alternatives(
    a: Shape, b: Shape, refinement: RefineParameters | None = None, pieces: PieceCounts | None = None
) -> list[ConstructionPlan]:
    """Find the refined trunk pairs of two shapes, the one that allows the least deformation first (ours).

    ``pieces`` as in `construct`.

    `construct_plan` makes the transform of one of them, and `riot.construction.dissected_plan.dissect_plan` keeps the
    partitions, so that pins can change. Raises TrunkError if the shapes have no trunk pair that can be made conjugate.

    >>> from riot import Shape
    >>> house = Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)])
    >>> kite = Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)])
    >>> plans = alternatives(house, kite)
    >>> plans[0].bound == max(plan.bound for plan in plans)
    True
    """
    plans, unplanned = find_plans(a, b, refinement or RefineParameters(), pieces)
    if not plans:
        raise TrunkError(f"no trunk pair of {a.name or 'P'} and {b.name or 'Q'} will do: {unplanned[0]}")
    return plans


def find_plans(
    a: Shape, b: Shape, refinement: RefineParameters, pieces: PieceCounts | None = None, per_size: int = 0
) -> PlansAndFailures:
    """Refine the trunk pairs of highest CRS (ours), and ``per_size`` more of each number of vertices (`sized_plans`).

    ``pieces`` as in `construct`. Raises TrunkError if the shapes have no trunks that correspond.
    """
    full_a, full_b = full_trunks(a, TrunkParameters()), full_trunks(b, TrunkParameters())
    for shape, trunks in ((a, full_a), (b, full_b)):
        if len(trunks) == 0:
            raise TrunkError(
                f"{shape.name or 'the shape'} has no trunk: no convex polygon inscribed in it passes all tests"
            )
    if pieces is not None:
        full_a, full_b = full_a.of_sizes(*pieces), full_b.of_sizes(*pieces)
    scores = best_trunk_pairs(a, b, full_a, full_b, CrsParameters(), refinement.candidates)
    if not scores:
        number = "the same number of" if pieces is None else f"the same number of {pieces[0]} to {pieces[1]}"
        raise TrunkError(f"{a.name or 'P'} and {b.name or 'Q'} have no trunks with {number} vertices")
    plans, unplanned = refine_scored(a, b, scores, refinement)
    plans += sized_plans(a, b, full_a, full_b, refinement, per_size)
    return sorted(plans, key=lambda plan: -plan.bound), unplanned


def sized_plans(
    a: Shape, b: Shape, trunks_a: Trunks, trunks_b: Trunks, refinement: RefineParameters, count: int
) -> list[ConstructionPlan]:
    """Refine the ``count`` trunk pairs of highest CRS of each number of vertices up to `MOST_STARTS` (ours).

    Those of highest CRS in all are often near copies of one another. These differ, and some of them may do after a
    bend though they do not before.

    >>> from riot.scores.trunks import full_trunks
    >>> plans = sized_plans(house, kite, full_trunks(house), full_trunks(kite), RefineParameters(), 2)
    >>> sorted({plan.trunks.shape[1] for plan in plans})
    [3, 4]
    """
    scores: list[CrossScore] = []
    for n in range(LEAST_STARTS, MOST_STARTS + 1 if count else 0):
        of_a, of_b = trunks_a.of_sizes(n, n), trunks_b.of_sizes(n, n)
        if len(of_a) and len(of_b):
            scores += best_trunk_pairs(a, b, of_a, of_b, CrsParameters(), count)
    plans, _ = plan_pairs(trunk_pairs(a, b, scores, refinement.reach), refinement)
    return refine_best(plans, replace(refinement, sketched=len(plans)))


def refine_scored(a: Shape, b: Shape, scores: Sequence[CrossScore], refinement: RefineParameters) -> PlansAndFailures:
    """Refine the trunk pairs of known scores, best CRS first; returns as `find_plans`."""
    plans, unplanned = plan_pairs(trunk_pairs(a, b, scores, refinement.reach), refinement)
    return refine_best(plans, refinement), unplanned


def trunk_pairs(a: Shape, b: Shape, scores: Sequence[CrossScore], reach: float) -> list[TrunkPair]:
    """The trunk pairs of scores, in their order; ``reach`` as in `TrunkPair`."""
    return [TrunkPair(a, b, a.points, b.points, score.trunk_a, score.trunk_b, reach) for score in scores]


def plan_pairs(pairs: Sequence[TrunkPair], parameters: RefineParameters) -> PlansAndFailures:
    """Make the trunks of each pair conjugate, and bound the IoU that a construction on them can have."""
    plans: list[ConstructionPlan] = []
    unplanned: list[ConstructionError] = []
    for pair in pairs:
        try:
            plans.append(plan_pair(pair, parameters.bound_lines))
        except ConstructionError as error:
            unplanned.append(error)
    return sorted(plans, key=lambda plan: -plan.bound), unplanned


def refine_best(plans: Sequence[ConstructionPlan], parameters: RefineParameters) -> list[ConstructionPlan]:
    """Refine the most promising plans a little, and the best of these to the end; all plans, highest bound first."""
    ranked = list(plans)
    for count, steps in ((parameters.sketched, parameters.sketch_steps), (parameters.refined, parameters.steps)):
        ranked = [refine(plan, steps, parameters) for plan in ranked[:count]] + ranked[count:]
        ranked.sort(key=lambda plan: -plan.bound)
    return ranked


def drop_without_contact(plans: Sequence[ConstructionPlan], spacing: float, allowed: float) -> PlansAndFailures:
    """Drop plans until one whose pieces keep their trunk edges, so that a construction can reach its bound.

    Returns the plans from that one on, and why those before it lose contact.
    ``spacing`` and ``allowed`` as in `riot.construction.contact.require_plan_contact`.
    """
    errors: list[ConstructionError] = []
    for k, plan in enumerate(plans):
        try:
            require_plan_contact(plan, spacing, allowed)
        except ConstructionError as error:
            errors.append(error)
        else:
            return list(plans[k:]), errors
    return [], errors
