"""The paper's method on the trunks of a certified construction, for comparison: its residuals and its deformation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.choose import best_certified
from pipeline.stages.construct import Spec
from pipeline.stages.modes import bends
from pipeline.stages.refine import unpack_plans
from pipeline.stages.shape_arrays import ErrorRow, attempt, expect_shape
from pipeline.stages.stage import Column, Stage, TableColumns
from pipeline.store.artifact import Artifact
from riot import construction, transform
from riot.errors import ConstructionError
from riot.parameters import ConstructParameters

if TYPE_CHECKING:
    from riot.construction.plan import ConstructionPlan
    from riot.transform.transform import Transform

COLUMNS = ("paper_iou", "paper_gaps", "paper_overlaps", "paper_outside", "paper_hausdorff")


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Spec | None) -> Artifact:
    """A certified construction → a document with the numbers `COLUMNS`, each of the worse shape or trunk.

    If its shapes may be bent, the batches of P and Q, the pair's CRS and refined trunks follow: the paper's method is
    tried on the trunks of the exact transform of the shapes as they are, whose ``unbent_iou`` is told too.
    """
    (constructed, *unbent), (settings, reach) = inputs, parameters
    exact = transform.riot_file.from_json(constructed.document["riot"])
    errors: list[ErrorRow] = []
    row: dict[str, Any] = {}
    if unbent and spec is not None:
        try:
            exact = _unbent(unbent, settings, reach, spec)
        except ConstructionError:  # only a bend makes this pair a transform
            return Artifact({}, {"errors": errors})
        row["unbent_iou"] = transform.deformation.measure_deformation(exact).iou

    def approximate() -> Transform:
        return construction.laplacian.method.construct_laplacian(same_trunks(exact, settings.snap, reach), settings)

    paper = attempt(0, approximate, errors)
    return Artifact({}, {**row, **({"errors": errors} if paper is None else _row(paper))})


def _unbent(inputs: Sequence[Artifact], settings: ConstructParameters, reach: float, spec: Spec) -> Transform:
    batch_p, batch_q, cross, refined = inputs
    (index_p, name_p), (index_q, name_q) = spec
    p, q = expect_shape(batch_p, index_p, name_p), expect_shape(batch_q, index_q, name_q)
    plans, unplanned = unpack_plans(refined, cross, p, q, reach)
    return construction.plan_transform.construct_plans(plans, unplanned, settings)


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
    """A work item for each of the best certified constructions, in order."""
    recipe = progress.recipes["paper"]
    best = best_certified(progress, progress.config.compare)
    if not bends(progress.config):
        return [recipe.after(item) for item in best]
    return [
        recipe.item(
            recipe.parts([item.key], item.spec),
            [item.reference, *item.sources[:4]],
            spec=item.spec,
            members=item.members,
        )
        for item in best
    ]


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
                Column(
                    "unbent_iou",
                    "float64",
                    "IoU of the worse shape of the exact transform without a bend; null = not compared, or none",
                    RATIO,
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
