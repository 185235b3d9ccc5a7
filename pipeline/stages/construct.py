"""Construction and certificate of one selected pair."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from pipeline.stages.items import ErrorRow, attempt, expect_shape
from pipeline.stages.refine import unpack_plans
from pipeline.store.artifact import Artifact
from riot.construction.choose import construct_plans
from riot.errors import ConstructionError, TrunkError
from riot.transform.certificate import certify
from riot.transform.deformation import Deformation, change_ratio, measure_deformation
from riot.transform.fidelity import bending_ratio, direction_error
from riot.transform.riot_file import to_json
from riot.transform.transform import Transform

Spec = tuple[tuple[int, str], tuple[int, str]]
"""Local index and name of P and of Q; the names are in the file that is written."""


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Spec) -> Artifact:
    """Batches of P and Q, the pair's CRS and refined trunks → a document: status, reason, ``.riot`` text, numbers.

    A transform by the paper's method is ``approximate``: it has text and numbers, and its certificate fails.
    """
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
            return _measured(construct_plans(plans, unplanned, settings), settings.method)
        except ConstructionError as error:
            return _rejected(error.reason, str(error))
        except TrunkError as error:
            return _rejected("trunks", str(error))

    result = attempt(0, made, errors)
    return result if result is not None else Artifact({}, {"status": "failed", "errors": errors})


def _measured(transform: Transform, method: str) -> Artifact:
    certificate, deformation = certify(transform), measure_deformation(transform)
    sides = {"p": certificate.p, "q": certificate.q}
    numbers = {
        "n": len(transform),
        **{name: float(getattr(deformation, name)) for name in DEFORMATION},
        "bound_p": float(transform.bound_p),
        "bound_q": float(transform.bound_q),
        **_fidelity(transform, deformation),
        **{f"{term}_{side}": float(getattr(of, term)) for side, of in sides.items() for term in RESIDUALS},
    }
    if certificate.passed:
        said = {"status": "certified", "reason": "", "message": ""}
    elif method == "laplacian":  # its pieces overlap and leave gaps by nature
        said = {"status": "approximate", "reason": "method", "message": certificate.failure}
    else:
        return Artifact({}, {**_rejected("certificate", certificate.failure).document, **numbers})
    return Artifact({}, {**said, "riot": to_json(transform), **numbers})


def _fidelity(transform: Transform, deformation: Deformation) -> dict[str, float | None]:
    """The numbers `FIDELITY`; 10 ms a pair."""
    changes = (
        change_ratio(deformation.iou_p, transform.bound_p),
        change_ratio(deformation.iou_q, transform.bound_q),
    )
    p, q = (transform.outline_p(), transform.p.points), (transform.outline_q(), transform.q.points)
    return {
        "change_ratio": max((change for change in changes if not math.isnan(change)), default=None),
        "bending_p": bending_ratio(*p),
        "bending_q": bending_ratio(*q),
        "direction_p": direction_error(*p),
        "direction_q": direction_error(*q),
    }


DEFORMATION = ("iou_p", "iou_q", "hausdorff_p", "hausdorff_q", "mean_distance_p", "mean_distance_q")
FIDELITY = ("change_ratio", "bending_p", "bending_q", "direction_p", "direction_q")
RESIDUALS = ("overlap", "gap", "hinge")


def _rejected(reason: str, message: str) -> Artifact:
    return Artifact({}, {"status": "rejected", "reason": reason, "message": message})
