"""The best partners of every shape of a query within its own shard, scored as in a run over all pairs (ours).

`partners_beyond` looks into the other shards, only for partners that are as good. With ``qcrs.mode=approximate`` it
compares there only those trunks of a shape that are near to some trunk here: a twentieth of them gives nearly all of a
shape's best partners.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import accumulate
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.sub_block import SubBlock
from pipeline.plan.work_item import WorkItem
from pipeline.stages.partner_rows import NONE_KNOWN, best_rows, join
from pipeline.stages.qcrs import COLUMNS, stack_of_batch
from pipeline.stages.reused_search import ReusingSearch, search_exactly, whole_search
from pipeline.stages.search_spec import Search, ShardPosition, Wanted
from pipeline.stages.shards import Query, is_shard, queries, searches, unpack
from pipeline.stages.stage import Stage, SubBlocks
from pipeline.store.artifact import Artifact
from riot import scores
from riot.types import IntArray

if TYPE_CHECKING:
    from riot.scores.index import Partners, TrunkIndex
    from riot.scores.trunk_stack import TrunkStack

MARGIN = 1.1
"""How many times as far from a trunk in the own shard as the last partner a trunk may be to be compared beyond, with
``qcrs.mode=approximate``. Ours: .99 of the best partners are found, at the least price."""

TASK = 64
"""Batches that are searched for in a shard, at most, once it is read, which takes as long as a few searches (ours)."""


def prepare(artifact: Artifact) -> TrunkStack | TrunkIndex | Artifact:
    """The stack of a batch's trunks, or the index of a shard; another search as it is."""
    if "trunk_i" in artifact.arrays:
        return artifact
    return unpack(artifact) if is_shard(artifact) else stack_of_batch(artifact)


def run(inputs: Sequence[Any], parameters: Sequence[Any], spec: Search | SubBlock | ReusingSearch) -> Artifact:
    """Stacks of the query's batches and index of its shard → rows, each i's best first.

    i numbers the query's shapes, j the shard's. A `SubBlock` restricts the rows i. Only scores above 0 count; among
    equals the earlier j comes first. Score, ``trunk_i``, ``trunk_j`` and ``shift`` are of the pair with its earlier
    shape first, in whichever direction it was searched. ``promising`` (p, 2) are, in the approximate mode,
    shapes of the query and their trunks that are worth comparing in other shards; in the exact one there are the arrays
    `SEARCHED`.
    """
    settings, count, mode = parameters
    wanted = Wanted(count, settings, MARGIN if mode == "approximate" else 1.0)
    if mode == "approximate":
        search, stacks, rows = query_of(inputs, spec)
        return find_all(stacks, inputs[search.batches], wanted, search.shards[0], rows)

    def find_some(stacks: Sequence[TrunkStack], rows: IntArray) -> Artifact:
        search = whole_search(spec)
        runs = [range(run[0], run[-1] + 1) for run in np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)]
        index = inputs[search.batches]
        return join([find_all(stacks, index, wanted, search.shards[0], run) for run in runs])

    return search_exactly(inputs, spec, wanted, NONE_KNOWN, find_some)


def query_of(inputs: Sequence[Any], spec: Search | SubBlock | ReusingSearch) -> tuple[Search, list[TrunkStack], range]:
    """What a work item searches, the stacks of its query, and which of the query's shapes are searched for."""
    search = whole_search(spec)
    stacks = list(inputs[: search.batches])
    return search, stacks, range(*spec.rows) if isinstance(spec, SubBlock) else range(sum(map(len, stacks)))


