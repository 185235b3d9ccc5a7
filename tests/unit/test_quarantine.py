"""Shapes that hang or kill are set aside, and all that comes out is what comes out without them."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from pipeline.config.build import make_config
from pipeline.config.schema import Config
from pipeline.datasets.collection import Collection
from pipeline.datasets.item import Item
from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.runtime.clusters import Bundle
from pipeline.runtime.events import Event, Note
from pipeline.runtime.execute import Run
from pipeline.runtime.quarantine import OF_SHAPES, bring_shapes
from pipeline.runtime.worker import Failure, Receipt
from pipeline.stages.all import begin_run
from pipeline.store.artifact import Artifact
from pipeline.store.store import Store

HANGS = Failure("TimeLimit", "stopped after 600 s; raise cluster.limit, or leave the item out", 1, "time-limit")
KILLS = Failure("ProcessLost", "it ended its process 2 times (SIGSEGV) and is set aside", 2, "quarantined")
BREAKS = Failure("RuntimeError", "no", 1)


class Poisoned:
    """Writes an artifact for every work item, except where one of its digests is poison in that stage."""

    workers = 2

    def __init__(self, poison: dict[tuple[str, str], Failure]) -> None:
        self.poison = poison
        self.seen: list[tuple[str, tuple[str, ...]]] = []

    def run(self, store: Store, bundles: Sequence[Bundle]) -> Iterator[Receipt]:
        for item in (item for bundle in bundles for item in bundle):
            read = [store.get(*source).document["errors"] for source in item.sources]
            digests = tuple(row["of"] for row in read[0]) if read else item.parts.inputs
            self.seen.append((item.stage, digests))
            found = [self.poison[item.stage, one] for one in digests if (item.stage, one) in self.poison]
            if found:
                yield Receipt(item.stage, item.key, failure=found[0])
            else:
                rows = [{"index": index, "of": one} for index, one in enumerate(digests)]
                store.put(item.parts, Artifact({}, {"errors": rows}))
                yield Receipt(item.stage, item.key)


def digest(name: str) -> str:
    return hashlib.sha256(name.encode()).hexdigest()


def collection(names: Sequence[str]) -> Collection:
    return Collection("made-up", tuple(Item(name, "", f"/pictures/{name}.png", digest(name)) for name in names))


def config(store: Path) -> Config:
    return make_config({"dataset": {"name": "made-up"}, "store": str(store), "batch": 4})


def brought(
    store: Path, names: Sequence[str], poison: dict[tuple[str, str], Failure], events: list[Event] | None = None
) -> tuple[Progress, Collection, Run, Poisoned]:
    executor = Poisoned({(stage, digest(name)): failure for (stage, name), failure in poison.items()})
    run = Run(Store(store), (lambda event: None) if events is None else events.append, lambda: executor)
    progress = bring_shapes(begun(store, names), run)
    return progress, progress.collection, run, executor


def begun(store: Path, names: Sequence[str]) -> Progress:
    settings = config(store)
    return begin_run(settings, collection(names), Store(store))


NAMES = [f"shape-{number:02}" for number in range(20)]


def work(progress: Progress) -> list[WorkItem]:
    return [item for stage in OF_SHAPES for item in progress.work[stage.name]]


@pytest.mark.parametrize("stage", [stage.name for stage in OF_SHAPES])
def test_neighbours_are_done_as_if_the_culprits_were_not_there(tmp_path: Path, stage: str) -> None:
    poison = {(stage, NAMES[3]): HANGS, (stage, NAMES[11]): KILLS, (stage, NAMES[12]): KILLS}
    plan, left, run, executor = brought(tmp_path / "store", NAMES, poison)
    others = [name for name in NAMES if name not in (NAMES[3], NAMES[11], NAMES[12])]
    clean = brought(tmp_path / "clean", others, {})
    assert [item.name for item in left.items] == others
    assert [item.reference for item in work(plan)] == [item.reference for item in work(clean[0])]
    assert run.done == clean[2].done == {item.reference for item in work(plan)}
    assert not run.failed and not run.blocked
    for item in work(plan):
        assert run.store.get(*item.reference).document == clean[2].store.get(*item.reference).document
    assert [(row.name, row.stage, row.type, row.reason, row.attempts) for row in left.rejected] == [
        (NAMES[3], stage, "TimeLimit", "time-limit", 1),
        (NAMES[11], stage, "ProcessLost", "quarantined", 2),
        (NAMES[12], stage, "ProcessLost", "quarantined", 2),
    ]
    # The next run tries the culprits again, each alone and with its batch, and nothing else.
    _, left_again, _, executor = brought(tmp_path / "store", NAMES, poison)
    assert left_again.rejected == left.rejected
    culprits = {digest(name) for name in (NAMES[3], NAMES[11], NAMES[12])}
    assert executor.seen and all(culprits.intersection(digests) for _, digests in executor.seen)


def test_a_shape_that_does_well_now_is_a_shape_again(tmp_path: Path) -> None:
    brought(tmp_path, NAMES, {("trunks", NAMES[5]): HANGS})
    plan, left, run, executor = brought(tmp_path, NAMES, {})
    assert left.rejected == () and len(left.items) == len(NAMES)
    assert executor.seen and all(digest(NAMES[5]) in digests for _, digests in executor.seen)
    assert run.done == {item.reference for item in work(plan)}


def test_nothing_is_searched_where_nothing_was_lost(tmp_path: Path) -> None:
    plan, left, run, executor = brought(tmp_path, NAMES, {("trunks", NAMES[5]): BREAKS})
    assert left.rejected == () and len(run.failed) == 1
    assert len(executor.seen) == len(work(plan))


def test_a_batch_that_fails_only_together_is_joined_from_its_shapes(tmp_path: Path) -> None:
    class Together(Poisoned):
        def run(self, store: Store, bundles: Sequence[Bundle]) -> Iterator[Receipt]:
            for bundle in bundles:
                for item in bundle:
                    if item.stage == "ingest" and len(item.members) > 1 and 0 in item.members:
                        yield Receipt(item.stage, item.key, failure=HANGS)
                    else:
                        yield from super().run(store, [[item]])

    executor = Together({})
    run = Run(Store(tmp_path), lambda event: None, lambda: executor)
    plan = bring_shapes(begun(tmp_path, NAMES), run)
    left = plan.collection
    clean = brought(tmp_path / "clean", NAMES, {})
    assert left.rejected == () and not run.failed and run.done == clean[2].done
    for item in work(plan):
        assert run.store.get(*item.reference).document == clean[2].store.get(*item.reference).document
    assert [stage.failed for stage in run.stages] == [0] * len(OF_SHAPES)


def test_what_was_spent_is_counted_once_and_the_names_are_told(tmp_path: Path) -> None:
    events: list[Event] = []
    plan, _, run, _ = brought(tmp_path, NAMES, {("trunks", NAMES[5]): KILLS}, events)
    assert [stage.stage for stage in run.stages] == [stage.name for stage in OF_SHAPES]
    for stage in run.stages:
        assert stage.total == len(plan.work["ingest"]) == stage.computed + stage.cached and stage.blocked == 0
    assert {stage.stage: stage.failed for stage in run.stages if stage.failed} == {"trunks": 1}
    assert [event.text for event in events if isinstance(event, Note)] == [
        f"set aside, and planned anew without: {NAMES[5]}"
    ]
