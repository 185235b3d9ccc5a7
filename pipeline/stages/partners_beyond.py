"""The best partners of every shape of a batch within another shard than its own (ours).

The partners that a shape has in its own shard say how good those elsewhere must be to count, and, with
``qcrs.mode=approximate``, which of its trunks are compared.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.sub_block import SubBlock
from pipeline.plan.work_item import WorkItem
from pipeline.stages.partners import TASK, ShardPosition, Wanted, find, join, rows_of, search_item
from pipeline.stages.partners import prepare as stack_or_index
from pipeline.stages.shards import searches, spans
from pipeline.stages.stage import Stage, SubBlocks
from pipeline.store.artifact import Artifact
from riot.types import FloatArray, IntArray

if TYPE_CHECKING:
    from riot.scores.index import TrunkIndex
    from riot.scores.trunk_stack import TrunkStack


SPARE = 8
"""How many times the expected number of a shape's best partners in its own shard are looked at to know how good those
elsewhere must be, with ``qcrs.mode=approximate``. Ours."""


def prepare(artifact: Artifact) -> TrunkStack | TrunkIndex | Artifact:
    """The stack of a batch's trunks, the index of a shard, or the partners in the own shard as they are."""
    return artifact if "trunk_i" in artifact.arrays else stack_or_index(artifact)


def run(inputs: Sequence[Any], parameters: Sequence[Any], spec: ShardPosition | SubBlock) -> Artifact:
    """Stack of a batch, index of a shard, partners in the own shard → rows as those of `pipeline.stages.partners`.

    Without the third input, because that search failed, all partners in the shard count.
    """
    settings, count, mode = parameters
    query, index, *own = inputs
    position, rows = rows_of(spec, query)
    least, few = np.zeros(len(query)), None
    for partners in own:
        i, score = partners.arrays["i"], partners.arrays["score"]
        least = worst_of_best(i, score, len(query), position.rank or count)
        if mode == "approximate":
            few = promising_trunks(i, partners.arrays["promising"], len(query), count)
    return find(query, index, Wanted(count, settings), position, rows, least, few)


def promising_trunks(i: IntArray, promising: IntArray, shapes: int, count: int) -> dict[int, IntArray]:
    """The trunks of each of ``shapes`` shapes that promise partners, if it has ``count`` in its own shard, whose rows
    are ``i``; a shape that has fewer is not known well enough.

    >>> promising_trunks(np.array([0, 0, 1]), np.array([[0, 4], [0, 7], [1, 2]]), 2, 2)
    {0: array([4, 7])}
    """
    known = np.flatnonzero(np.bincount(i, minlength=shapes) >= count)
    return {int(k): promising[promising[:, 0] == k, 1].astype(np.int64) for k in known}


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
    rank = ranks(progress)
    work = []
    for s, span in enumerate(spans(progress)):
        for b in searched:
            if b not in span:
                known = [own[b]] if b in own else []
                position = ShardPosition(-1, b > span[-1], rank[b])
                work.append(search_item(progress, "partners_beyond", (b, s), position, *known))
    return work


def ranks(progress: Progress) -> dict[int, int]:
    """Which partner of its own shard a partner of each batch elsewhere need not be worse than; 0, the last, if exact.

    Of a shape's best partners in all shards as many are expected in one as it has of all shapes; with `SPARE` times as
    many the last of them is seldom nearer than the last of all.
    """
    count = progress.config.qcrs.k
    shards, parts = progress.work["shards"], spans(progress)
    total = sum(len(shard.members) for shard in shards)
    if progress.config.qcrs.mode != "approximate":
        return {number: 0 for span in parts for number in span}
    return {
        number: min(count, math.ceil(SPARE * count * len(shard.members) / total))
        for shard, span in zip(shards, parts, strict=True)
        for number in span
    }


STAGE = Stage(
    name="partners_beyond",
    unit="searches of batches in other parts",
    after=("partners",),
    parameters=("qcrs", "qcrs.k", "qcrs.mode"),
    items=items,
    run=run,
    scope="block",
    prepare=prepare,
    wanted=searches,
    searches=TASK,
    sub_blocks=SubBlocks(join, columns_are_shapes=False),
)
