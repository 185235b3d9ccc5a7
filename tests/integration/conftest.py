"""One small finished run that all tests here share."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from small_runs import CLEAN, pictures, run


@pytest.fixture(scope="session")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return pictures(tmp_path_factory.mktemp("pictures"))


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory, root: Path) -> Path:
    """A finished run on ``cluster=sync``; tests copy it before they change anything."""
    where = tmp_path_factory.mktemp("sync")
    done = run(where, root, "cluster=sync")
    assert done.returncode == CLEAN, done.stdout + done.stderr
    assert "Report:" in done.stdout and "Time per stage" in done.stdout and "Best transforms" in done.stdout
    return where


@pytest.fixture
def copied(finished: Path, tmp_path: Path) -> Path:
    shutil.copytree(finished, tmp_path / "copy")
    return tmp_path / "copy"
