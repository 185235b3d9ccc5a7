"""Real runs with real workers, which are killed, crash, or lose their driver: the tables are the same."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path

import psutil
import pytest
from chaos.conftest import Undisturbed
from chaos.victims import committed
from integration.small_runs import CLEAN, command, digests, stages

from pipeline.store.store import Store

SAME = ("batch=3", "select=global", "select.top=2", "select.breadth=2", "select.per_shape=2", "refine.candidates=2")
"""The settings of `chaos.victims`, as a command has them."""


def workers(driver: int) -> list[psutil.Process]:
    """Processes that compute for a driver, whatever lies between."""
    below = psutil.Process(driver).children(recursive=True)
    return [one for one in below if not one.children() and "resource_tracker" not in " ".join(one.cmdline())]


@pytest.mark.chaos
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSEGV], ids=["killed", "segfault"])
def test_a_run_outlives_its_workers(how: signal.Signals, undisturbed: Undisturbed, tmp_path: Path) -> None:
    arguments = command(tmp_path, undisturbed.pictures, *SAME, "cluster=local", "cluster.workers=2")
    killed = 0
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=tmp_path) as run:
        assert run.stdout is not None
        said = []
        for line in run.stdout:
            said.append(line)
            if line.startswith(("ingest", "trunks", "qcrs", "crs")):
                for one in workers(run.pid)[:1]:
                    os.kill(one.pid, how)
                    killed += 1
    assert run.returncode == CLEAN, "".join(said)
    assert killed >= 3
    assert digests(tmp_path) == undisturbed.tables
    assert committed(Store(tmp_path / "store")) == undisturbed.artifacts


@pytest.mark.chaos
@pytest.mark.timeout(1800)
def test_workers_that_lost_their_driver_leave_a_whole_store(undisturbed: Undisturbed, tmp_path: Path) -> None:
    arguments = command(tmp_path, undisturbed.pictures, *SAME, "cluster=local", "cluster.workers=2")
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=tmp_path) as run:
        assert run.stdout is not None
        for line in run.stdout:
            if line.startswith("trunks"):
                break
        orphans = psutil.Process(run.pid).children(recursive=True)
        run.kill()
    psutil.wait_procs(orphans, timeout=120)
    before = committed(Store(tmp_path / "store"))
    assert before <= undisturbed.artifacts and len(before) >= 6
    again = subprocess.run(arguments, capture_output=True, text=True, cwd=tmp_path)
    assert again.returncode == CLEAN, again.stdout + again.stderr
    assert digests(tmp_path) == undisturbed.tables
    assert sum(stage["cached"] for stage in stages(tmp_path).values()) == len(before)
