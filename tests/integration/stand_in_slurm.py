"""Commands that stand for Slurm's ``sbatch`` and ``scancel``: a job is a process group of this machine.

They know as much of Slurm as dask-jobqueue asks for: a script is given, a number comes back; a number is cancelled.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import psutil
import pytest

from pipeline.plan.sources import ROOT

SBATCH = """#!/bin/sh
# sbatch SCRIPT: the number of the job is that of its process group.
slurm="{folder}"
read -r first < "$1"
case "$first" in '#!'*) ;; *) echo "sbatch: error: This does not look like a batch script." >&2; exit 1;; esac
if [ -e "$slurm/refuse" ]; then cat "$slurm/refuse" >&2; exit 1; fi
script=$(mktemp "$slurm/job.XXXXXX")
cp "$1" "$script"
chmod +x "$script"
setsid "$script" > "$script.out" 2>&1 < /dev/null &
until kill -s 0 -- "-$!" 2> /dev/null; do :; done # it is a group only once setsid has run
echo $! >> "$slurm/submitted"
echo "Submitted batch job $!"
"""

SCANCEL = """#!/bin/sh
# scancel JOB: at once, where Slurm asks the processes to end and kills those that have not within its KillWait.
echo "$1" >> "{folder}/cancelled"
kill -s KILL -- "-$1" 2> /dev/null || {{ echo "scancel: error: Kill job error on job id $1" >&2; exit 1; }}
"""


@dataclass(frozen=True)
class Slurm:
    """A folder with the two commands in ``bin``, and what they were asked for."""

    folder: Path

    def install(self) -> Path:
        """Write the commands; returns the folder that belongs in the PATH."""
        binaries = self.folder / "bin"
        binaries.mkdir(parents=True)
        for name, text in (("sbatch", SBATCH), ("scancel", SCANCEL)):
            (binaries / name).write_text(text.format(folder=self.folder))
            (binaries / name).chmod(0o755)
        return binaries

    def refuse(self, message: str | None) -> None:
        """Have jobs refused with this message, or no longer."""
        if message is None:
            (self.folder / "refuse").unlink()
        else:
            (self.folder / "refuse").write_text(message + "\n")

    @property
    def submitted(self) -> list[int]:
        return self._numbers("submitted")

    @property
    def cancelled(self) -> list[int]:
        return self._numbers("cancelled")

    def said(self) -> str:
        """What the jobs printed."""
        return "".join(path.read_text(errors="replace") for path in sorted(self.folder.glob("job.*.out")))

    def processes(self, *jobs: int) -> list[psutil.Process]:
        """Processes of these jobs, else of all, that have not ended."""
        found = []
        for process in psutil.process_iter():
            try:
                if os.getpgid(process.pid) in (jobs or self.submitted) and process.status() != psutil.STATUS_ZOMBIE:
                    found.append(process)
            except (ProcessLookupError, psutil.NoSuchProcess):
                continue
        return found

    def ended(self, *jobs: int) -> bool:
        """Wait until no process of these jobs, else of all, is left; whether that came to be within a minute."""
        for _ in range(600):
            left = self.processes(*jobs)
            if not left:
                return True
            psutil.wait_procs(left, timeout=0.1)
        return False

    def kill(self, *jobs: int) -> None:
        """Kill jobs as a machine that fails does."""
        for job in jobs:
            try:
                os.killpg(job, signal.SIGKILL)
            except ProcessLookupError:
                continue
        assert self.ended(*jobs)

    def _numbers(self, name: str) -> list[int]:
        file = self.folder / name
        return [int(line) for line in file.read_text().split()] if file.exists() else []


@pytest.fixture
def slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Slurm]:
    made = Slurm(tmp_path / "slurm")
    monkeypatch.setenv("PATH", f"{made.install()}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    yield made
    made.kill(*made.submitted)
