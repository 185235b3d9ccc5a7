"""Execution: only what is missing runs, failures stay with their items, and lost workers are replaced."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from distributed.client import FuturesCancelledError

from pipeline.config.cluster import ClusterConfig
from pipeline.errors import StopError
from pipeline.plan.work_item import WorkItem
from pipeline.runtime import worker as perform_module
from pipeline.runtime.bundles import bundles, tiles
from pipeline.runtime.clusters import Bundle, SyncExecutor, open_cluster
from pipeline.runtime.clusters.dask_executor import DaskExecutor, receipts_of
from pipeline.runtime.events import Event, ItemDone, StageEnded, StageStarted
from pipeline.runtime.execute import Run
from pipeline.runtime.retries import MACHINE_TRIES, WORKER_TRIES
from pipeline.runtime.worker import Failure, Receipt
from pipeline.stages.all import BY_NAME
from pipeline.stages.search_spec import Search, ShardPosition
from pipeline.store.artifact import Artifact
from pipeline.store.keys import KeyParts
from pipeline.store.store import PAYLOAD, State, Store


def item(name: str, sources: tuple[tuple[str, str], ...] = (), stage: str = "crs") -> WorkItem:
    return WorkItem(KeyParts(stage, {"name": name}, (), {}, {}), (), sources, name, (0,))


class Scripted:
    """An executor that writes an artifact for every item, except where the script has it fail first."""

    workers = 2

    def __init__(self, failures: dict[str, list[Failure]] | None = None) -> None:
        self.failures = failures or {}
        self.seen: list[str] = []

    def run(self, store: Store, bundles: Sequence[Bundle]) -> Iterator[Receipt]:
        for bundle in bundles:
            for one in bundle:
                self.seen.append(one.spec)
                script = self.failures.get(one.spec, [])
                if script:
                    yield Receipt(one.stage, one.key, failure=script.pop(0))
                else:
                    store.put(one.parts, Artifact({}, {"spec": one.spec}), {"seconds": 1.0})
                    yield Receipt(one.stage, one.key, seconds=1.0, cpu_seconds=0.5)


def run(tmp_path: Path, executor: Any, events: list[Event] | None = None) -> Run:
    listen = (lambda event: None) if events is None else events.append
    return Run(Store(tmp_path), listen, lambda: executor)


def test_only_missing_items_run_and_each_once(tmp_path: Path) -> None:
    first, second = Scripted(), Scripted()
    run(tmp_path, first).stage(BY_NAME["crs"], [item("a"), item("b"), item("a")])
    assert sorted(first.seen) == ["a", "b"]
    events: list[Event] = []
    later = run(tmp_path, second, events)
    later.stage(BY_NAME["crs"], [item("a"), item("b"), item("c")])
    assert second.seen == ["c"]
    assert events[0] == StageStarted("crs", "pairs", 3, 2, 0, "pairs", 1)
    assert events[1] == ItemDone("crs", False)
    ended = events[2]
    assert isinstance(ended, StageEnded) and (ended.total, ended.cached, ended.computed, ended.failed) == (3, 2, 1, 0)
    assert ended.stored_seconds == 3.0 and ended.cpu_seconds == 0.5


def test_no_cluster_is_opened_when_nothing_is_missing(tmp_path: Path) -> None:
    run(tmp_path, Scripted()).stage(BY_NAME["crs"], [item("a")])

    def refuse() -> Any:
        raise AssertionError("a cluster was opened")

    again = Run(Store(tmp_path), lambda event: None, refuse)
    again.stage(BY_NAME["crs"], [item("a")])
    assert again.stages[0].cached == 1


def test_damage_is_reported_and_mended(tmp_path: Path) -> None:
    run(tmp_path, Scripted()).stage(BY_NAME["crs"], [item("a"), item("b")])
    store = Store(tmp_path)
    payload = store.folder("crs", item("a").key) / PAYLOAD
    payload.write_bytes(payload.read_bytes()[:-1])
    events: list[Event] = []
    executor = Scripted()
    run(tmp_path, executor, events).stage(BY_NAME["crs"], [item("a"), item("b")])
    assert executor.seen == ["a"] and events[0] == StageStarted("crs", "pairs", 2, 1, 1, "pairs", 1)
    assert store.state("crs", item("a").key) is State.PRESENT


def test_failures_stay_with_their_items_and_block_what_needs_them(tmp_path: Path) -> None:
    executor = Scripted({"a": [Failure("ValueError", "no")]})
    state = run(tmp_path, executor)
    a, b = item("a"), item("b")
    state.stage(BY_NAME["crs"], [a, b])
    state.stage(
        BY_NAME["construct"], [item("ca", (a.reference,), "construct"), item("cb", (b.reference,), "construct")]
    )
    assert state.failed == {a.reference: Failure("ValueError", "no", 1)}
    assert executor.seen == ["a", "b", "cb"]
    assert state.stages[1].blocked == 1 and state.stages[1].computed == 1 and state.stages[0].failed == 1


def test_the_machine_gets_more_tries_and_the_item_does_not(tmp_path: Path) -> None:
    disk = Failure("OSError", "disk")
    executor = Scripted({"once": [disk], "always": [disk] * 9, "item": [Failure("LookupError", "it")] * 9})
    state = run(tmp_path, executor)
    state.stage(BY_NAME["crs"], [item("once"), item("always"), item("item")])
    assert [executor.seen.count(name) for name in ("once", "always", "item")] == [2, MACHINE_TRIES, 1]
    assert {failure.attempts for failure in state.failed.values()} == {MACHINE_TRIES, 1}
    assert item("once").reference in state.done


@pytest.mark.parametrize(("count", "workers"), [(0, 1), (1, 4), (7, 1), (100, 2), (1000, 16)])
def test_bundles_hold_every_item_once_and_keep_workers_busy(count: int, workers: int) -> None:
    items = [item(str(number)) for number in range(count)]
    made = bundles(items, workers)
    assert [one for bundle in made for one in bundle] == items
    assert all(1 <= len(bundle) <= 4 for bundle in made)
    assert len(made) >= min(count, workers)


def block(a: int, b: int) -> WorkItem:
    sources = tuple(("trunks", str(number)) for number in dict.fromkeys((a, b)))
    return WorkItem(KeyParts("qcrs", {}, (str(a), str(b)), {}, {}), (), sources, a == b, ())


@pytest.mark.parametrize(("batches", "workers"), [(1, 4), (2, 1), (5, 2), (20, 2), (20, 100), (50, 2)])
def test_tiles_hold_every_block_once_and_read_few_inputs(batches: int, workers: int) -> None:
    items = [block(a, b) for a in range(batches) for b in range(a, batches)]
    made = bundles(items, workers)
    assert sorted(one.key for bundle in made for one in bundle) == sorted(one.key for one in items)
    assert len(made) >= min(len(items), workers)
    assert [len(bundle) for bundle in made] == sorted((len(bundle) for bundle in made), reverse=True)
    assert all(len({source for one in bundle for source in one.sources}) <= 16 for bundle in made)
    assert all(len(bundle) <= 64 for bundle in made)


def test_a_tile_is_between_so_many_inputs_and_so_many_others() -> None:
    items = [block(a, b) for a in range(4) for b in range(a, 4)]
    found = [[one.parts.inputs for one in tile] for tile in tiles(items, 2)]
    assert found == [
        [("0", "2"), ("0", "3"), ("1", "2"), ("1", "3")],
        [("0", "0"), ("0", "1"), ("1", "1")],
        [("2", "2"), ("2", "3"), ("3", "3")],
    ]


def search(batch: int, shard: int) -> WorkItem:
    sources = (("trunks", str(batch)), ("shards", str(shard)), ("partners", str(batch)))
    parts = KeyParts("partners_beyond", {}, (str(batch), str(shard)), {}, {})
    return WorkItem(parts, (), sources, Search(1, (ShardPosition(-1, False),)), ())


@pytest.mark.parametrize(("batches", "shards", "workers"), [(1, 1, 1), (180, 13, 2), (180, 13, 64), (3, 2, 100)])
def test_searches_read_one_shard_in_a_task_and_keep_workers_busy(batches: int, shards: int, workers: int) -> None:
    items = [search(batch, shard) for shard in range(shards) for batch in range(batches)]
    made = bundles(items, workers)
    assert [one for bundle in made for one in bundle] == items
    assert all(len({one.sources[1] for one in bundle}) == 1 for bundle in made)
    assert len(made) >= min(len(items), workers)
    assert max(len(bundle) for bundle in made) <= 2 * min(len(bundle) for bundle in made)


def test_a_worker_refuses_to_write_what_other_code_computes(tmp_path: Path) -> None:
    stale = WorkItem(KeyParts("select", {}, (), {"pipeline.stages.select": "0"}, {}), (), (), None, ())
    (receipt,) = SyncExecutor().run(Store(tmp_path), [[stale]])
    assert receipt.failure is not None and "code" in receipt.failure.message
    assert Store(tmp_path).state("select", stale.key) is State.ABSENT


def test_lost_workers_are_replaced_and_a_deadly_item_is_given_up(tmp_path: Path) -> None:
    def task(store: Store, bundle: Bundle) -> list[Receipt]:
        if bundle[0].spec == "deadly":
            os._exit(1)
        mark = Path(store.text) / bundle[0].spec
        if bundle[0].spec == "unlucky" and not mark.exists():
            mark.touch()
            os._exit(1)
        return [Receipt(one.stage, one.key) for one in bundle]

    work = [[item(name)] for name in ("a", "unlucky", "b", "c")]
    work.append([item("deadly"), item("beside it")])
    with open_cluster(ClusterConfig("local", workers=2)) as opened:
        assert isinstance(opened, DaskExecutor)
        executor = replace(opened, task=task)
        receipts = {receipt.key: receipt for receipt in executor.run(Store(tmp_path), work)}
    assert len(receipts) == 6
    failed = {key: receipt.failure for key, receipt in receipts.items() if receipt.failure is not None}
    assert list(failed) == [item("deadly").key]
    (failure,) = failed.values()
    assert failure is not None and failure.type == "KilledWorker" and failure.attempts == WORKER_TRIES


def test_receipts_lost_with_their_worker_are_asked_for_again() -> None:
    class Lost:
        status = "finished"  # until somebody wants the result, which was on the lost worker alone

        def result(self, timeout: float) -> list[Receipt]:
            assert timeout > 0  # without one it waits for a worker that may never come
            raise OSError("the worker is gone")

    class Arrived:
        status = "finished"

        def result(self, timeout: float) -> list[Receipt]:
            assert timeout > 0  # without one it waits for a worker that may never come
            return [Receipt("crs", "key")]

    assert receipts_of(Lost()) is None
    assert receipts_of(Arrived()) == [Receipt("crs", "key")]


def test_receipts_tell_time_and_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        perform_module,
        "checked_stage",
        lambda name, code: replace(BY_NAME[name], run=lambda inputs, parameters, spec: Artifact()),
    )
    (receipt,) = SyncExecutor().run(Store(tmp_path), [[item("a")]])
    assert receipt.failure is None and receipt.seconds > 0 and receipt.peak_mb > 1


class LostScheduler:
    """Dask's client when the scheduler goes: tasks are cancelled, or messages fail, whichever comes first."""

    def __init__(self, error: Exception, status: str) -> None:
        self.error, self.status = error, status

    def nthreads(self) -> dict[str, int]:
        return {"tcp://127.0.0.1:1": 1}

    def submit(self, *arguments: Any, **options: Any) -> Any:
        raise self.error

    def cancel(self, futures: list[Any]) -> None:
        raise OSError("no scheduler")


@pytest.mark.parametrize(
    ("error", "status"),
    [(FuturesCancelledError([]), "running"), (OSError("closed"), "connecting"), (RuntimeError("closed"), "closed")],
    ids=repr,
)
def test_a_lost_scheduler_stops_the_run_in_words(tmp_path: Path, error: Exception, status: str) -> None:
    work = DaskExecutor(LostScheduler(error, status)).run(Store(tmp_path), [[item("a")]])
    with pytest.raises(StopError, match=r"scheduler was lost.*same command"):
        list(work)


def test_a_scheduler_lost_between_stages_stops_the_run_too(tmp_path: Path) -> None:
    lost = LostScheduler(OSError(), "connecting")
    lost.nthreads = partial(lost.submit)  # type: ignore[method-assign]
    with pytest.raises(StopError, match="scheduler was lost"):
        _ = DaskExecutor(lost).workers


def test_other_errors_of_a_cluster_pass(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError):
        list(DaskExecutor(LostScheduler(ZeroDivisionError(), "running")).run(Store(tmp_path), [[item("a")]]))
