"""Killed at any moment, a run goes on where it was: no finished work is done twice, nothing torn is read."""

from __future__ import annotations

import functools
import random
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from chaos.conftest import Undisturbed
from chaos.nursery import Nursery
from chaos.victims import (
    Death,
    after_seconds,
    at_event,
    at_sync,
    begun,
    committed,
    deaths_of_a_commit,
    mine,
    put_one,
    while_writing,
)
from integration.small_runs import digests

from pipeline.cache import main
from pipeline.exit_codes import CLEAN
from pipeline.store.artifact import Artifact
from pipeline.store.keys import KeyParts
from pipeline.store.store import State, Store

KILLED = {-signal.SIGKILL, -signal.SIGPROF, -signal.SIGXFSZ}
SHORT, LONG = 8, 250


def test_a_commit_is_all_or_nothing_at_every_step(nursery: Nursery, tmp_path: Path) -> None:
    artifact, parts = Artifact({"x": np.arange(200.0)}), KeyParts("stage", {}, (), {}, {})
    codes = []
    for number, death in enumerate(deaths_of_a_commit()):
        store = Store(tmp_path / str(number))
        code = nursery.call(put_one, store, parts, artifact, death)
        codes.append(code)
        assert code == 0 or code in KILLED
        state = store.state("stage", parts.key())
        assert state is State.PRESENT if code == 0 else state in (State.ABSENT, State.PRESENT)
        store.put(parts, artifact)
        assert np.array_equal(store.get("stage", parts.key()).arrays["x"], artifact.arrays["x"])
        folder = store.folder("stage", parts.key())
        left = store.files.abandoned(f"stage/{parts.key()[:2]}/{parts.key()}")
        for name in left:
            store.files.remove(f"stage/{parts.key()[:2]}/{parts.key()}/{name}")
        assert sorted(file.name for file in folder.iterdir()) == ["manifest.json", "payload.bin"]
    assert codes.count(0) > 0 and len(codes) - codes.count(0) > 15  # the steps end within the list


def random_deaths(seed: int) -> Iterator[Death]:
    """One after another, of every kind; a run dies some ten times before it ends."""
    rng = random.Random(seed)
    while True:
        yield functools.partial(after_seconds, rng.uniform(0.02, 0.8))
        yield functools.partial(at_event, rng.randrange(1, 2500))
        yield functools.partial(at_event, rng.randrange(1, 80), ("os.", "fcntl."))
        yield functools.partial(at_sync, rng.randrange(1, 25), before=rng.random() < 0.5)
        yield functools.partial(while_writing, rng.choice([0, 2000, 4000, 5000, 6000, 8000]))


def survive(
    nursery: Nursery, undisturbed: Undisturbed, place: Callable[[int], Path], kills: int, seed: int
) -> dict[str, int]:
    """Runs killed so often in all, each resumed until it ends; returns what happened, counted."""
    deaths = random_deaths(seed)
    counts = {"kills": 0, "runs": 0, "begun": 0, "lost": 0}
    while counts["kills"] < kills:
        where = place(counts["runs"])
        where.mkdir()
        config = undisturbed.again(where)
        store, done, ended = Store(config.store), set(), False
        while not ended:
            log = where / f"log-{counts['kills']}-{counts['runs']}"
            # The last kills are used up: let it end.
            code = nursery.call(mine, config, log, next(deaths) if counts["kills"] < kills else None)
            ended = code == 0
            counts["kills"] += not ended
            assert ended or code in KILLED
            whole, stages = committed(store), begun(log)
            new = whole - done
            # What it began is what is new, and at most the one item that it died of.
            assert done <= whole and len(new) <= len(stages) <= len(new) + (not ended)
            counts["begun"] += len(stages)
            counts["lost"] += len(stages) - len(new)
            done = whole
        counts["runs"] += 1
        assert digests(where) == undisturbed.tables and done == undisturbed.artifacts
        assert main(["gc", "--store", str(config.store), "--outputs", str(config.outputs)]) == CLEAN
        assert committed(store) == undisturbed.artifacts
        names = {file.name for file in config.store.rglob("*") if file.is_file()}
        assert names == {"payload.bin", "manifest.json"}
        assert not list(config.outputs.rglob(".tmp-*"))
    assert counts["begun"] == counts["runs"] * len(undisturbed.artifacts) + counts["lost"]
    return counts


@pytest.mark.system
def test_a_run_survives_kills_at_random_moments(nursery: Nursery, undisturbed: Undisturbed, tmp_path: Path) -> None:
    counts = survive(nursery, undisturbed, lambda run: tmp_path / str(run), SHORT, 1)
    assert counts["kills"] == SHORT and counts["lost"] <= SHORT


@pytest.mark.chaos
@pytest.mark.timeout(3600)
def test_a_run_survives_hundreds_of_kills(
    nursery: Nursery, undisturbed: Undisturbed, tmp_path: Path, record_property: Callable[[str, object], None]
) -> None:
    counts = survive(nursery, undisturbed, lambda run: tmp_path / str(run), LONG, 2)
    record_property("counts", counts)
    print(counts)
    assert counts["kills"] == LONG


@pytest.mark.system
def test_two_runs_at_once_on_one_store(nursery: Nursery, undisturbed: Undisturbed, tmp_path: Path) -> None:
    configs = [undisturbed.again(tmp_path), undisturbed.again(tmp_path / "other")]
    configs[1] = type(configs[1])(**{**vars(configs[1]), "store": configs[0].store})
    (tmp_path / "other").mkdir()
    first = nursery.start(mine, configs[0], tmp_path / "log-0", functools.partial(after_seconds, 0.7))
    second = nursery.start(mine, configs[1], tmp_path / "log-1")
    assert nursery.wait(first) in KILLED | {0} and nursery.wait(second) == 0
    assert digests(tmp_path / "other") == undisturbed.tables
    assert nursery.call(mine, configs[0], tmp_path / "log-2") == 0
    assert begun(tmp_path / "log-2") == [] and digests(tmp_path) == undisturbed.tables
    # Only what both began before either had finished it is done by both.
    assert len(begun(tmp_path / "log-1")) <= len(undisturbed.artifacts)
    assert committed(Store(configs[0].store)) == undisturbed.artifacts
