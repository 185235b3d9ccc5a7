"""Exact searches of a collection that changes: older ones are used again, and what comes out is the same to the bit."""

from __future__ import annotations

import itertools
import tempfile
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_pair_scores import random_trunks

import pipeline.stages.partners
import pipeline.stages.partners_beyond
import pipeline.stages.shards
from pipeline.config.build import make_config
from pipeline.datasets.collection import Collection
from pipeline.datasets.item import Item
from pipeline.plan.progress import Progress
from pipeline.runtime.inputs import InputCache
from pipeline.runtime.reuse import with_older_results
from pipeline.runtime.reuse_searches import in_order
from pipeline.runtime.worker import run_items
from pipeline.stages.all import BY_NAME, begin_run
from pipeline.stages.reused_search import search_exactly
from pipeline.stages.trunk_arrays import pack_trunks
from pipeline.store.artifact import AnyArray, Artifact, encode
from pipeline.store.keys import digest_text
from pipeline.store.store import Store
from riot.scores.leaves import gather_leaves
from riot.scores.qcrs import score_block
from riot.scores.trunk_stack import stack

POOL = [random_trunks(np.random.default_rng(seed), 2 + seed % 9, seed % 3 == 0) for seed in range(20)]
POOL += POOL[:8]  # the same trunks in another picture: equal scores
LEAVES = [gather_leaves(stack([trunks])) for trunks in POOL]
K = 3
SEARCHES = ("partners", "partners_beyond")


@dataclass(frozen=True)
class Mined:
    """What a run found, and what it took: the shapes that were searched for in whole shards, and the bytes read."""

    progress: Progress
    pairs: Mapping[str, AnyArray]
    payloads: dict[tuple[str, object], bytes]
    """Of each search."""
    searched: Counter[str]
    read: int


def mine(
    pictures: dict[str, int], folder: Path, before_searches: Callable[[], None] = lambda: None, **qcrs: object
) -> Mined:
    """Mine a collection of pictures by name, of which each is a number of the pool."""
    store = Store(folder)
    items = [Item(name, "", name, digest_text(str(number))) for name, number in sorted(pictures.items())]
    values = {"dataset": {"name": "made-up"}, "store": str(folder), "batch": 3}
    config = make_config({**values, "qcrs": {"mode": "topk", "k": K, **qcrs}})
    progress = begin_run(config, Collection("made-up", tuple(items)), store)
    searched: Counter[str] = Counter()
    read = 0
    for stage in ("ingest", "trunks", "shards", *SEARCHES, "pairs"):
        work = BY_NAME[stage].items(progress)
        with_older = with_older_results(store, work)
        assert [item.key for item in with_older] == [item.key for item in work]
        if stage == SEARCHES[0]:
            before_searches()

        def counted(inputs: Any, spec: Any, wanted: Any, known: Any, find: Any, stage: str = stage) -> Artifact:
            def found(stacks: Any, rows: Any) -> Artifact:
                searched[stage] += len(rows)
                return find(stacks, rows)

            return search_exactly(inputs, spec, wanted, known, found)

        with pytest.MonkeyPatch.context() as patch:
            for module in (pipeline.stages.partners, pipeline.stages.partners_beyond):
                patch.setattr(module, "search_exactly", counted)
            for item in with_older:
                if stage in ("ingest", "trunks"):
                    store.put(item.parts, batch([pictures[items[position].name] for position in item.members]))
                    continue
                for receipt in run_items(store, [item], InputCache()):
                    assert receipt.failure is None, receipt.failure
                    read += receipt.read_bytes if stage in SEARCHES else 0
        progress = progress.with_work(stage, work, progress.done | {item.reference for item in work})
    payloads = {}
    for item in (item for stage in SEARCHES for item in progress.work[stage]):
        payloads[item.stage, item.block] = encode(store.get(*item.reference))
    return Mined(progress, store.get(*progress.work["pairs"][0].reference).arrays, payloads, searched, read)


def batch(numbers: Sequence[int]) -> Artifact:
    """What the stage ``trunks`` writes of pictures."""
    trunks, leaves = [POOL[number] for number in numbers], [LEAVES[number] for number in numbers]
    offsets = np.cumsum([0, *map(len, leaves)])
    return Artifact({**pack_trunks(trunks), "leaves": np.concatenate(leaves), "leaf_offsets": offsets})


