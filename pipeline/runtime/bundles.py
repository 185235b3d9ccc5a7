"""Tasks: which work items of a stage a worker gets at once, so that it reads few inputs and none is left idle."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pipeline.plan.sub_block import Sides
from pipeline.plan.work_item import Reference, WorkItem
from pipeline.runtime.clusters import Bundle
from pipeline.stages.all import BY_NAME
from pipeline.stages.block_rows import ReusingBlock
from pipeline.stages.reused_search import whole_search

TASKS_PER_WORKER = 4


def bundles(items: Sequence[WorkItem], workers: int) -> list[Bundle]:
    """Group work items of one stage into tasks: up to the stage's bundle or tile, but enough tasks for every worker."""
    if not items:
        return []
    stage, least = BY_NAME[items[0].stage], TASKS_PER_WORKER * workers
    if stage.searches:
        widest = max(whole_search(item.spec).batches for item in items)
        return searches(items, max(1, min(stage.searches // widest, len(items) // least)))
    if stage.tile:
        # Of large groups a tile has few: as many batches on a side as of small ones.
        widest = max(1, stage.tile // max(1, max(len(item.sources) for item in items) // 2))
        tilings = (tiles(items, side) for side in range(widest, 0, -1))
        return next((tiling for tiling in tilings if len(tiling) >= least), [[item] for item in items])
    size = max(1, min(stage.bundle, len(items) // least))
    return [items[start : start + size] for start in range(0, len(items), size)]


def searches(items: Sequence[WorkItem], most: int) -> list[Bundle]:
    """Group searches into tasks of at most ``most`` in the same shards, about as many in each."""
    of_shards: dict[Sequence[Reference], list[WorkItem]] = {}
    for item in items:
        search = whole_search(item.spec)
        shards = item.sources[search.batches : search.batches + len(search.shards)]
        of_shards.setdefault(shards, []).append(item)
    return [
        part[start : start + size]
        for part in of_shards.values()
        for size in [math.ceil(len(part) / math.ceil(len(part) / most))]
        for start in range(0, len(part), size)
    ]


def tiles(items: Sequence[WorkItem], side: int) -> list[Bundle]:
    """Group work items between two inputs into tiles, of the work between ``side`` inputs and ``side`` others.

    Groups of inputs are numbered as they appear. The largest tiles come first, so that workers end at about the same
    time.
    """
    numbers: dict[tuple[Reference, ...], int] = {}
    tiling: dict[tuple[int, int], list[WorkItem]] = {}
    for item in items:
        sides = [numbers.setdefault(group, len(numbers)) // side for group in _sides(item)]
        tiling.setdefault((min(sides), max(sides)), []).append(item)
    return sorted(tiling.values(), key=len, reverse=True)


def _sides(item: WorkItem) -> list[tuple[Reference, ...]]:
    """The inputs on either side of a work item."""
    sides = item.spec.sides if isinstance(item.spec, ReusingBlock) else item.spec
    if not isinstance(sides, Sides):
        return [(source,) for source in item.sources]
    return [tuple(item.sources[number] for number in side) for side in sides.numbers]
