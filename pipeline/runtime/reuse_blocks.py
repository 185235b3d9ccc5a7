"""What older blocks have of the pairs of new ones, when a grown collection is cut into other groups."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product

from pipeline.plan.sub_block import Sides
from pipeline.plan.work_item import WorkItem
from pipeline.runtime.older import inputs_and_spec, older_and_missing
from pipeline.stages.block_rows import Reused, ReusingBlock
from pipeline.store.keys import KeyParts
from pipeline.store.store import Store

Batches = tuple[str, str]
"""Keys of two batches."""


def with_older_blocks(store: Store, work: Sequence[WorkItem]) -> list[WorkItem]:
    """The work items of a stage of blocks, in which those that the store lacks read what older blocks have of them."""
    older, missing = older_and_missing(store, work)
    wanted: dict[Batches, list[tuple[str, tuple[int, int]]]] = defaultdict(list)
    for item in missing:
        for here, batches in _pairs(item.parts.inputs, item.spec):
            wanted[batches].append((item.key, here))
    found: dict[str, dict[tuple[int, int], tuple[str, tuple[int, int]]]] = defaultdict(dict)
    for key in older:
        for there, batches in _stored_pairs(store, key, work[0].parts):
            for item_key, here in wanted.get(batches, ()):
                found[item_key].setdefault(here, (key, there))
    return [_reusing(item, found[item.key]) if item.key in found else item for item in work]


def _pairs(inputs: Sequence[str], sides: Sides) -> Iterator[tuple[tuple[int, int], Batches]]:
    """Numbers, in the two sides, and keys of every two batches of a block."""
    first, second = sides.numbers
    for a, b in product(range(len(first)), range(len(second))):
        if not (sides.same and b < a):
            yield (a, b), (inputs[first[a]], inputs[second[b]])


def _stored_pairs(store: Store, key: str, like: KeyParts) -> Iterator[tuple[tuple[int, int], Batches]]:
    """`_pairs` of a stored block; none if other code or parameters made it, or only a part of it could be made."""
    inputs, sides = inputs_and_spec(store, key, like)
    if sides.keys() == {"rows", "columns"}:
        yield from _pairs(inputs, Sides(sides["rows"], sides["columns"]))


def _reusing(item: WorkItem, found: dict[tuple[int, int], tuple[str, tuple[int, int]]]) -> WorkItem:
    blocks = sorted({key for key, _ in found.values()})
    number = {key: len(item.sources) + k for k, key in enumerate(blocks)}
    reused = tuple(Reused(here, number[key], there) for here, (key, there) in sorted(found.items()))
    sources = (*item.sources, *((item.stage, key) for key in blocks))
    return replace(item, sources=sources, spec=ReusingBlock(item.spec, reused))
