"""Shards: an index over the trunks of neighbouring batches, of bounded size, for the search of partners (ours)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from pipeline.config.schema import Config
from pipeline.plan.batches import SPREAD, batches_in_a_group, cut
from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.qcrs import stack_of_batch
from pipeline.stages.stage import Stage
from pipeline.store.artifact import Artifact
from riot import scores

if TYPE_CHECKING:
    from riot.scores.index import TrunkIndex
    from riot.scores.trunk_stack import TrunkStack

SHAPES_PER_SHARD = 1536
"""Mean number of shapes in a shard, at most half as many more: what a worker maps at once, 0.2 MB a shape. Half as many
take a tenth longer to search (measured on MPEG-7, ours)."""

TARGET = 32
"""Mean number of neighbouring shards that are searched one after the other, each with what those before have found
(ours): a search in twice as many takes less than twice as long."""


@dataclass(frozen=True)
class Query:
    """Shapes whose partners are searched for at once: ``members`` are their positions, ``batches`` the numbers of their
    batches, which are neighbours in the shard of this number."""

    shard: int
    batches: Sequence[int]
    members: tuple[int, ...]


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
        contents = [_first_picture(progress, number) for number in present[low:high]]
        cuts = cut(contents, max(1, SHAPES_PER_SHARD // progress.config.batch), SPREAD)
        ranges += [present[low + span.start : low + span.stop] for span in cuts]
    return ranges


def _first_picture(progress: Progress, batch: int) -> str:
    # By a picture, not by a key: an edit of code or of a parameter leaves the spans as they are. By the first one only:
    # a new picture elsewhere in a batch does not move its shapes, and their neighbours', into another shard.
    return progress.work["ingest"][batch].parts.inputs[0]


def queries(progress: Progress) -> list[Query]:
    """All queries, in order: each shard divided evenly into as many batches as a group has."""
    mean = batches_in_a_group(len(progress.batches), progress.config.batch)
    found = []
    for number, span in enumerate(spans(progress)):
        parts = max(1, round(len(span) / mean))
        cuts = [len(span) * part // parts for part in range(parts + 1)]
        for batches in (span[low:high] for low, high in pairwise(cuts)):
            positions = range(progress.batches[batches[0]].start, progress.batches[batches[-1]].stop)
            found.append(Query(number, batches, tuple(positions)))
    return found


def targets(progress: Progress) -> list[range]:
    """Numbers of the neighbouring shards that are searched one after the other.

    A shard that failed is by itself, and none lies between others: a target's shapes are neighbours.
    """
    of_batches, shards = spans(progress), progress.work["shards"]
    apart = [number for number, item in enumerate(shards) if item.reference not in progress.done]
    gaps = [number for number in range(1, len(of_batches)) if of_batches[number][0] != of_batches[number - 1][-1] + 1]
    breaks = sorted({0, len(of_batches), *gaps, *apart, *(number + 1 for number in apart)})
    found = []
    for low, high in pairwise(breaks):
        cuts = cut([_first_picture(progress, of_batches[number][0]) for number in range(low, high)], TARGET, SPREAD)
        found += [range(low + part.start, low + part.stop) for part in cuts]
    return found


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
