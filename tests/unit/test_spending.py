"""What a stage spends, in waves where its work items wait for one another, and Dask's report of it."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from pipeline.config.build import make_config
from pipeline.config.command_line import complete
from pipeline.errors import StartError
from pipeline.flow import run_pipeline
from pipeline.plan.work_item import WorkItem
from pipeline.runtime.clusters import Bundle
from pipeline.runtime.events import Event, StageEnded
from pipeline.runtime.execute import Run
from pipeline.runtime.spending import critical_seconds, with_earlier
from pipeline.runtime.worker import Failure, Receipt
from pipeline.stages.all import BY_NAME
from pipeline.store.artifact import Artifact
from pipeline.store.keys import KeyParts
from pipeline.store.store import Store

MB = 2**20


def part(name: str, *smaller: WorkItem) -> WorkItem:
    keys = tuple(item.key for item in smaller)
    parts = KeyParts("preselect", {"name": name}, keys, {}, {})
    return WorkItem(parts, (), tuple(item.reference for item in smaller), name, ())


FIRST, SECOND = part("first"), part("second")
LARGE = part("large", FIRST, SECOND)
WHOLE = part("whole", LARGE)


class Timed:
    """An executor whose work items take one second each, but for one of four; it can fail one of them."""

    workers = 2

    def __init__(self, failing: str = "") -> None:
        self.waves: list[list[str]] = []
        self.failing = failing

    def run(self, store: Store, bundles: Sequence[Bundle]) -> Iterator[Receipt]:
        items = [item for bundle in bundles for item in bundle]
        self.waves.append([item.spec for item in items])
        for item in items:
            seconds = 4.0 if item.spec == "second" else 1.0
            if item.spec == self.failing:
                yield Receipt(item.stage, item.key, seconds, failure=Failure("ValueError", "no"))
                continue
            store.put(item.parts, Artifact())
            yield Receipt(item.stage, item.key, seconds, 0.5, read_bytes=2 * MB, written_bytes=MB)


def bring(tmp_path: Path, executor: Any) -> Run:
    run = Run(Store(tmp_path), lambda event: None, lambda: executor)
    run.kernels.start = lambda stage: None  # type: ignore[method-assign]
    run.stage(BY_NAME["preselect"], [WHOLE, LARGE, FIRST, SECOND])
    return run


def test_work_items_that_read_others_of_their_stage_come_after_these(tmp_path: Path) -> None:
    executor = Timed()
    run = bring(tmp_path, executor)
    assert [sorted(wave) for wave in executor.waves] == [["first", "second"], ["large"], ["whole"]]
    (ended,) = run.stages
    assert (ended.computed, ended.blocked, ended.critical_seconds) == (4, 0, 6.0)
    assert (ended.busy_seconds, ended.read_mb, ended.written_mb) == (7.0, 8.0, 4.0)
    again = Timed()
    (ended,) = bring(tmp_path, again).stages
    assert again.waves == [] and ended.cached == 4 and ended.idle is None and ended.critical_seconds == 0.0


def test_a_failure_blocks_what_waits_for_it(tmp_path: Path) -> None:
    run = bring(tmp_path, Timed(failing="second"))
    (ended,) = run.stages
    assert (ended.computed, ended.failed, ended.blocked) == (1, 1, 2)
    assert run.blocked == {LARGE.reference, WHOLE.reference}


def test_the_critical_path_of_items_that_wait_for_nothing_is_the_longest(tmp_path: Path) -> None:
    items = {item.reference: item for item in (FIRST, SECOND)}
    spent = [Receipt(item.stage, item.key, seconds) for item, seconds in ((FIRST, 2.0), (SECOND, 3.0))]
    assert critical_seconds(spent, items) == 3.0 and critical_seconds([], {}) == 0.0


def ended(**values: float) -> StageEnded:
    fields = {"total": 4, "cached": 2, "computed": 2, "failed": 0, "blocked": 0, "stored_seconds": 0.0}
    times = {"seconds": 2.0, "cpu_seconds": 1.0, "peak_mb": 100.0}
    return StageEnded("trunks", **{**fields, **times, **values})  # type: ignore[arg-type]


def test_idle_is_the_share_of_time_without_work() -> None:
    assert ended(busy_seconds=3.0, worker_seconds=4.0).idle == 0.25
    both = with_earlier(ended(busy_seconds=3.0, worker_seconds=4.0), ended(busy_seconds=1.0, worker_seconds=4.0))
    assert both.idle == 0.5 and both.seconds == 4.0 and (both.cached, both.computed) == (0, 4)


def test_a_profile_needs_workers_and_what_draws_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert complete(["--profile"])[0] == "profile=true"
    values = {"dataset": {"kind": "sample", "name": "sample"}, "profile": True, "outputs": str(tmp_path / "out")}
    with pytest.raises(StartError, match="--profile: cluster=sync"):
        run_pipeline(make_config({**values, "store": str(tmp_path), "cluster": {"kind": "sync"}}), ignore)
    load = importlib.import_module

    def without_bokeh(name: str, package: str | None = None) -> Any:
        if name == "bokeh":
            raise ModuleNotFoundError("No module named 'bokeh'", name="bokeh")
        return load(name, package)

    monkeypatch.setattr(importlib, "import_module", without_bokeh)
    with pytest.raises(StartError, match=r"--profile: .*riot-shapes\[dashboard\]"):
        run_pipeline(make_config({**values, "store": str(tmp_path)}), ignore)


def ignore(event: Event) -> None:
    """Listen to nothing."""
