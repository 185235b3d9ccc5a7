"""Disks that are full or read-only, for real: the run says so and stops, loses nothing, and goes on when it can."""

from __future__ import annotations

import contextlib
import errno
import io
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from chaos.mounts import change, disk, leave, try_to_leave
from chaos.nursery import Nursery
from chaos.test_workers import SAME
from chaos.victims import Undisturbed, begun, committed, recording
from integration.small_runs import BAD_START, CLEAN, WITH_ERRORS, command, digests, run_here, table
from PIL import ImageFile

import pipeline.runtime.execute
from pipeline.cache import main
from pipeline.cli.mine import run_job
from pipeline.config.cluster import ClusterConfig
from pipeline.config.schema import Config
from pipeline.errors import StorageError
from pipeline.exit_codes import FAILED
from pipeline.plan.work_item import Reference
from pipeline.store.artifact import Artifact
from pipeline.store.keys import KeyParts
from pipeline.store.store import Store
from riot.cli.output import Output

Scenario = Callable[[Undisturbed, Path], None]
ENOUGH = "size=64m"


@pytest.fixture
def play(nursery: Nursery, undisturbed: Undisturbed, tmp_path: Path) -> Callable[[Scenario], None]:
    """Play a scenario in a process with disks of its own."""
    assert nursery.call(try_to_leave, tmp_path / "try", tmp_path / "why") == 0
    if (tmp_path / "why").exists():
        pytest.skip(f"no disks of our own here: {(tmp_path / 'why').read_text()}")

    def played(scenario: Scenario) -> None:
        assert nursery.call(_begin, scenario, undisturbed, tmp_path) == 0

    return played


def _begin(scenario: Scenario, undisturbed: Undisturbed, where: Path) -> None:
    leave()
    scenario(undisturbed, where)


def mine(
    config: Config, where: Path, disturb: Callable[[str], None] = lambda stage: None
) -> tuple[int, str, list[str]]:
    """A run as the command line makes it: its exit code, what it complained of, and the work that it began."""
    log, complaints = where / "log", io.StringIO()
    log.unlink(missing_ok=True)
    with recording(log, disturb), contextlib.redirect_stderr(complaints):
        ended = run_job(config, Output("riot mine", quiet=True))
    return ended.code, complaints.getvalue().strip(), begun(log)


def opened_to_write(folder: Path) -> list[str]:
    """Files below a folder that this process opens to write, or tries to, from now on."""
    found: list[str] = []

    def hook(event: str, arguments: Any) -> None:
        if event == "open" and arguments[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):
            path = arguments[0]
            if isinstance(path, str | os.PathLike) and os.fspath(path).startswith(str(folder)):
                found.append(os.fspath(path))

    sys.addaudithook(hook)
    return found


def tidy(undisturbed: Undisturbed, where: Path) -> None:
    """Nothing differs from the undisturbed run, and nothing else is left."""
    assert digests(where) == undisturbed.tables
    store = Store(where / "store")
    assert main(["gc", "--store", str(store.root), "--outputs", str(where / "outputs")]) == CLEAN
    assert committed(store) == undisturbed.artifacts
    assert {file.name for file in store.root.rglob("*") if file.is_file()} == {"payload.bin", "manifest.json"}
    assert not list((where / "outputs").rglob(".tmp-*"))


def refuse_an_artifact(undisturbed: Undisturbed, where: Path) -> None:
    store, large = Store(where / "store"), Artifact({"x": np.arange(60_000.0)})
    one, two = (KeyParts("stage", {}, (name,), {}, {}) for name in "ab")
    disk(where / "store", 640)
    store.put(one, large)
    for options, why in (("size=640k", "No space left on device"), ("ro", "Read-only file system")):
        change(where / "store", options)
        with pytest.raises(StorageError, match=f"^cannot write to {store.root}: {why}$"):
            store.put(two, large)
        assert committed(store) == {("stage", one.key())} and not list(store.root.rglob(".tmp-*"))
    change(where / "store", "rw", "size=1280k")
    store.put(two, large)
    assert np.array_equal(store.get("stage", two.key()).arrays["x"], large.arrays["x"])


