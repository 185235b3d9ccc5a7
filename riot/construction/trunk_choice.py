"""Choose the trunks on which two shapes are transformed, given by the user or of highest CRS, and construct on them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy.typing as npt

from riot.construction.bend import bend_best
from riot.construction.dissected_plan import require_plan_contact
from riot.construction.given_trunks import given_pair
from riot.construction.pins import Pins
from riot.construction.plan import ConstructionPlan, TrunkPair, plan_pair
from riot.construction.plan_transform import construct_plan
from riot.construction.refine import refine
from riot.errors import ConstructionError, TrunkError
from riot.geometry.shape import Shape
from riot.parameters import BendParameters, ConstructParameters, CrsParameters, RefineParameters, TrunkParameters
from riot.scores.crs import CrossScore, best_trunk_pairs
from riot.scores.trunks import full_trunks
from riot.transform.deformation import overlap_ratios
from riot.transform.transform import Transform

PlansAndFailures = tuple[list[ConstructionPlan], list[ConstructionError]]
"""Plans, the one of highest bound first, and why the other trunk pairs gave none."""

PieceCounts = tuple[int, int]
"""Least and greatest number of pieces, which is the number of vertices of either trunk."""


def construct(
    a: Shape,
    b: Shape,
    trunks: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    parameters: ConstructParameters | None = None,
    refinement: RefineParameters | None = None,
    pins: Pins | None = None,
    pieces: PieceCounts | None = None,
    bend: BendParameters | None = None,
) -> Transform:
    """Construct an exact transform of a into b.

    Parameters
    ----------
    a, b : Shape
    trunks : two (n, 2) arrays, optional
        Trunk vertices of a and of b as coordinates in the shapes' frames (`Shape.from_source` converts), on or near the
        outlines, in corresponding order: round a one way, round b the other. Given them, no search takes place; they
        are made conjugate and refined. Without them the trunk pairs of highest CRS are tried, and the transform of
        least deformation is returned.
    parameters : ConstructParameters, optional
        With ``method="laplacian"`` the transform is the paper's, which overlaps and leaves gaps: its certificate fails.
    refinement : RefineParameters, optional
        Of the trunks, found or given; with ``sketched=0, refined=0`` they are only made conjugate.
    pins : Pins, optional
        Sections of either outline to keep, or drawn anew (exact method).
    pieces : two int, optional
        Least and greatest number of pieces; any number by default. Given trunks have theirs.
    bend : BendParameters, optional
        With ``method="elastic"`` both shapes are bent a little first, and the transform is that of the bent shapes;
        `riot.construction.bend.bend_best` tells how they are bent. Plans that are not bent are tried after those that
        are. Not with pins.

    Raises
    ------
    TrunkError
        There is no trunk pair, or the given one is not on the outlines, not convex, or not in corresponding order.
    ConstructionError
        No trunk pair gave an exact transform; ``reason`` and the message say why the best one failed.

    Examples
    --------
    >>> from riot import Shape
    >>> house = Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)], name="house")
    >>> kite = Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)], name="kite")
    >>> len(construct(house, kite))  # pieces
    4
    """
    parameters, refinement = parameters or ConstructParameters(), refinement or RefineParameters()
    if trunks is not None:
        if len(trunks) != 2:
            raise TrunkError(f"trunks holds {len(trunks)} items: give two, the vertices on a and those on b")
        pair = given_pair(a, b, *trunks, parameters.snap, refinement.reach)
        plans, unplanned = plan_pairs([pair], refinement)
        # Refined trunks may lose contact that the given ones have.
        plans = sorted({*refine_best(plans, refinement), *plans}, key=lambda plan: -plan.bound)
    else:
        plans, unplanned = find_plans(a, b, refinement, pieces)
    if bend is not None and bend.method == "elastic" and plans:
        if pins:
            raise ConstructionError("pins", "pins are sections of the inputs' outlines: bend.method=off keeps these")
        bent = bend_best(plans, bend, refinement, parameters)
        try:
            return construct_plans([one.plan for one in bent], unplanned, parameters)
        except ConstructionError:
            pass  # as they are the shapes may be cut
    return construct_plans(plans, unplanned, parameters, pins)


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


def find_plans(a: Shape, b: Shape, refinement: RefineParameters, pieces: PieceCounts | None = None) -> PlansAndFailures:
    """Refine the trunk pairs of highest CRS (ours); ``pieces`` as in `construct`.

    Raises TrunkError if the shapes have no trunks that correspond.
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
    return refine_scored(a, b, scores, refinement)


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
    ``spacing`` and ``allowed`` as in `riot.construction.dissected_plan.require_plan_contact`.
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


def construct_plans(
    plans: Sequence[ConstructionPlan],
    unplanned: Sequence[ConstructionError],
    parameters: ConstructParameters,
    pins: Pins | None = None,
) -> Transform:
    """Construct the plans in turn until ``attempts`` succeed, and return the transform of highest IoU.

    A plan whose bound is no higher than an IoU that is reached is left out. An exact transform must pass its
    certificate. Raises ConstructionError with the first reason if no plan gives a transform.

    >>> from riot import Shape
    >>> house = Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)])
    >>> kite = Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)])
    >>> from riot.construction import alternatives
    >>> plan = alternatives(house, kite)[0]
    >>> len(construct_plans([plan], [], ConstructParameters()))  # pieces
    4
    """
    best: Transform | None = None
    best_iou = -1.0
    failures: list[ConstructionError] = []
    succeeded = 0
    for plan in plans:
        if succeeded == parameters.attempts:
            break
        if best is not None and plan.bound <= best_iou:
            continue
        try:
            transform = construct_plan(plan, parameters, pins)
        except ConstructionError as error:
            failures.append(error)
            continue
        succeeded += 1
        iou = min(overlap_ratios(transform))
        if iou > best_iou:
            best, best_iou = transform, iou
    if best is None:
        first = [*failures, *unplanned][0]
        count = len(plans) + len(unplanned)
        tried = "the trunk pair gives no" if count == 1 else f"none of {count} trunk pairs gives an"
        raise ConstructionError(first.reason, f"{tried} exact transform; the most promising: {first}")
    return best
