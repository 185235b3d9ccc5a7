"""The paper's method on the trunks of a certified construction, for comparison: its residuals and its deformation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.construct import least_deformed
from pipeline.stages.shape_arrays import ErrorRow, attempt
from pipeline.stages.stage import Column, Stage, TableColumns
from pipeline.store.artifact import Artifact
from riot import construction, transform

if TYPE_CHECKING:
    from riot.construction.plan import ConstructionPlan
    from riot.transform.transform import Transform

COLUMNS = ("paper_iou", "paper_gaps", "paper_overlaps", "paper_outside", "paper_hausdorff")


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: None) -> Artifact:
    """A certified construction → a document with the numbers `COLUMNS`, each of the worse shape or trunk."""
    (constructed,), (settings, reach) = inputs, parameters
    exact = transform.riot_file.from_json(constructed.document["riot"])
    errors: list[ErrorRow] = []

    def approximate() -> Transform:
        return construction.laplacian.method.construct_laplacian(same_trunks(exact, settings.snap, reach), settings)

    paper = attempt(0, approximate, errors)
    return Artifact({}, {"errors": errors} if paper is None else _row(paper))


def same_trunks(exact: Transform, snap: float, reach: float) -> ConstructionPlan:
    """The plan of a transform's own conjugate trunks, whose arcs begin and end where the transform's do.

    The trunks are not made conjugate again: the paper's method would get other trunks, most of them worse.
    Raises `riot.errors.TrunkError` if the points do not correspond; ``snap`` and ``reach`` as in `given_pair`.
    """
    pair = construction.given_trunks.given_pair(exact.p, exact.q, exact.trunk_p, exact.trunk_q, snap, reach)
    trunks = np.stack([exact.pose(0.0).origins, exact.pose(1.0).origins])
    return construction.plan.ConstructionPlan(pair, trunks, exact.bound_p, exact.bound_q)


def _row(paper: Transform) -> dict[str, Any]:
    worse = max(construction.laplacian.residual.residuals(paper), key=lambda residual: residual.total)
    deformation = transform.deformation.measure_deformation(paper)
    far = max(deformation.hausdorff_p, deformation.hausdorff_q)
    return dict(zip(COLUMNS, (deformation.iou, worse.gaps, worse.overlaps, worse.outside, far), strict=True))


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each of the least deformed certified constructions, in order."""
    best = least_deformed(progress, progress.config.compare)
    return [progress.recipes["paper"].after(item) for item in best]


RATIO, AREA, OF_L_C = "1", "unit-area frame", "L_c = 2*sqrt(pi)"

STAGE = Stage(
    name="paper",
    unit="best transforms",
    after=("construct", "motion"),
    parameters=("construct", "refine.reach"),
    items=items,
    run=run,
    scope="pair",
    known_after="construct",
    wanted=lambda config: config.compare > 0,
    at_most=lambda config: min(config.compare, config.select.top),
    tables=(
        TableColumns(
            "transforms",
            (
                Column(
                    "paper_iou", "float64", "IoU of the worse shape by the paper's method; null = not compared", RATIO
                ),
                Column("paper_gaps", "float64", "area of its gaps in the trunk of the greatest residual", AREA),
                Column("paper_overlaps", "float64", "area of its overlaps in that trunk", AREA),
                Column("paper_outside", "float64", "area of its pieces outside of that trunk", AREA),
                Column("paper_hausdorff", "float64", "symmetric Hausdorff distance of its worse shape", OF_L_C),
            ),
            lambda artifact: artifact.document,
        ),
    ),
)
