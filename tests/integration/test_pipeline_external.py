"""A real Dask scheduler with real workers of somebody else's making: ``cluster=external``."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from distributed import Client
from small_runs import BAD_START, CLEAN, digests, pictures, run


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return pictures(tmp_path_factory.mktemp("pictures"))


def started(*arguments: str, where: Path) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-m", *arguments], cwd=where, stderr=subprocess.DEVNULL)


@pytest.fixture
def scheduler(tmp_path: Path) -> Iterator[tuple[str, Path]]:
    """Address and scheduler file of a scheduler without workers."""
    file = tmp_path / "scheduler.json"
    options = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file))
    process = started("distributed.cli.dask_scheduler", *options, where=tmp_path)
    try:
        with Client(scheduler_file=str(file), timeout=60) as client:
            yield client.scheduler.address, file
    finally:
        process.kill()
        process.wait()


def test_external_workers_write_the_same_bytes(scheduler: tuple[str, Path], root: Path, tmp_path: Path) -> None:
    address, file = scheduler
    options = ("--nworkers", "2", "--nthreads", "1", "--no-dashboard", "--scheduler-file", str(file))
    workers = started("distributed.cli.dask_worker", *options, where=tmp_path)
    try:
        with Client(address) as client:
            client.wait_for_workers(2, timeout=60)
        done = run(tmp_path / "external", root, "cluster=external", f"cluster.address={address}")
    finally:
        workers.kill()
        workers.wait()
    assert done.returncode == CLEAN, done.stdout + done.stderr
    assert run(tmp_path / "sync", root, "cluster=sync").returncode == CLEAN
    assert digests(tmp_path / "external") == digests(tmp_path / "sync")


def test_a_scheduler_without_workers_is_no_start(scheduler: tuple[str, Path], root: Path, tmp_path: Path) -> None:
    address, _ = scheduler
    done = run(tmp_path / "idle", root, "cluster=external", f"cluster.address={address}", "cluster.wait=1")
    assert done.returncode == BAD_START
    assert "dask worker" in done.stderr