def fill_the_store(undisturbed: Undisturbed, where: Path) -> None:
    config, store = undisturbed.again(where), Store(where / "store")
    disk(where / "store", 300)
    done: set[Reference] = set()
    for size in (300, 2200):  # full at an early and at a late stage
        change(where / "store", f"size={size}k")
        code, said, work = mine(config, where)
        assert code == FAILED and said.startswith("Stopped: cannot write to"), said
        assert f"{where / 'store'}: No space left on device; free space" in said and said.endswith(
            "it goes on from here"
        )
        now = committed(store)
        assert done < now < undisturbed.artifacts and len(work) == len(now - done) + 1  # and the one that did not fit
        assert not list((where / "store").rglob(".tmp-*")) and not list((where / "outputs" / "folder").iterdir())
        done = now
    change(where / "store", ENOUGH)
    code, said, work = mine(config, where)
    assert (code, said, len(work)) == (CLEAN, "", len(undisturbed.artifacts - done))
    tidy(undisturbed, where)


def lock_the_store_meanwhile(undisturbed: Undisturbed, where: Path) -> None:
    config, store = undisturbed.again(where), Store(where / "store")
    disk(where / "store", 64_000)
    done: set[Reference] = set()
    for stage in ("trunks", "select"):  # `select` is done in the run's own process
        code, said, work = mine(
            config, where, lambda now, at=stage: change(where / "store", "ro") if now == at else None
        )
        assert code == FAILED and said.startswith("Stopped: cannot write to") and work[-1] == stage, said
        assert f"{where / 'store'}: Read-only file system; free space, or make it writable" in said
        now = committed(store)
        assert done < now < undisturbed.artifacts and len(work) == len(now - done) + 1
        done = now
        change(where / "store", "rw")
    code, said, work = mine(config, where)
    assert (code, said, len(work)) == (CLEAN, "", len(undisturbed.artifacts - done))
    tidy(undisturbed, where)


def lock_the_store_before(undisturbed: Undisturbed, where: Path) -> None:
    config, store = undisturbed.again(where), where / "store"
    disk(store, 4)
    change(store, "ro")
    code, said, work = mine(config, where)
    assert (code, work) == (BAD_START, []) and said.startswith("Cannot start: cannot write to")
    assert f"{store}: Read-only file system" in said and "store=DIR" in said
    change(store, "rw", ENOUGH)
    shutil.copytree(undisturbed.where / "store", store, dirs_exist_ok=True)
    change(store, "ro")
    before = {path: path.stat().st_mtime_ns for path in store.rglob("*")}
    # Whoever wants nothing that is not there already is served, without workers.
    tried = opened_to_write(store)
    on_workers = replace(config, cluster=ClusterConfig("local", workers=2))
    pipeline.runtime.execute.open_cluster = lambda *_: pytest.fail("a cluster was opened")
    assert mine(on_workers, where) == (CLEAN, "", [])
    assert mine(on_workers, where) == (CLEAN, "", [])  # and now finds its tables up to date
    assert len(tried) == 2  # each run once, to see whether it can
    assert digests(where) == undisturbed.tables
    assert {path: path.stat().st_mtime_ns for path in store.rglob("*")} == before
    # Selection is done in the run's own process, all else on workers.
    for other in (
        replace(on_workers, select=replace(config.select, top=1)),
        replace(on_workers, trunks=replace(config.trunks, tau_s=0.09)),
    ):
        code, said, work = mine(other, where)
        assert (code, work) == (BAD_START, []) and f"{store}: Read-only file system" in said


