"""Disks that are full or read-only, for real: the run says so and stops, loses nothing, and goes on when it can."""

from __future__ import annotations

import errno
import io
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from chaos.mounts import change, disk, leave, try_to_leave
from chaos.nursery import Nursery
from chaos.test_workers import SAME
from chaos.victims import Undisturbed, begun, committed, recording
from integration.small_runs import BAD_START, CLEAN, WITH_ERRORS, digests, run_here, table
from PIL import ImageFile
from rich.console import Console

from pipeline.artifact import Artifact
from pipeline.cache import OK, main
from pipeline.config import Config
from pipeline.errors import PlaceError
from pipeline.keys import KeyParts
from pipeline.run import _run
from pipeline.store import Store

Scenario = Callable[[Undisturbed, Path], None]


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
    with recording(log, disturb):
        ended = _run(config, Console(file=io.StringIO()), Console(file=complaints, soft_wrap=True))
    return ended.code, complaints.getvalue().strip(), begun(log)


def tidy(undisturbed: Undisturbed, where: Path) -> None:
    """Nothing differs from the undisturbed run, and nothing else is left."""
    assert digests(where) == undisturbed.tables
    store = Store(where / "store")
    assert main(["gc", "--store", str(store.root), "--outputs", str(where / "outputs")]) == OK
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
        with pytest.raises(PlaceError, match=f"^cannot write to {store.root}: {why}$"):
            store.put(two, large)
        assert committed(store) == {("stage", one.key())} and not list(store.root.rglob(".tmp-*"))
    change(where / "store", "rw", "size=1280k")
    store.put(two, large)
    assert np.array_equal(store.get("stage", two.key()).arrays["x"], large.arrays["x"])


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


@pytest.mark.parametrize(
    "scenario",
    [
        refuse_an_artifact,
        refuse_the_outputs,
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
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        return load(image)

    ImageFile.ImageFile.load = failing  # type: ignore[method-assign,assignment]
    code, _, _ = mine(undisturbed.again(where), where)
    ImageFile.ImageFile.load = load  # type: ignore[method-assign]
    rows = [row for row in table(where, "errors") if row["stage"] == "ingest"]
    assert code == WITH_ERRORS and "kind2-2" in {row["item"] for row in rows}
    assert {(row["type"], row["attempts"]) for row in rows} == {("OSError", 3)}
    assert table(where, "shapes")  # of the other batch
    kept = committed(Store(where / "store"))
    assert len([stage for stage, _ in kept if stage == "ingest"]) == 1
    assert mine(undisturbed.again(where), where)[:2] == (CLEAN, "")
    tidy(undisturbed, where)


def test_a_machine_that_cannot_read_a_picture_says_nothing_of_it(
    nursery: Nursery, undisturbed: Undisturbed, tmp_path: Path
) -> None:
    assert nursery.call(fail_a_picture, undisturbed, tmp_path) == 0
