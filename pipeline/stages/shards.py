"""Shards: an index over the trunks of neighbouring batches, of bounded size, for the search of partners (ours)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from pipeline.config.schema import Config
from pipeline.plan.batches import cut
from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.qcrs import stack_of_batch
from pipeline.stages.stage import Stage
from pipeline.store.artifact import Artifact
from riot import scores

if TYPE_CHECKING:
    from riot.scores.index import TrunkIndex
    from riot.scores.trunk_stack import TrunkStack

SHAPES_PER_SHARD = 640
"""Mean number of shapes in a shard, at most twice as many: what a worker holds at once, about 0.4 MB a shape while it
is read. Fewer take longer to search; more would grow with the collection (measured on MPEG-7, ours)."""


def run(inputs: Sequence[TrunkStack], parameters: Sequence[Any], spec: None) -> Artifact:
    """Stacks of batches → their index, which numbers the shapes in the order of the batches."""
    return Artifact(scores.index.TrunkIndex.build(list(inputs)).to_arrays())


def is_shard(artifact: Artifact) -> bool:
    """Whether an artifact is a shard, and not a batch's trunks."""
    return "cells.groups" in artifact.arrays


def unpack(shard: Artifact) -> TrunkIndex:
    """The index that `run` made."""
    return scores.index.TrunkIndex.from_arrays(shard.arrays)


def spans(progress: Progress) -> list[Sequence[int]]:
    """Numbers of the batches in each shard: of all batches whose trunks are done.

    Shards are runs of neighbouring batches, cut by content as batches are, so that a new shape changes its own.
    """
    present = [number for number, item in enumerate(progress.work["trunks"]) if item.reference in progress.done]
    breaks = [index for index in range(1, len(present)) if present[index] != present[index - 1] + 1]
    ranges: list[Sequence[int]] = []
    for low, high in pairwise([0, *breaks, len(present)]):
        # By the pictures, not by the keys: an edit of code or of a parameter leaves the spans as they are.
        contents = ["".join(progress.work["ingest"][number].parts.inputs) for number in present[low:high]]
        cuts = cut(contents, max(1, SHAPES_PER_SHARD // progress.config.batch))
        ranges += [present[low + span.start : low + span.stop] for span in cuts]
    return ranges


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each shard."""
    recipe, trunks = progress.recipes["shards"], progress.work["trunks"]
    return [
        recipe.item(
            recipe.parts([trunks[number].key for number in span]),
            [trunks[number].reference for number in span],
            members=[position for number in span for position in progress.batches[number]],
        )
        for span in spans(progress)
    ]


def searches(config: Config) -> bool:
    """Whether a run looks for each shape's best partners through an index, instead of scoring every pair."""
    return config.qcrs.mode != "all"


STAGE = Stage(
    name="shards",
    unit="parts of the index",
    after=("trunks",),
    parameters=(),
    items=items,
    run=run,
    scope="collection",
    prepare=stack_of_batch,
    wanted=searches,
)
