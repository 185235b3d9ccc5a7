"""Descriptors of a batch of shapes, which tell how alike shapes are (ours)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.planning import after_each
from pipeline.stages.shape_arrays import ErrorRow, attempt_each
from pipeline.stages.stage import Stage
from pipeline.store.artifact import Artifact
from riot import scores


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: None) -> Artifact:
    """Batch → ``described`` (k,) bool, and the arrays of the `DescriptorIndex` of those described, in order."""
    (batch,) = inputs
    errors: list[ErrorRow] = []
    descriptors = attempt_each(batch, scores.descriptor.descriptor, errors)
    described = np.array([item is not None for item in descriptors], dtype=np.bool_)
    stacked = scores.likeness.DescriptorIndex.build([item for item in descriptors if item is not None])
    return Artifact({"described": described, **stacked.to_arrays()}, {"errors": errors})


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each batch."""
    return after_each(progress, "likeness", "ingest")


STAGE = Stage(
    name="likeness",
    unit="batches of shapes",
    after=("ingest",),
    parameters=(),
    items=items,
    run=run,
    scope="batch",
    bundle=16,
)
