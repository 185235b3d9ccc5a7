"""Construct the transform of one plan: by the exact method, with its certificate, or by the paper's (theory §8)."""

from __future__ import annotations

from riot.construction.dissected_plan import dissect_plan
from riot.construction.laplacian.method import construct_laplacian
from riot.construction.pins import Pins
from riot.construction.plan import ConstructionPlan
from riot.errors import ConstructionError
from riot.parameters import ConstructParameters
from riot.transform.certificate import certify
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
    certificate = certify(transform)
    if not certificate.passed:
        reason = "overlap" if certificate.p.simple and certificate.q.simple else "not-simple"
        raise ConstructionError(reason, f"the certificate fails: {certificate.failure}")
    return transform
