"""Damage, little memory, wrong clocks and edited code: found, said, and mended by the next run."""

from __future__ import annotations

import functools
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
from chaos.conftest import Undisturbed
from chaos.nursery import Nursery
from chaos.victims import begun, committed, little_memory, mine
from integration.small_runs import digests

from pipeline.cache import main
from pipeline.cli.cache import DAMAGED
from pipeline.errors import PayloadError, StartError
from pipeline.exit_codes import CLEAN
from pipeline.flow import run_pipeline
from pipeline.plan.code_digest import code_digests
from pipeline.plan.sources import ROOT
from pipeline.store.filesystem.local import LocalFiles
from pipeline.store.store import MANIFEST, State, Store

YEARS = 10 * 365 * 86400.0


def flipped(raw: bytes, at: int) -> bytes:
    return raw[:at] + bytes([raw[at] ^ 16]) + raw[at + 1 :]


def damages(raw: bytes, parts: int) -> list[bytes]:
    """A file cut, lengthened, emptied, and with one bit turned, at some places each."""
    places = sorted({round(k * (len(raw) - 1) / (parts - 1)) for k in range(parts)})
    return [raw + b"\0", *(raw[:at] for at in places), *(flipped(raw, at) for at in places)]


def attack(store: Store, parts: int) -> tuple[int, int]:
    """Damage every file of a store in many ways; returns how often, and how often only what it cost was changed."""
    planted = harmless = 0
    for stage, key in store.folders():
        good = store.entry(stage, key)
        assert good is not None
        for name in store.files.sizes(f"{stage}/{key[:2]}/{key}"):
            path = store.folder(stage, key).joinpath(name)
            raw = path.read_bytes()
            for bad in damages(raw, parts):
                path.write_bytes(bad)
                planted += 1
                if store.state(stage, key) is State.CORRUPT:
                    with pytest.raises(PayloadError):
                        store.get(stage, key)
                    continue
                again = store.entry(stage, key)
                # Costs are for estimates only, and nothing that a table holds depends on them.
                assert (
                    name == MANIFEST
                    and again is not None
                    and (again.parts, again.digest)
                    == (
                        good.parts,
                        good.digest,
                    )
                )
                harmless += 1
            path.write_bytes(raw)
    return planted, harmless


def copied(undisturbed: Undisturbed, where: Path) -> Store:
    shutil.copytree(undisturbed.where / "store", where / "store")
    shutil.copytree(undisturbed.where / "outputs", where / "outputs")
    return Store(where / "store")


def test_every_damage_is_found(undisturbed: Undisturbed, tmp_path: Path) -> None:
    planted, harmless = attack(copied(undisturbed, tmp_path), 4)
    assert planted > 400 and harmless < planted / 20


@pytest.mark.chaos
def test_every_damage_is_found_at_many_places(undisturbed: Undisturbed, tmp_path: Path) -> None:
    planted, harmless = attack(copied(undisturbed, tmp_path), 100)
    print({"planted": planted, "harmless": harmless})
    assert planted > 10_000 and harmless < planted / 20


