"""Modules of kernels compiled in processes beside this one, several at a time.

A process of `multiprocessing` would import the main module of the program again, which a script need not bear; these
are programs of their own, on every system. They end with this process, however it ends (`process`). Ours.
"""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field

from riot.kernels.compiling.cache import FOLDER
from riot.kernels.compiling.process import Answer
from riot.kernels.compiling.waiting import Waiting

PROGRAM = "riot.kernels.compiling.process"
SECONDS_BETWEEN_REPORTS = 0.5
OVERDUE = 0.25
"""A module that takes longer than expected is assumed to take this share of its time so far yet."""


@dataclass
class _Job:
    """A module to compile: its weight, when it began, and how many seconds it took."""

    name: str
    weight: float
    future: Future[Answer] = field(default_factory=Future)
    started: float | None = None


class Compilation:
    """Modules that are being compiled, in order. `open_compilation` makes it."""

    def __init__(self, names: Sequence[str], processes: int) -> None:
        self._processes = min(processes, len(names))
        self._pool = ThreadPoolExecutor(max(1, self._processes), "kernels")  # a thread waits for each process
        self._of_thread = threading.local()
        self._running: list[subprocess.Popen[str]] = []
        self._lock = threading.Lock()
        self._is_closed = False
        self._failure = ""
        self._jobs = {name: _Job(name, weight(name)) for name in names}
        for job in self._jobs.values():
            job.future = self._pool.submit(self._compile, job)

    def wait(
        self, names: Sequence[str] | None = None, report: Callable[[Waiting], None] = lambda waiting: None
    ) -> None:
        """Wait for modules, by default all, those that are not compiled here apart.

        ``report`` is called at the beginning, twice a second, and at the end, unless there is nothing to wait for.
        """
        jobs = [job for job in self._jobs.values() if names is None or job.name in names]
        pending = {job.future for job in jobs if not job.future.done()}
        if not pending:
            return
        while pending:
            report(self._waiting(jobs))
            pending = wait(pending, SECONDS_BETWEEN_REPORTS, FIRST_COMPLETED).not_done
        report(self._waiting(jobs))

    @property
    def is_over(self) -> bool:
        """Whether nothing is left to compile."""
        return all(job.future.done() for job in self._jobs.values())

    @property
    def failure(self) -> str:
        """Why modules are not in the cache, empty if they are; after the first failure nothing else is compiled."""
        return self._failure

    def close(self) -> None:
        """End the processes, whatever they are at."""
        with self._lock:
            self._is_closed = True
            for process in self._running:
                process.kill()
        self._pool.shutdown(cancel_futures=True)
        for process in self._running:
            process.communicate()  # reaps it and closes its pipes

    def _compile(self, job: _Job) -> Answer:
        if self._failure:
            return Answer(0.0, self._failure)
        job.started = time.monotonic()
        try:
            process = self._process()
            assert process.stdin is not None and process.stdout is not None
            print(job.name, file=process.stdin, flush=True)
            line = process.stdout.readline()
        except OSError as error:
            answer = Answer(0.0, str(error))
        else:
            answer = Answer(**json.loads(line)) if line else Answer(0.0, "the process that compiled was ended")
        self._failure = self._failure or answer.failure
        return answer

    def _process(self) -> subprocess.Popen[str]:
        """The process of this thread."""
        if not hasattr(self._of_thread, "process"):
            with self._lock:
                if self._is_closed:
                    raise OSError("the compilation is over")
                self._of_thread.process = start_process()
                self._running.append(self._of_thread.process)
        process: subprocess.Popen[str] = self._of_thread.process
        return process

    def _waiting(self, jobs: Sequence[_Job]) -> Waiting:
        done = sum(job.future.done() for job in jobs)
        return Waiting(done, len(jobs), self._seconds(jobs))

    def _seconds(self, jobs: Sequence[_Job]) -> float | None:
        """Seconds until ``jobs`` are done: processes take the jobs in order and go on as fast as before."""
        answers = [(job.weight, job.future.result()) for job in self._jobs.values() if job.future.done()]
        compiled = [(weight, answer.seconds) for weight, answer in answers if not answer.failure]
        if not compiled:
            return None
        weights, spent = map(sum, zip(*compiled, strict=True))
        now, busy, ends = time.monotonic(), [0.0] * self._processes, [0.0]
        for job in self._jobs.values():
            if job.future.done():
                continue
            elapsed = 0.0 if job.started is None else now - job.started
            first = busy.index(min(busy))
            busy[first] += max(job.weight * spent / weights - elapsed, OVERDUE * elapsed)
            if job in jobs:
                ends.append(busy[first])
        return max(ends)


def weight(name: str) -> float:
    """A number to which the time that a module takes to compile is about proportional: bytes of its source."""
    return float((FOLDER / f"{name}.py").stat().st_size)


def longest_first(names: Sequence[str]) -> list[str]:
    """Modules in the order in which several processes are done soonest."""
    return sorted(names, key=lambda name: (-weight(name), name))


@contextlib.contextmanager
def open_compilation(names: Sequence[str], processes: int | None = None) -> Iterator[Compilation]:
    """Compile modules in this order, in as many ``processes`` as there are cores by default.

    When it is left the processes are ended, whether they are done or not.
    """
    compilation = Compilation(names, processes or cores())
    try:
        yield compilation
    finally:
        compilation.close()


def cores() -> int:
    """The number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def start_process() -> subprocess.Popen[str]:
    """A process that compiles (`process`); it looks for modules where this one does."""
    paths = [path or os.getcwd() for path in sys.path]  # noqa: PTH109
    return subprocess.Popen(
        [sys.executable, "-P", "-m", PROGRAM],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
        start_new_session=True,  # Ctrl-C in a terminal is for the process that started this one
    )