def find_all(
    stacks: Sequence[TrunkStack],
    index: TrunkIndex,
    wanted: Wanted,
    position: ShardPosition,
    rows: range,
) -> Artifact:
    """`find` of a query of several batches: ``rows`` number its shapes through all of them."""
    found = []
    for stack, start in zip(stacks, accumulate(map(len, stacks), initial=0), strict=False):
        here = range(max(rows.start - start, 0), min(rows.stop - start, len(stack)))
        if len(here) == 0:
            continue
        place = replace(position, first=position.first + start) if position.first >= 0 else position
        artifact = find(stack, index, wanted, place, here)
        shift = {"i": artifact.arrays["i"] + np.int32(start), "promising": artifact.arrays["promising"] + [start, 0]}
        shift["promising"] = shift["promising"].astype(np.int32)
        found.append(Artifact({**artifact.arrays, **shift}, artifact.document))
    return join(found)


def find(
    query: TrunkStack,
    index: TrunkIndex,
    wanted: Wanted,
    position: ShardPosition,
    rows: range,
) -> Artifact:
    """The rows that `run` returns, of the shapes ``rows`` of a batch."""
    partners = [_nearest(query.shapes[i], index, wanted, position, i) for i in rows]
    i = np.repeat(rows, [len(nearest.scores.j) for nearest in partners]).astype(np.int32)
    columns = {
        name: np.concatenate([np.empty(0, np.int32), *(getattr(nearest.scores, name) for nearest in partners)])
        for name in COLUMNS
    }
    columns["i"] = i
    turned = columns["j"] < np.array([position.earlier(i, len(index)) for i in range(len(query))] + [0])[i]
    first, second = columns["trunk_i"].copy(), columns["trunk_j"]
    columns["trunk_i"], columns["trunk_j"] = np.where(turned, second, first), np.where(turned, first, second)
    best = best_rows(columns, wanted.count)
    promising = [
        np.column_stack([np.full(len(nearest.promising), k), nearest.promising[:, 1]])
        for k, nearest in zip(rows, partners, strict=True)
    ]
    trunks = np.concatenate([np.empty((0, 2), np.int32), *promising]).astype(np.int32)
    return Artifact({**best, "promising": trunks})


def _nearest(shape: TrunkStack, index: TrunkIndex, wanted: Wanted, position: ShardPosition, i: int) -> Partners:
    """The best partners of shape i of a query, and as many more as score like the last one: the earlier ones count."""
    asked, itself = wanted.count + 1, [position.first + i if position.first >= 0 else -1]
    earlier = [position.earlier(i, len(index))]
    while True:
        nearest = scores.index.best_partners(index, shape, asked, wanted.settings, 0.0, itself, wanted.margin, earlier)
        score = nearest.scores.score
        if len(score) < asked or score[-1] < score[wanted.count - 1]:
            return nearest
        asked *= 2


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each query, in its own shard."""
    work = []
    for number, query in enumerate(queries(progress)):
        first = query.members[0] - progress.work["shards"][query.shard].members[0]
        search = Search(len(query.batches), (ShardPosition(first, False),))
        work.append(search_item(progress, "partners", (number, query.shard), query, search, [query.shard]))
    return work


def search_item(
    progress: Progress,
    stage: str,
    block: tuple[int, int],
    query: Query,
    search: Search,
    shards: Sequence[int],
    *more: WorkItem,
) -> WorkItem:
    """The work item of a search in ``shards``, which reads ``more``; ``block`` numbers the query and the target."""
    recipe = progress.recipes[stage]
    batches = [progress.work["trunks"][b] for b in query.batches]
    searched = [progress.work["shards"][s] for s in shards]
    sources = [*batches, *searched, *more]
    return recipe.item(
        recipe.parts([source.key for source in sources], search),
        [source.reference for source in sources],
        spec=search,
        members=query.members,
        block=block,
        pairs=len(query.members) * sum(len(item.members) for item in searched),
    )


STAGE = Stage(
    name="partners",
    unit="searches in parts",
    after=("shards",),
    parameters=("qcrs", "qcrs.k", "qcrs.mode"),
    items=items,
    run=run,
    scope="block",
    prepare=prepare,
    wanted=searches,
    searches=TASK,
    sub_blocks=SubBlocks(join, columns_are_shapes=False),
)
