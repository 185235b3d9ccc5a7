"""How a run that does not end well is told: it could not start, it had to stop, or it broke off."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

import pipeline.flow
import pipeline.run
from pipeline.datasets.collection import DatasetError
from pipeline.errors import PayloadError, StartError
from pipeline.exit_codes import BAD_START, FAILED
from pipeline.run import main
from riot.errors import ConstructionError, RiotError

FULL = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
PLACE = "/pictures/[red]/:cat:/"


def ended(error: Exception, where: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    def end(*_: object) -> None:
        raise error

    monkeypatch.setattr(pipeline.flow, "run_pipeline", end)
    return main([f"outputs={where / 'outputs'}", f"store={where / 'store'}"])


@pytest.mark.parametrize("kind", [StartError, DatasetError])
def test_what_keeps_a_run_from_starting(
    kind: type[RiotError], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ended(kind(f"{PLACE} is missing"), tmp_path, monkeypatch) == BAD_START
    assert capsys.readouterr().err == f"Cannot start: {PLACE} is missing\n"


@pytest.mark.parametrize("error", [PayloadError(PLACE), ConstructionError("reason", PLACE)], ids=repr)
def test_what_ends_a_run_that_had_started(
    error: RiotError, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ended(error, tmp_path, monkeypatch) == FAILED
    assert capsys.readouterr().err == f"Stopped: {PLACE}\n"


@pytest.mark.parametrize("error", [LookupError("a mistake"), FULL], ids=repr)
def test_a_mistake_in_the_middle_is_no_bad_start(
    error: Exception, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ended(error, tmp_path, monkeypatch) == FAILED
    assert "Cannot start" not in capsys.readouterr().err


def test_a_sweep_whose_table_cannot_be_written_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: object) -> None:
        raise FULL

    monkeypatch.setattr("pipeline.tables.sweep.write_sweep", full)
    # Jobs without a collection end at once; the sweep has a table of them all the same.
    data = ("+dataset=folder", f"dataset.root={tmp_path / 'absent'}", f"outputs={tmp_path}")
    assert main(["-m", "batch=1,2", *data]) == FAILED
    assert capsys.readouterr().err.endswith(f"Stopped: {FULL}\n")
