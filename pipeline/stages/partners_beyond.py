"""The best partners of every shape of a query within other shards than its own (ours).

The partners that a shape has in its own shard say how good those elsewhere must be to count, and, with
``qcrs.mode=approximate``, which of its trunks are compared.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.sub_block import SubBlock
from pipeline.plan.work_item import WorkItem
from pipeline.stages.joined_search import known_distances, promising_only, search_shards
from pipeline.stages.partner_rows import NONE_KNOWN, join
from pipeline.stages.partners import prepare, query_of, search_item
from pipeline.stages.reused_search import ReusingSearch, search_exactly, whole_search
from pipeline.stages.search_spec import Search, ShardPosition, Wanted
from pipeline.stages.shards import queries, searches, targets
from pipeline.stages.stage import Stage, SubBlocks
from pipeline.store.artifact import Artifact
from riot import scores
from riot.types import IntArray

if TYPE_CHECKING:
    from riot.scores.trunk_stack import TrunkStack


def run(inputs: Sequence[Any], parameters: Sequence[Any], spec: Search | SubBlock | ReusingSearch) -> Artifact:
    """Stacks of the query's batches, indices of shards, partners in the own shard → rows as those of
    `pipeline.stages.partners`, of all shards together.

    Without the last input, because that search failed, all partners in the shards count.
    """
    settings, count, mode = parameters
    search = whole_search(spec)
    end = spec.inputs if isinstance(spec, ReusingSearch) else len(inputs)
    partners = [partners.arrays for partners in inputs[search.batches + len(search.shards) : end]]

    def find(stacks: Sequence[TrunkStack], rows: Iterable[int]) -> Artifact:
        whole, some = scores.index.join(stacks), set(rows)
        few = {shape: np.empty(0, np.int64) for shape in range(len(whole)) if shape not in some}
        known = np.full((len(whole), count), np.inf)
        for arrays in partners:
            i = arrays["i"].astype(np.int64)
            known = known_distances(i, arrays["score"], len(whole), count)
            if mode == "approximate":
                few = {**promising_trunks(i, arrays["promising"], len(whole), count), **few}
        query, numbers = promising_only(whole, few)
        shards = (
            (inputs[number], position.after, position.start)
            for number, position in enumerate(search.shards, start=search.batches)
        )
        return search_shards(query, shards, known, settings, numbers)

    if mode == "approximate":
        _, stacks, rows = query_of(inputs, spec)
        return find(stacks, rows)
    return search_exactly(inputs, spec, Wanted(count, settings), partners[0] if partners else NONE_KNOWN, find)


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
    asked, work = queries(progress), []
    starts = [shard.members[0] for shard in progress.work["shards"]]
    for t, target in enumerate(targets(progress)):
        for q, query in enumerate(asked):
            shards = [s for s in target if s != query.shard]
            if shards:
                positions = (ShardPosition(-1, query.shard > s, starts[s] - starts[target[0]]) for s in shards)
                search = Search(len(query.batches), tuple(positions))
                known = [own[q]] if q in own else []
                work.append(search_item(progress, "partners_beyond", (q, t), query, search, shards, *known))
    return work


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
    searches=1,
    sub_blocks=SubBlocks(join, columns_are_shapes=False),
)
