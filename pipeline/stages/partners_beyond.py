"""The best partners of every shape of a batch within another shard than its own (ours).

The partners that a shape has in its own shard say how good those elsewhere must be to count.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.sub_block import SubBlock
from pipeline.plan.work_item import WorkItem
from pipeline.stages.partners import ShardPosition, join, search, search_item
from pipeline.stages.partners import prepare as stack_or_index
from pipeline.stages.shards import searches, spans
from pipeline.stages.stage import Stage, SubBlocks
from pipeline.store.artifact import Artifact
from riot.types import FloatArray, IntArray

if TYPE_CHECKING:
    from riot.scores.index import TrunkIndex
    from riot.scores.trunk_stack import TrunkStack


def prepare(artifact: Artifact) -> TrunkStack | TrunkIndex | Artifact:
    """The stack of a batch's trunks, the index of a shard, or the partners in the own shard as they are."""
    return artifact if "trunk_i" in artifact.arrays else stack_or_index(artifact)


def run(inputs: Sequence[Any], parameters: Sequence[Any], spec: ShardPosition | SubBlock) -> Artifact:
    """Stack of a batch, index of a shard, partners in the own shard → rows as those of `pipeline.stages.partners`.

    Without the third input, because that search failed, all partners in the shard count.
    """
    settings, count = parameters
    query, index, *own = inputs
    least = np.zeros(len(query))
    for partners in own:
        least = worst_of_best(partners.arrays["i"], partners.arrays["score"], len(query), count)
    return search(query, index, count, settings, spec, least)


def worst_of_best(i: IntArray, score: FloatArray, shapes: int, count: int) -> FloatArray:
    """(shapes,) the score of each shape's partner number ``count``; 0 for a shape that has fewer.

    ``i`` ascends, and each i's scores descend.

    >>> worst_of_best(np.array([0, 0, 2]), np.array([0.9, 0.8, 0.7]), 3, 2).tolist()
    [0.8, 0.0, 0.0]
    """
    last = np.searchsorted(i, np.arange(shapes)) + count - 1
    enough = last < np.searchsorted(i, np.arange(shapes), side="right")
    least = np.zeros(shapes)
    least[enough] = score[last[enough]]
    return least


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each batch in each shard that it is not in, by shard, so that a worker reads a shard once."""
    own = {item.block[0]: item for item in progress.finished("partners") if item.block is not None}
    searched = [number for span in spans(progress) for number in span]
    work = []
    for s, span in enumerate(spans(progress)):
        for b in searched:
            if b not in span:
                known = [own[b]] if b in own else []
                work.append(search_item(progress, "partners_beyond", (b, s), ShardPosition(-1, b > span[-1]), *known))
    return work


STAGE = Stage(
    name="partners_beyond",
    unit="searches of batches in other parts",
    after=("partners",),
    parameters=("qcrs", "qcrs.k"),
    items=items,
    run=run,
    scope="block",
    prepare=prepare,
    wanted=searches,
    tile=8,
    sub_blocks=SubBlocks(join, columns_are_shapes=False),
)
