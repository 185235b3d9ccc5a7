"""The best partners of every shape of a query within other shards than its own (ours).

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
from pipeline.stages.partner_rows import best_rows, join, worst_of_best
from pipeline.stages.partners import TASK, Search, ShardPosition, Wanted, find_all, query_of, search_item
from pipeline.stages.partners import prepare as stack_or_index
from pipeline.stages.qcrs import COLUMNS
from pipeline.stages.shards import queries, searches, targets
from pipeline.stages.stage import Stage, SubBlocks
from pipeline.store.artifact import Artifact
from riot.types import IntArray

if TYPE_CHECKING:
    from riot.scores.index import TrunkIndex
    from riot.scores.trunk_stack import TrunkStack


SPARE = 8
"""How many times the expected number of a shape's best partners in its own shard are looked at to know how good those
elsewhere must be, with ``qcrs.mode=approximate``. Ours."""


def prepare(artifact: Artifact) -> TrunkStack | TrunkIndex | Artifact:
    """The stack of a batch's trunks, the index of a shard, or the partners in the own shard as they are."""
    return artifact if "trunk_i" in artifact.arrays else stack_or_index(artifact)


def run(inputs: Sequence[Any], parameters: Sequence[Any], spec: Search | SubBlock) -> Artifact:
    """Stacks of the query's batches, indices of shards, partners in the own shard → rows as those of
    `pipeline.stages.partners`, of all shards together.

    Without the last input, because that search failed, all partners in the shards count.
    """
    settings, count, mode = parameters
    search, stacks, rows = query_of(inputs, spec)
    shapes, wanted = sum(map(len, stacks)), Wanted(count, settings)
    least, few = np.zeros(shapes), None
    known_i, known_score = np.empty(0, np.int64), np.empty(0)
    for partners in inputs[search.batches + len(search.shards) :]:
        known_i, known_score = partners.arrays["i"], partners.arrays["score"]
        least = worst_of_best(known_i, known_score, shapes, search.rank or count)
        if mode == "approximate":
            few = promising_trunks(known_i, partners.arrays["promising"], shapes, count)
    found: list[Artifact] = []
    for number, position in enumerate(search.shards, start=search.batches):
        rows_there = find_all(stacks, inputs[number], wanted, position, rows, least, few)
        arrays = rows_there.arrays
        found.append(Artifact({**arrays, "j": arrays["j"] + np.int32(position.start)}, rows_there.document))
        # What is found in one shard narrows the search of the next.
        known_i, known_score = (
            np.concatenate(both) for both in ((known_i, arrays["i"]), (known_score, arrays["score"]))
        )
        order = np.lexsort((-known_score, known_i))
        known_i, known_score = known_i[order], known_score[order]
        least = np.maximum(least, worst_of_best(known_i, known_score, shapes, count))
    together = join(found)
    best = best_rows({name: together.arrays[name] for name in COLUMNS}, count)
    return Artifact({**together.arrays, **best}, together.document)


def promising_trunks(i: IntArray, promising: IntArray, shapes: int, count: int) -> dict[int, IntArray]:
    """The trunks of each of ``shapes`` shapes that promise partners, if it has ``count`` in its own shard, whose rows
    are ``i``; a shape that has fewer is not known well enough.

    >>> promising_trunks(np.array([0, 0, 1]), np.array([[0, 4], [0, 7], [1, 2]]), 2, 2)
    {0: array([4, 7])}
    """
    known = np.flatnonzero(np.bincount(i, minlength=shapes) >= count)
    return {int(k): promising[promising[:, 0] == k, 1].astype(np.int64) for k in known}


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each query in each target, without its own shard, by target, so that a worker reads it once."""
    own = {item.block[0]: item for item in progress.finished("partners") if item.block is not None}
    asked, rank, work = queries(progress), ranks(progress), []
    starts = [shard.members[0] for shard in progress.work["shards"]]
    for t, target in enumerate(targets(progress)):
        for q, query in enumerate(asked):
            shards = [s for s in target if s != query.shard]
            if shards:
                positions = (ShardPosition(-1, query.shard > s, starts[s] - starts[target[0]]) for s in shards)
                search = Search(len(query.batches), tuple(positions), rank[query.shard])
                known = [own[q]] if q in own else []
                work.append(search_item(progress, "partners_beyond", (q, t), query, search, shards, *known))
    return work


def ranks(progress: Progress) -> list[int]:
    """Which partner of its own shard a partner elsewhere need not be worse than, by shard; 0, the last, if exact.

    Of a shape's best partners in all shards as many are expected in one as it has of all shapes; with `SPARE` times as
    many the last of them is seldom nearer than the last of all.
    """
    count = progress.config.qcrs.k
    sizes = [len(shard.members) for shard in progress.work["shards"]]
    if progress.config.qcrs.mode != "approximate":
        return [0] * len(sizes)
    return [min(count, math.ceil(SPARE * count * size / sum(sizes))) for size in sizes]


STAGE = Stage(
    name="partners_beyond",
    unit="searches in other parts",
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
