"""Descriptors of a batch of shapes, which tell how alike shapes are (ours)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.planning import after_each
from pipeline.stages.shape_arrays import ErrorRow, attempt_each
from pipeline.stages.stage import Stage
from pipeline.store.artifact import Artifact
from riot import scores
from riot.geometry.shape import Shape

if TYPE_CHECKING:
    from riot.scores.descriptor import Descriptor


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: None) -> Artifact:
    """Batch → ``described`` (k,) bool; of those described ``elongation``, ``perimeter``, `DescriptorIndex`."""
    (batch,) = inputs
    errors: list[ErrorRow] = []
    results = attempt_each(batch, _described, errors)
    described = [result for result in results if result is not None]
    stacked = scores.likeness.DescriptorIndex.build([descriptor for descriptor, _, _ in described])
    arrays = {
        "described": np.array([result is not None for result in results], dtype=np.bool_),
        "elongation": np.array([elongation for _, elongation, _ in described], dtype=np.float64),
        "perimeter": np.array([perimeter for _, _, perimeter in described], dtype=np.float64),
    }
    return Artifact({**arrays, **stacked.to_arrays()}, {"errors": errors})


def _described(shape: Shape) -> tuple[Descriptor, float, float]:
    return scores.descriptor.descriptor(shape), scores.surprise.elongation(shape.points), shape.perimeter


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
