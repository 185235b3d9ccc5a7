"""Groups of batches, and blocks between them: every pair once, as between batches, and older blocks are used again."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plans import planned

from pipeline.config.build import make_config
from pipeline.datasets.collection import Collection
from pipeline.datasets.item import Item
from pipeline.plan import batches
from pipeline.plan.progress import Progress
from pipeline.plan.sub_block import Sides
from pipeline.runtime.bundles import tiles
from pipeline.runtime.reuse_blocks import with_older_blocks
from pipeline.stages.block_rows import Columns, Reused, ReusingBlock, block_rows, ordered
from pipeline.store.artifact import encode
from pipeline.store.store import PAYLOAD, Store

FEW = 4
"""Groups that these small collections are cut into, at least."""


@pytest.fixture(autouse=True)
def few_groups(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batches, "LEAST_GROUPS", FEW)


def plan(store: Path, names: Sequence[str]) -> Progress:
    config = make_config({"dataset": {"name": "made-up"}, "store": str(store), "batch": 4})
    digests = [hashlib.sha256(name.encode()).hexdigest() for name in names]
    items = [Item(name, "", f"/pictures/{name}.png", digest) for name, digest in zip(names, digests, strict=True)]
    return planned(config, "qcrs", Collection("made-up", tuple(items)))


NAMES = [f"shape-{number:03}" for number in range(200)]


@pytest.mark.parametrize("count", [0, 1, 7, 60, 200])
def test_blocks_between_groups_hold_every_pair_once(tmp_path: Path, count: int) -> None:
    progress = plan(tmp_path, NAMES[:count])
    positions = [position for number in range(len(progress.groups)) for position in progress.of_group(number)]
    assert positions == list(range(count))
    blocks = progress.work["qcrs"]
    pairs = [
        (i, j)
        for block in blocks
        if block.block is not None
        for i in progress.of_group(block.block[0])
        for j in progress.of_group(block.block[1])
        if i < j
    ]
    assert sorted(pairs) == [(i, j) for i in range(count) for j in range(i + 1, count)]
    assert sum(block.pairs for block in blocks) == len(pairs)
    assert not blocks or set(progress.members(blocks[-1])) == set(progress.of_group(len(progress.groups) - 1))
    assert all(len(set(progress.members(block))) == len(progress.members(block)) for block in blocks)
    assert len({block.key for block in blocks}) == len(blocks)
    if count == 200:
        assert len(progress.groups) < len(progress.batches) / 3


@given(st.integers(0, 5000), st.integers(1, 64))
def test_groups_grow_with_the_collection_and_stay_bounded(count: int, shapes: int) -> None:
    size = batches.batches_in_a_group(count, shapes)
    assert size == 1 or size * shapes <= batches.SHAPES_IN_A_GROUP
    assert size <= batches.batches_in_a_group(2 * count, shapes)
    assert count > FEW or size == 1


def made_up(sizes: Sequence[int]) -> list[np.ndarray]:
    """Batches of shapes, each of which is a number."""
    starts = np.cumsum([0, *sizes])
    return [np.arange(low, high) for low, high in pairwise(starts)]


def score(a: np.ndarray, b: np.ndarray, same: bool) -> Columns:
    """Rows whose score says which shapes they are of."""
    i, j = np.triu_indices(len(a), 1) if same else np.divmod(np.arange(len(a) * len(b)), max(1, len(b)))
    return {"i": i.astype(np.int32), "j": j.astype(np.int32), "score": 1000.0 * a[i] + b[j]}


@given(st.lists(st.integers(0, 4), min_size=1, max_size=5), st.integers(0, 4))
def test_a_block_has_the_rows_of_its_batches_in_order(sizes: list[int], columns: int) -> None:
    columns = min(columns, len(sizes) - 1)
    stacks, sides = made_up(sizes), Sides(len(sizes) - columns, columns)
    rows = ordered(block_rows(stacks, sides, score))
    first = np.concatenate([stacks[number] for number in sides.numbers[0]])
    second = np.concatenate([stacks[number] for number in sides.numbers[1]])
    expected = score(first, second, sides.same)
    for name, column in expected.items():
        assert np.array_equal(rows.arrays[name], column) and rows.arrays[name].dtype == column.dtype


def test_rows_of_an_older_block_are_used_again_and_the_bytes_are_the_same() -> None:
    stacks = made_up([3, 1, 2, 4])
    older = block_rows([stacks[1], stacks[2], stacks[3]], Sides(2, 1), score)
    reused = (Reused((0, 0), 3, (0, 0)), Reused((1, 0), 3, (1, 0)))
    begun: list[bool] = []

    def counted(a: np.ndarray, b: np.ndarray, same: bool) -> Columns:
        begun.append(same)
        return score(a, b, same)

    inputs: list[Any] = [stacks[1], stacks[2], stacks[3], older]
    again = block_rows(inputs, ReusingBlock(Sides(2, 1), reused), counted)
    assert begun == [] and encode(ordered(again)) == encode(ordered(older))

    class Gone(list[Any]):
        def __getitem__(self, number: Any) -> Any:
            if number == 3:
                raise KeyError("no artifact")
            return super().__getitem__(number)

    once_more = block_rows(Gone(inputs), ReusingBlock(Sides(2, 1), reused), counted)
    assert begun == [False, False] and encode(ordered(once_more)) == encode(ordered(older))


def simulated(store: Store, progress: Progress) -> None:
    """Put blocks into a store that have the batches of the plan."""
    for block in progress.work["qcrs"]:
        stacks = made_up([3] * len(block.sources))
        store.put(block.parts, ordered(block_rows(stacks, block.spec, score)))


def test_a_grown_collection_reads_all_but_the_new_batch_from_older_blocks(tmp_path: Path) -> None:
    store, before = Store(tmp_path), plan(tmp_path, NAMES[:-1])
    assert with_older_blocks(store, before.work["qcrs"]) == list(before.work["qcrs"])
    simulated(store, before)
    after = plan(tmp_path, NAMES)
    kept = {item.key for item in before.work["trunks"]} & {item.key for item in after.work["trunks"]}
    work = with_older_blocks(store, after.work["qcrs"])
    assert [item.key for item in work] == [item.key for item in after.work["qcrs"]]
    stored = {item.key for item in before.work["qcrs"]}
    assert any(isinstance(item.spec, ReusingBlock) for item in work)
    for item in work:
        sides = item.spec.sides if isinstance(item.spec, ReusingBlock) else item.spec
        first, second = sides.numbers
        of_kept = {
            (a, b)
            for a in range(len(first))
            for b in range(len(second))
            if (not sides.same or a <= b) and {item.parts.inputs[first[a]], item.parts.inputs[second[b]]} <= kept
        }
        reused = {piece.here for piece in item.spec.reused} if isinstance(item.spec, ReusingBlock) else set()
        assert item.key in stored or reused == of_kept
    assert sorted(item.key for tile in tiles(work, 2) for item in tile) == sorted(item.key for item in work)


def test_blocks_of_other_parameters_and_damaged_ones_are_not_used(tmp_path: Path) -> None:
    store, before, after = Store(tmp_path), plan(tmp_path, NAMES[:-1]), plan(tmp_path, NAMES)
    simulated(store, before)
    changed = [
        replace(item, parts=replace(item.parts, parameters={**item.parts.parameters, "qcrs": 0.5}, shared=None))
        for item in after.work["qcrs"]
    ]
    assert all(isinstance(item.spec, Sides) for item in with_older_blocks(store, changed))
    for stage, key in store.folders("qcrs"):
        (store.folder(stage, key) / "manifest.json").write_bytes(b"{")
        assert (store.folder(stage, key) / PAYLOAD).exists()
    assert all(isinstance(item.spec, Sides) for item in with_older_blocks(store, after.work["qcrs"]))
