"""Construct the transform of a plan, or the best of several: by the exact method or by the paper's (theory §8)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from riot.construction.dissected_plan import dissect_plan
from riot.construction.laplacian.method import construct_laplacian
from riot.construction.pins import Pins
from riot.construction.plan import ConstructionPlan
from riot.construction.tuning import EXACT_BOUND, EXACT_LOSS, FINER_MESH
from riot.errors import ConstructionError
from riot.parameters import ConstructParameters
from riot.transform.certificate import certify
from riot.transform.deformation import overlap_ratios
from riot.transform.transform import Transform


def construct_plan(plan: ConstructionPlan, parameters: ConstructParameters, pins: Pins | None = None) -> Transform:
    """Construct the transform of one plan by ``parameters.method`` (exact: ours; laplacian: paper §4.3).

    `riot.construction.dissected_plan.dissect_plan` keeps the partitions of the exact method, so that the pieces can be
    cut again with other pins. Raises ConstructionError if the exact method gives no transform with a certificate, if a
    pin cannot be met, or if pins are given to the paper's method, which has none.

    >>> from riot import Shape, alternatives
    >>> from riot.parameters import ConstructParameters
    >>> house = Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)])
    >>> kite = Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)])
    >>> len(construct_plan(alternatives(house, kite)[0], ConstructParameters()))  # pieces
    4
    """
    if parameters.method == "laplacian":
        if pins:
            raise ConstructionError("pins", "the paper's method (laplacian) knows no pins: use method=exact")
        return construct_laplacian(plan, parameters)
    transform = dissect_plan(plan, parameters).transform(pins)
    if not pins and plan.bound >= EXACT_BOUND:
        transform = _finer(transform, plan, parameters)
    certificate = certify(transform)
    if not certificate.passed:
        reason = "overlap" if certificate.p.simple and certificate.q.simple else "not-simple"
        raise ConstructionError(reason, f"the certificate fails: {certificate.failure}")
    return transform


def _finer(transform: Transform, plan: ConstructionPlan, parameters: ConstructParameters) -> Transform:
    """The transform of an exact plan on a finer mesh, if on the usual one a needle narrower than the mesh is lost."""
    iou = min(overlap_ratios(transform))
    if iou >= plan.bound - EXACT_LOSS:
        return transform
    try:
        finer = dissect_plan(plan, replace(parameters, spacing=FINER_MESH * parameters.spacing)).transform()
    except ConstructionError:
        return transform
    return finer if certify(finer).passed and min(overlap_ratios(finer)) > iou else transform


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
