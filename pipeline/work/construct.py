"""Construction and certificate of one selected pair."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pipeline.artifact import Artifact
from pipeline.work.items import ErrorRow, attempt, expect_shape
from pipeline.work.refine import unpack_plans
from riot.construct.choose import construct_plans
from riot.errors import ConstructionError, TrunkError
from riot.riotfile import to_json
from riot.transform import Transform

Spec = tuple[tuple[int, str], tuple[int, str]]
"""Local index and name of P and of Q; the names are in the file that is written."""


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Spec) -> Artifact:
    """Batches of P and Q, the pair's CRS and refined trunks → a document: status, reason, ``.riot`` text, numbers."""
    batch_p, batch_q, cross, refined = inputs
    settings, reach = parameters
    (index_p, name_p), (index_q, name_q) = spec
    p, q = expect_shape(batch_p, index_p, name_p), expect_shape(batch_q, index_q, name_q)
    plans, unplanned = unpack_plans(refined, cross, p, q, reach)
    if not plans and not unplanned:
        return _rejected("no-trunks", "no pair of full trunks has the same number of vertices")
    errors: list[ErrorRow] = []

    def made() -> Artifact:
        try:
            return _accepted(construct_plans(plans, unplanned, settings))
        except ConstructionError as error:
            return _rejected(error.reason, str(error))
        except TrunkError as error:
            return _rejected("trunks", str(error))

    result = attempt(0, made, errors)
    return result if result is not None else Artifact({}, {"status": "failed", "errors": errors})


def _accepted(transform: Transform) -> Artifact:
    certificate, deformation = transform.certificate(), transform.deformation()
    sides = {"p": certificate.p, "q": certificate.q}
    numbers = {
        "n": len(transform),
        **{name: float(getattr(deformation, name)) for name in DEFORMATION},
        "bound_p": float(transform.bound_p),
        "bound_q": float(transform.bound_q),
        **{f"{term}_{side}": float(getattr(of, term)) for side, of in sides.items() for term in RESIDUALS},
    }
    if not certificate.passed:
        return Artifact({}, {**_rejected("certificate", certificate.failure).document, **numbers})
    return Artifact({}, {"status": "certified", "reason": "", "message": "", "riot": to_json(transform), **numbers})


DEFORMATION = ("iou_p", "iou_q", "hausdorff_p", "hausdorff_q", "mean_distance_p", "mean_distance_q")
RESIDUALS = ("overlap", "gap", "hinge")


def _rejected(reason: str, message: str) -> Artifact:
    return Artifact({}, {"status": "rejected", "reason": reason, "message": message})
