"""The store's keeper: usage, damage, and what no run needs."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pipeline.cache import main
from pipeline.cli.cache import DAMAGED
from pipeline.exit_codes import BAD_START, CLEAN
from pipeline.store.artifact import Artifact
from pipeline.store.keys import KeyParts
from pipeline.store.store import PAYLOAD, State, Store
from pipeline.tables.record import ARTIFACTS


@pytest.fixture
def store(tmp_path: Path) -> Store:
    filled = Store(tmp_path / "store")
    for name in "abc":
        filled.put(KeyParts("crs", {"name": name}, (), {}, {}), Artifact({}, {"name": name}))
    return filled


def key(name: str) -> str:
    return KeyParts("crs", {"name": name}, (), {}, {}).key()


def keep(tmp_path: Path, *names: str) -> None:
    folder = tmp_path / "outputs" / "sample"
    folder.mkdir(parents=True)
    (folder / ARTIFACTS).write_text(json.dumps({"crs": [key(name) for name in names]}))


def call(tmp_path: Path, command: str, *more: str) -> int:
    options = ["--store", str(tmp_path / "store")]
    options += ["--outputs", str(tmp_path / "outputs")] if command == "gc" else []
    return main([command, *options, *more])


def test_du_counts_artifacts(tmp_path: Path, store: Store, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(tmp_path, "du") == CLEAN
    assert "crs" in (printed := capsys.readouterr().out) and " 3 " in printed


def test_verify_finds_damage(tmp_path: Path, store: Store, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(tmp_path, "verify") == CLEAN
    payload = store.folder("crs", key("b")) / PAYLOAD
    payload.write_bytes(payload.read_bytes() + b"x")
    assert call(tmp_path, "verify") == DAMAGED
    printed = capsys.readouterr().out
    assert key("b") in printed and key("a") not in printed


def test_gc_keeps_what_runs_need(tmp_path: Path, store: Store) -> None:
    keep(tmp_path, "a")
    assert call(tmp_path, "gc", "--dry-run") == CLEAN
    assert store.state("crs", key("b")) is State.PRESENT
    assert call(tmp_path, "gc") == CLEAN
    assert [store.state("crs", key(name)) for name in "abc"] == [State.PRESENT, State.ABSENT, State.ABSENT]


def test_gc_without_a_run_deletes_nothing(tmp_path: Path, store: Store, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(tmp_path, "gc") == BAD_START
    assert "--outputs" in capsys.readouterr().err
    assert store.state("crs", key("a")) is State.PRESENT


def test_gc_knows_artifacts_from_other_folders(tmp_path: Path, store: Store) -> None:
    letters = store.root / "letters" / "ab" / "old"
    letters.mkdir(parents=True)
    keep(tmp_path, "a")
    assert call(tmp_path, "gc") == CLEAN
    assert letters.is_dir() and store.state("crs", key("b")) is State.ABSENT


def test_gc_with_a_damaged_run_deletes_nothing(
    tmp_path: Path, store: Store, capsys: pytest.CaptureFixture[str]
) -> None:
    keep(tmp_path, "a")
    other_run = tmp_path / "outputs" / "other" / ARTIFACTS
    other_run.parent.mkdir()
    for text in ("{", "[]", '{"crs": 3}'):
        other_run.write_text(text)
        assert call(tmp_path, "gc") == BAD_START
        assert ARTIFACTS in capsys.readouterr().err
    assert store.state("crs", key("b")) is State.PRESENT


def test_no_store_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["du", "--store", str(tmp_path / "none")]) == BAD_START
    assert "--store" in capsys.readouterr().err
