"""Inputs of a task: each is read and prepared once while it is needed and fits, and no more than that is kept."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import PayloadError
from pipeline.plan.work_item import Reference, WorkItem
from pipeline.runtime.inputs import InputCache, Inputs
from pipeline.store.artifact import Artifact
from pipeline.store.keys import KeyParts
from pipeline.store.store import PAYLOAD, Store

SIZE = 800


class Counting:
    """A store of numbered inputs, and how often each was prepared."""

    def __init__(self, root: Path, count: int) -> None:
        self.store = Store(root)
        self.sources: list[Reference] = []
        for number in range(count):
            parts = KeyParts("trunks", {"number": number}, (), {}, {})
            self.store.put(parts, Artifact({"x": np.full(SIZE // 8, float(number))}))
            self.sources.append(("trunks", parts.key()))
        self.made: Counter[float] = Counter()

    def prepare(self, artifact: Artifact) -> float:
        number = float(artifact.arrays["x"][0])
        self.made[number] += 1
        return number

    def block(self, a: int, b: int, stage: str = "qcrs") -> WorkItem:
        sources = tuple(self.sources[number] for number in dict.fromkeys((a, b)))
        return WorkItem(KeyParts(stage, {"ab": [a, b]}, (), {}, {}), (), sources, None, ())

    def work(self, cache: InputCache, pairs: list[tuple[int, int]], stage: str = "qcrs") -> None:
        items = [self.block(a, b, stage) for a, b in pairs]
        inputs = Inputs(self.store, items, cache)
        for place, (item, pair) in enumerate(zip(items, pairs, strict=True)):
            assert list(inputs.of(place, item, self.prepare)) == list(dict.fromkeys(pair))


TRIANGLE = [(a, b) for a in range(6) for b in range(a, 6)]


def test_a_task_prepares_each_input_once_and_the_next_task_finds_it(tmp_path: Path) -> None:
    counting, cache = Counting(tmp_path, 6), InputCache()
    counting.work(cache, TRIANGLE)
    counting.work(cache, TRIANGLE[::-1])
    assert set(counting.made.values()) == {1} and len(counting.made) == 6


def test_a_stage_without_tiles_keeps_nothing_for_other_tasks(tmp_path: Path) -> None:
    counting, cache = Counting(tmp_path, 6), InputCache()
    counting.work(cache, TRIANGLE, "crs")
    assert set(counting.made.values()) == {1}
    counting.work(cache, TRIANGLE, "crs")
    assert set(counting.made.values()) == {2}


def test_another_stage_empties_the_cache(tmp_path: Path) -> None:
    counting, cache = Counting(tmp_path, 2), InputCache()
    counting.work(cache, [(0, 1)])
    counting.work(cache, [(0, 1)], "construct")
    counting.work(cache, [(0, 1)])
    assert counting.made == {0.0: 3, 1.0: 3}


@pytest.mark.parametrize("limit", [0, SIZE, 2 * SIZE, 4 * SIZE])
def test_the_limit_is_exceeded_by_a_single_input_alone_and_results_are_the_same(limit: int, tmp_path: Path) -> None:
    counting, cache = Counting(tmp_path, 6), InputCache(limit)
    counting.work(cache, TRIANGLE)
    in_cache = [source for source in counting.sources if cache.get(source) is not None]
    assert SIZE * len(in_cache) == cache.size <= max(limit, SIZE)


def test_of_inputs_that_do_not_fit_the_one_used_last_goes(tmp_path: Path) -> None:
    counting, cache = Counting(tmp_path, 3), InputCache(2 * SIZE)
    counting.work(cache, [(0, 1), (0, 2), (0, 1), (0, 2)])
    assert counting.made[0.0] == 1 and counting.made[1.0] + counting.made[2.0] == 3


def test_inputs_are_read_when_asked_for_and_damage_shows_there(tmp_path: Path) -> None:
    counting = Counting(tmp_path, 3)
    payload = counting.store.folder(*counting.sources[1]) / PAYLOAD
    payload.write_bytes(payload.read_bytes()[:-1] + b"x")
    inputs = Inputs(counting.store, [counting.block(0, 1)], InputCache())
    asked = inputs.of(0, counting.block(0, 1), counting.prepare)
    assert len(asked) == 2 and asked[0] == 0.0 and list(asked[:1]) == [0.0]
    with pytest.raises(PayloadError):
        asked[1]


def test_an_input_that_is_larger_than_the_cache_is_kept_while_it_is_used_next(tmp_path: Path) -> None:
    counting, cache = Counting(tmp_path, 6), InputCache(SIZE // 2)
    counting.work(cache, [(0, other) for other in range(1, 6)])
    assert counting.made[0.0] == 1 and cache.size == SIZE
