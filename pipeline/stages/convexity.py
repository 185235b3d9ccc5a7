"""Convexity of a batch of shapes: solidity and concavities (ours)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.planning import after_each
from pipeline.stages.shape_arrays import ErrorRow, attempt_each
from pipeline.stages.stage import Column, Stage, TableColumns
from pipeline.store.artifact import Artifact
from riot import scores


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: None) -> Artifact:
    """Batch of shapes → ``solidity`` (k,) float64, nan without a shape, and ``concavities`` (k,) int64, −1 without."""
    (batch,), (settings,) = inputs, parameters
    errors: list[ErrorRow] = []
    measures = attempt_each(batch, lambda shape: scores.convexity.convexity(shape, settings), errors)
    solidity = [math.nan if measure is None else measure.solidity for measure in measures]
    concavities = [-1 if measure is None else measure.concavities for measure in measures]
    arrays = {"solidity": np.array(solidity), "concavities": np.array(concavities, dtype=np.int64)}
    return Artifact(arrays, {"errors": errors})


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each batch."""
    return after_each(progress, "convexity", "ingest")


def _columns(artifact: Artifact) -> Mapping[str, Any]:
    return artifact.arrays


STAGE = Stage(
    name="convexity",
    unit="batches of shapes",
    after=("ingest",),
    parameters=("convexity",),
    items=items,
    run=run,
    scope="batch",
    bundle=16,
    tables=(
        TableColumns(
            "convexity",
            (
                Column("solidity", "float64", "area of the shape over that of its convex hull", "1"),
                Column("concavities", "int32", "concavities deeper than convexity.depth; −1 = not measured", "count"),
            ),
            _columns,
            "How convex each shape is (ours).",
        ),
    ),
)
