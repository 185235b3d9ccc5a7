"""A Dask scheduler and workers in processes of their own, for tests."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from distributed import Client

from pipeline.plan.sources import ROOT

COUNTING = Path(__file__).resolve().parent / "counting"


@dataclass
class Deployment:
    """A scheduler, and groups of workers that come and go."""

    folder: Path
    address: str = ""
    started: list[subprocess.Popen[bytes]] = field(default_factory=list)

    @property
    def file(self) -> str:
        return str(self.folder / "scheduler.json")

    @property
    def puts(self) -> Path:
        return self.folder / "puts"

    def start(
        self, *arguments: str, source: Path = ROOT, variables: Mapping[str, str] | None = None
    ) -> subprocess.Popen[bytes]:
        environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join([str(source), str(COUNTING)]),
            "PUTS": str(self.puts),
            **(variables or {}),
        }
        line = [sys.executable, "-m", *arguments, "--scheduler-file", self.file]
        # In a session of its own, so that a group is killed with its nannies and what works beside its workers.
        process = subprocess.Popen(
            line, cwd=self.folder, env=environment, stderr=subprocess.DEVNULL, start_new_session=True
        )
        self.started.append(process)
        return process

    def workers(
        self, count: int, source: Path = ROOT, variables: Mapping[str, str] | None = None
    ) -> subprocess.Popen[bytes]:
        options = ("--nworkers", str(count), "--nthreads", "1", "--no-dashboard", "--host", "127.0.0.1")
        return self.start("distributed.cli.dask_worker", *options, source=source, variables=variables)

    def written_address(self) -> str:
        """The address in the scheduler's file, once it is there whole: the file comes into being empty."""
        while True:
            assert self.started[0].poll() is None
            with suppress(FileNotFoundError, ValueError):
                return str(json.loads(Path(self.file).read_text(encoding="utf-8"))["address"])

    def wait_for(self, count: int) -> None:
        with Client(self.address) as client:
            client.wait_for_workers(count, timeout=60)


def kill(process: subprocess.Popen[bytes]) -> None:
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


@pytest.fixture
def deployment(tmp_path: Path) -> Iterator[Deployment]:
    made = Deployment(tmp_path)
    made.start("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
    try:
        with Client(scheduler_file=made.file, timeout=60) as client:
            made.address = client.scheduler.address
        yield made
    finally:
        for process in reversed(made.started):
            kill(process)
