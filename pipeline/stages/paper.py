"""The paper's method beside a certified construction, on the same trunks: what it leaves over, and how close it is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pipeline.stages.items import ErrorRow, attempt
from pipeline.store.artifact import Artifact
from riot.construction.given import given_pair
from riot.construction.laplacian.method import construct_laplacian
from riot.construction.laplacian.residual import residuals
from riot.construction.plan import Plan
from riot.transform.deformation import measure_deformation
from riot.transform.riot_file import from_json
from riot.transform.transform import Transform

COLUMNS = ("paper_iou", "paper_gaps", "paper_overlaps", "paper_outside", "paper_hausdorff")
"""What `transforms` has of it."""


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: None) -> Artifact:
    """A certified construction → a document: the numbers `COLUMNS`, of the worse shape or trunk each."""
    (made,), (settings, reach) = inputs, parameters
    transform = from_json(made.document["riot"])
    errors: list[ErrorRow] = []
    paper = attempt(0, lambda: construct_laplacian(same_trunks(transform, settings.snap, reach), settings), errors)
    return Artifact({}, {"errors": errors} if paper is None else _row(paper))


def same_trunks(transform: Transform, snap: float, reach: float) -> Plan:
    """The plan of a transform's own conjugate trunks; its arcs part where the transform's do.

    Not made conjugate once more from these points: the paper's method would get other trunks, most of them worse.
    Raises `riot.errors.TrunkError` if the points do not correspond; ``snap`` and ``reach`` as in `given_pair`.
    """
    pair = given_pair(transform.p, transform.q, transform.trunk_p, transform.trunk_q, snap, reach)
    trunks = np.stack([transform.pose(0.0).origins, transform.pose(1.0).origins])
    return Plan(pair, trunks, transform.bound_p, transform.bound_q)


def _row(paper: Transform) -> dict[str, Any]:
    worse = max(residuals(paper), key=lambda residual: residual.total)
    deformation = measure_deformation(paper)
    far = max(deformation.hausdorff_p, deformation.hausdorff_q)
    return dict(zip(COLUMNS, (deformation.iou, worse.gaps, worse.overlaps, worse.outside, far), strict=True))