def refuse_the_outputs(undisturbed: Undisturbed, where: Path) -> None:
    outputs = where / "outputs"
    disk(outputs, 32)
    for options, why in (("size=32k", "No space left on device"), ("ro", "Read-only file system")):
        change(outputs, options)
        # The whole command: Hydra writes there before the run does.
        refused = run_here(where, undisturbed.pictures, *SAME, "cluster=sync")
        assert refused.returncode == BAD_START and refused.stderr.startswith("Cannot start: cannot write to")
        assert f"{outputs}: {why}" in refused.stderr and "outputs=DIR" in refused.stderr
        assert not list(outputs.iterdir()) and not (where / "store").exists()


def fill_the_outputs(undisturbed: Undisturbed, where: Path) -> None:
    config, outputs = undisturbed.again(where), where / "outputs"
    shutil.copytree(undisturbed.where / "store", where / "store")
    disk(outputs, 100)
    for size in (100, 400):  # no room for all tables, for the report
        change(outputs, f"size={size}k")
        code, said, work = mine(config, where)
        assert (code, work) == (FAILED, []) and said.startswith("Stopped: cannot write to"), said
        assert f"{outputs / 'folder'}: No space left on device; free space" in said
        assert not list(outputs.rglob(".tmp-*"))
    change(outputs, ENOUGH)
    assert mine(config, where) == (CLEAN, "", [])
    tidy(undisturbed, where)


def fill_the_store_of_workers(undisturbed: Undisturbed, where: Path) -> None:
    disk(where / "store", 1500)
    arguments = command(where, undisturbed.pictures, *SAME, "cluster=local", "cluster.workers=2")
    ended = subprocess.run(arguments, capture_output=True, text=True, cwd=where)
    assert ended.returncode == FAILED, ended.stdout + ended.stderr
    assert f"Stopped: cannot write to {where / 'store'}: No space left" in ended.stderr
    before = committed(Store(where / "store"))
    assert before < undisturbed.artifacts
    change(where / "store", ENOUGH)
    code, said, work = mine(undisturbed.again(where), where)
    assert (code, said, len(work)) == (CLEAN, "", len(undisturbed.artifacts - before))
    tidy(undisturbed, where)


@pytest.mark.parametrize(
    "scenario",
    [
        refuse_an_artifact,
        refuse_the_outputs,
        fill_the_store,
        lock_the_store_meanwhile,
        lock_the_store_before,
        fill_the_outputs,
        pytest.param(fill_the_store_of_workers, marks=pytest.mark.chaos),
    ],
    ids=lambda scenario: scenario.__name__,
)
def test_a_disk_costs_nothing_but_time(scenario: Scenario, play: Callable[[Scenario], None]) -> None:
    play(scenario)


def fail_a_picture(undisturbed: Undisturbed, where: Path) -> None:
    """A disk that cannot read one picture: its batch fails as work, and nothing is known of the picture."""
    load = ImageFile.ImageFile.load

    def failing(image: ImageFile.ImageFile) -> object:
        if "kind2-2" in str(image.filename):
            raise OSError(errno.EIO, os.strerror(errno.EIO), image.filename)
        return load(image)

    ImageFile.ImageFile.load = failing  # type: ignore[method-assign,assignment]
    code, _, _ = mine(undisturbed.again(where), where)
    ImageFile.ImageFile.load = load  # type: ignore[method-assign]
    rows = [row for row in table(where, "errors") if row["stage"] == "ingest"]
    assert code == WITH_ERRORS and "kind2-2" in {row["item"] for row in rows}
    assert {(row["type"], row["attempts"]) for row in rows} == {("OSError", 3)}
    assert not any(str(undisturbed.where) in str(row["message"]) for row in rows)
    assert table(where, "shapes")  # of the other batch
    kept = committed(Store(where / "store"))
    assert len([stage for stage, _ in kept if stage == "ingest"]) == 1
    assert mine(undisturbed.again(where), where)[:2] == (CLEAN, "")
    tidy(undisturbed, where)


def test_a_machine_that_cannot_read_a_picture_says_nothing_of_it(
    nursery: Nursery, undisturbed: Undisturbed, tmp_path: Path
) -> None:
    assert nursery.call(fail_a_picture, undisturbed, tmp_path) == 0