def test_everything_damaged_is_made_again_and_nothing_else(
    nursery: Nursery, undisturbed: Undisturbed, tmp_path: Path
) -> None:
    store = copied(undisturbed, tmp_path)
    hurt = sorted(undisturbed.artifacts)[::3]
    for number, reference in enumerate(hurt):
        names = sorted(path.name for path in store.folder(*reference).iterdir())
        path = store.folder(*reference).joinpath(names[number % len(names)])
        raw = path.read_bytes()
        path.write_bytes(raw[: len(raw) // 2])
    assert main(["verify", "--store", str(store.root)]) == DAMAGED
    assert nursery.call(mine, undisturbed.again(tmp_path), tmp_path / "log") == 0
    assert sorted(begun(tmp_path / "log")) == [stage for stage, _ in hurt]
    assert digests(tmp_path) == undisturbed.tables and main(["verify", "--store", str(store.root)]) == CLEAN


@pytest.mark.chaos
@pytest.mark.parametrize("megabytes", [2, 40, 160])
def test_little_memory_leaves_nothing_wrong(
    megabytes: int, nursery: Nursery, undisturbed: Undisturbed, tmp_path: Path
) -> None:
    config = undisturbed.again(tmp_path)
    nursery.call(mine, config, tmp_path / "little", functools.partial(little_memory, megabytes * 2**20))
    assert nursery.call(mine, config, tmp_path / "log") == 0
    assert digests(tmp_path) == undisturbed.tables
    assert committed(Store(config.store)) >= undisturbed.artifacts


@pytest.mark.parametrize("shift", [-YEARS, pytest.param(YEARS, marks=pytest.mark.chaos)])
def test_the_clock_does_not_matter(shift: float, nursery: Nursery, undisturbed: Undisturbed, tmp_path: Path) -> None:
    store = copied(undisturbed, tmp_path)
    folder = store.folder(*min(undisturbed.artifacts))
    folder.joinpath(".tmp-left").write_bytes(b"half")
    when = time.time() + shift
    for path in tmp_path.rglob("*"):
        os.utime(path, (when, when))
    assert nursery.call(mine, undisturbed.again(tmp_path), tmp_path / "log") == 0
    assert begun(tmp_path / "log") == [] and digests(tmp_path) == undisturbed.tables
    assert main(["gc", "--store", str(store.root), "--outputs", str(tmp_path / "outputs")]) == CLEAN
    assert not list(store.root.rglob(".tmp-*")) and committed(store) == undisturbed.artifacts


def test_what_a_living_writer_has_is_left_alone(tmp_path: Path) -> None:
    files = LocalFiles(tmp_path)
    seen: list[list[str]] = []

    sync = os.fsync

    def watch(descriptor: int) -> None:
        seen.append([name for name in files.names("a") if name.startswith(".tmp-")])
        assert files.abandoned("a") == []
        sync(descriptor)

    os.fsync = watch  # type: ignore[assignment]
    try:
        files.write("a", {"one": b"1"})
    finally:
        os.fsync = sync
    assert len(seen[0]) == 1 and list(files.names("a")) == ["one"]


def test_a_store_in_use_is_not_tidied(
    undisturbed: Undisturbed, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    store = copied(undisturbed, tmp_path)
    gc = ["gc", "--store", str(store.root), "--outputs", str(tmp_path / "outputs")]
    with store.files.shared(), store.files.shared():
        assert main(gc) == 2 and "a run is using it" in capsys.readouterr().err
        assert main([*gc, "--dry-run"]) == CLEAN
    assert main(gc) == CLEAN


def test_a_store_that_cannot_be_written_is_said_before_anything_is_done(
    undisturbed: Undisturbed, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("no folder")
    config = undisturbed.again(tmp_path / "file")
    with pytest.raises(StartError, match="choose another with outputs=DIR"):
        run_pipeline(config, lambda event: None)


EDITED = """
import sys
from pathlib import Path
from pipeline.plan.code_digest import code_digests, library_versions
from pipeline.stages.all import code_text, checked_stage
from pipeline.stages import select
module = "pipeline.stages.select"
before = code_digests(module)
assert Path(sys.modules[module].__file__).is_relative_to(Path.cwd()), "the copy is what runs"
path = Path(sys.modules[module].__file__)
path.write_text(path.read_text() + "\\nEDITED = 1\\n")
assert code_digests(module) == before, "digests are those of the code that was loaded"
try:
    checked_stage("select", code_text(before, library_versions(module)))
except RuntimeError as error:
    assert "start the run again" in str(error)
else:
    raise SystemExit("work by code that may not be what the key says")
"""


def test_code_edited_while_a_run_goes_on_is_refused(tmp_path: Path) -> None:
    """Also when it was edited after it was loaded and before anything was planned: the key would name the new code."""
    for package in ("riot", "pipeline"):
        shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    before = code_digests("pipeline.stages.select")
    done = subprocess.run([sys.executable, "-c", EDITED], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert code_digests("pipeline.stages.select") == before
