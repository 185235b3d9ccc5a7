"""What all tests share: compiled kernels, and folders that are made once a session, whichever worker is first."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable
from pathlib import Path

import hypothesis
import pytest
from shared import Once

from riot.kernels.compiling.cache import uncompiled
from riot.kernels.warm import compile_modules

# A machine under load is slow, which is no fault: what a hang is, the timeout of a test says.
# The same examples every time: what fails, fails for everybody. What explores has the mark fuzz.
hypothesis.settings.register_profile("tests", deadline=None, derandomize=True)
hypothesis.settings.load_profile("tests")


def pytest_addoption(parser: pytest.Parser) -> None:
    """``--pictures DIR``: where tests leave the pictures that the guide shows."""
    parser.addoption("--pictures", metavar="DIR", help="keep the pictures of pages in this folder")


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile the numeric kernels where they are not, before any worker starts: that is no single test's time."""
    if "PYTEST_XDIST_WORKER" in os.environ or session.config.getoption("collectonly"):
        return
    compile_modules(uncompiled(), session.config.get_terminal_writer().line)


@pytest.fixture(scope="session")
def once(tmp_path_factory: pytest.TempPathFactory) -> Once:
    """``once(name, make)`` has ``make`` fill a folder in the first worker that asks; others wait, and only read it."""
    base = tmp_path_factory.getbasetemp()
    base = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base

    def folder(name: str, make: Callable[[Path], object]) -> Path:
        path, finished = base / name, base / f"{name}.finished"
        with (base / f"{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not finished.exists():
                path.mkdir()
                make(path)
                finished.touch()
        return path

    return folder
