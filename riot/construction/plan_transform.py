"""From one plan to its transform: by the exact method, with its certificate, or by the paper's (theory §8)."""

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
    """The transform on one plan by ``parameters.method``; ConstructionError if an exact one is not to be had.

    `riot.construction.dissected_plan.dissect_plan` keeps the partitions of the exact method, to cut the pieces again with other
    pins.
    """
    if parameters.method == "laplacian":
        if pins:
            raise ConstructionError("pins", "the paper's method (laplacian) knows no pins: use method=exact")
        return construct_laplacian(plan, parameters)
    made = dissect_plan(plan, parameters).transform(pins)
    certificate = certify(made)
    if not certificate.passed:
        reason = "overlap" if certificate.p.simple and certificate.q.simple else "not-simple"
        raise ConstructionError(reason, f"the certificate fails: {certificate.failure}")
    return made
