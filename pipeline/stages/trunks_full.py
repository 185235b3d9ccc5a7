"""Full trunks of one selected shape (paper §4.1)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.planning import of_shapes
from pipeline.stages.select import selected
from pipeline.stages.shape_arrays import ErrorRow, attempt, expect_shape
from pipeline.stages.stage import Stage
from pipeline.stages.trunk_arrays import pack_trunks
from pipeline.store.artifact import Artifact
from riot import scores


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: int) -> Artifact:
    """The shape at ``spec`` of a batch → its trunks, packed as a batch of one."""
    (batch,), (settings,) = inputs, parameters
    errors: list[ErrorRow] = []
    shape = expect_shape(batch, spec)
    trunks = attempt(0, lambda: scores.trunks.full_trunks(shape, settings), errors)
    return Artifact(pack_trunks([trunks]), {"errors": errors})


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each shape of the selected pairs, by position."""
    return of_shapes(progress, "trunks_full", selected(progress).pairs.ravel().tolist())


STAGE = Stage(
    name="trunks_full",
    unit="shapes",
    after=("select",),
    parameters=("trunks",),
    items=items,
    run=run,
    scope="shape",
    known_after="select",
    at_most=lambda config: 2 * config.select.selected,
    bundle=16,
)