def best_of_all(pictures: dict[str, int]) -> set[tuple[int, int, float]]:
    """Pairs of which one is among the best of the other, by scoring all."""
    everything = stack([POOL[pictures[name]] for name in sorted(pictures)])
    every = score_block(everything, everything, same=True)
    rows = [row for row in zip(every.i.tolist(), every.j.tolist(), every.score.tolist(), strict=True) if row[2] > 0]
    kept: set[tuple[int, int, float]] = set()
    for shape in range(len(pictures)):
        own = [row for row in rows if shape in row[:2]]
        kept |= set(sorted(own, key=lambda row: (-row[2], sum(row[:2]) - shape))[:K])
    return kept


@pytest.fixture(autouse=True)
def small_shards(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pipeline.stages.shards, "SHAPES_PER_SHARD", 8)


@st.composite
def histories(draw: st.DrawFn) -> list[dict[str, int]]:
    """A collection without two equal pictures, and what becomes of it."""
    numbers = draw(st.permutations(range(len(POOL))))
    pictures = {f"shape-{k:02}": number for k, number in enumerate(numbers[:18])}
    spare = list(numbers[18:])
    history = [dict(pictures)]
    for change in draw(st.lists(st.sampled_from(["add", "remove", "change", "rename"]), min_size=1, max_size=3)):
        name = draw(st.sampled_from(sorted(pictures)))
        if change == "add":
            pictures[f"{name}-{len(history)}"] = spare.pop()
        elif change == "change":
            pictures[name] = spare.pop()
        elif change == "rename":
            pictures[f"shape-{draw(st.integers(0, 20)):02}-{len(history)}"] = pictures.pop(name)
        else:
            del pictures[name]
        history.append(dict(pictures))
    return history


@given(histories(), st.sampled_from([1, 3, 16]))
@settings(max_examples=6)
def test_whatever_changes_the_searches_are_those_of_a_fresh_store(
    history: Sequence[dict[str, int]], target: int
) -> None:
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        patch.setattr(pipeline.stages.shards, "TARGET", target)
        grown, fresh = Path(folder) / "grown", Path(folder) / "fresh"
        for pictures in history:
            again = mine(pictures, grown)
        whole = mine(pictures, fresh)
    assert again.payloads == whole.payloads
    for name, column in whole.pairs.items():
        assert np.array_equal(again.pairs[name], column), name
    rows = zip(*(again.pairs[name].tolist() for name in ("i", "j", "score")), strict=True)
    assert set(rows) == best_of_all(pictures)


BEFORE = {f"shape-{number:02}": number for number in range(24)}
AFTER = {**BEFORE, "shape-11-new": 24}


def test_an_added_shape_is_scored_with_all_others_and_no_shard_is_read(tmp_path: Path) -> None:
    mine(BEFORE, tmp_path)
    after, fresh = mine(AFTER, tmp_path), mine(AFTER, tmp_path / "fresh")
    assert not after.searched
    assert fresh.searched["partners"] == len(AFTER)
    changed = mine({**AFTER, "shape-11-new": 25}, tmp_path)
    assert changed.searched["partners"] < len(AFTER) / 3
    assert after.read < fresh.read / 2


def test_searches_of_other_numbers_of_partners_and_settings_are_not_used(tmp_path: Path) -> None:
    mine(BEFORE, tmp_path)
    for qcrs in ({"k": K + 1}, {"epsilon": 0.1}):
        after = mine(AFTER, tmp_path, **qcrs)
        assert after.searched["partners"] == len(AFTER), qcrs


@pytest.mark.parametrize("name", ["payload.bin", "manifest.json"])
def test_an_older_search_that_is_gone_or_damaged_is_done_again(name: str, tmp_path: Path) -> None:
    before = mine(BEFORE, tmp_path)
    whole = mine(AFTER, tmp_path / "fresh")
    store = Store(tmp_path)

    def damage() -> None:
        """After the plan, as another process may."""
        for stage in ("partners", "partners_beyond"):
            for number, item in enumerate(before.progress.work[stage]):
                file = Path(str(store.folder(*item.reference))) / name
                if number % 2:
                    file.unlink()
                else:
                    file.write_bytes(file.read_bytes()[:-8])

    after = mine(AFTER, tmp_path, before_searches=damage)
    assert after.payloads == whole.payloads
    assert after.searched["partners"] > 1


@given(st.lists(st.integers(0, 9), max_size=7))
def test_a_longest_ascending_subsequence(numbers: list[int]) -> None:
    chosen = in_order(numbers)
    assert all(a < b and numbers[a] < numbers[b] for a, b in itertools.pairwise(chosen))
    subsets = (c for size in range(len(numbers) + 1) for c in itertools.combinations(numbers, size))
    assert len(chosen) == max(len(c) for c in subsets if all(a < b for a, b in itertools.pairwise(c)))
