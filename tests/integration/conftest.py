"""One small finished run that all tests here share."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from shared import Once
from small_runs import CLEAN, pictures, run_here


@pytest.fixture(scope="session")
def root(once: Once) -> Path:
    return once("pictures", pictures)


@pytest.fixture(scope="session")
def finished(once: Once, root: Path) -> Path:
    """A finished run on ``cluster=sync``; tests copy it before they change anything."""

    def mine(folder: Path) -> None:
        done = run_here(folder, root, "cluster=sync")
        assert done.returncode == CLEAN, done.stdout + done.stderr
        assert "Report:" in done.stdout and "Best transforms" in done.stdout

    return once("sync", mine)


@pytest.fixture
def copied(finished: Path, tmp_path: Path) -> Path:
    shutil.copytree(finished, tmp_path / "copy")
    return tmp_path / "copy"
