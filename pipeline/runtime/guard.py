"""Guard: work done in a process beside the worker, so that an item that hangs or kills its process costs only itself.

A compiled kernel answers no signal, and a crash in a library takes its whole process along. The worker therefore hands
its tasks to a process of its own (`pipeline.runtime.guard_process`), which sends a receipt for each item as it ends.
When that process is lost, the first item without a receipt is the one it was at.
"""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
from collections import deque
from collections.abc import Iterator, Sequence
from multiprocessing.connection import Connection

from pipeline.plan.work_item import WorkItem
from pipeline.runtime.worker import Failure, Receipt

MAX_DEATHS = 2
"""An item that has killed its process so often is quarantined."""

ENDING = 30.0
"""Seconds that an idle process has to end."""


class Guard:
    """A process that does work items, started when it is needed, and again when it is lost.

    ``limit``: an item that takes more seconds is stopped, with its process; None = never.
    """

    def __init__(self, limit: float | None) -> None:
        self._limit = limit
        self._process: subprocess.Popen[bytes] | None = None
        self._connection: Connection | None = None

    def perform(self, root: str, items: Sequence[WorkItem]) -> Iterator[Receipt]:
        """As `pipeline.runtime.worker.perform`: a receipt for every item, in order."""
        waiting, deaths = deque(items), 0
        while waiting:
            try:
                connection = self._started()
                connection.send((root, tuple(waiting), self._limit))
                while waiting:
                    receipt: Receipt = connection.recv()
                    waiting.popleft()
                    deaths = 0
                    yield receipt
            except (EOFError, OSError):
                code = self.close()
                deaths += 1
                if code == -signal.SIGALRM or deaths == MAX_DEATHS:
                    item = waiting.popleft()
                    yield Receipt(item.stage, item.key, failure=self._failure(code, deaths))
                    deaths = 0

    def close(self) -> int:
        """End the process, if there is one; returns its exit code, negative = the signal that killed it."""
        if self._connection is not None:
            self._connection.close()
        code = 0
        if self._process is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(timeout=ENDING)  # it ends by itself when the connection is closed
            if self._process.poll() is None:
                self._process.kill()
            code = self._process.wait()
        self._process = self._connection = None
        return code

    def _started(self) -> Connection:
        if self._connection is None:
            ours, theirs = socket.socketpair()
            with theirs:
                number = theirs.fileno()
                # Modules are looked for where this process finds them, be it in no installed place.
                environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
                self._process = subprocess.Popen(
                    [sys.executable, "-m", "pipeline.runtime.guard_process", str(number)],
                    pass_fds=[number],
                    stdin=subprocess.DEVNULL,
                    env=environment,
                )
            self._connection = Connection(ours.detach())
        return self._connection

    def _failure(self, code: int, deaths: int) -> Failure:
        if code == -signal.SIGALRM:
            said = f"stopped after {self._limit:g} s; raise cluster.limit, or leave the item out"
            return Failure("TimeLimit", said, deaths, "time-limit")
        name = signal.Signals(-code).name if code < 0 else f"exit code {code}"
        said = (
            f"it ended its process {deaths} times ({name}) and is set aside; look at the file, or give its worker more "
            "memory; the same command tries it again"
        )
        return Failure("ProcessLost", said, deaths, "quarantined")


class Guards:
    """The idle guards of a worker, one for each task that it does at a time."""

    def __init__(self) -> None:
        self._idle: list[Guard] = []

    @contextlib.contextmanager
    def taken(self, limit: float | None) -> Iterator[Guard]:
        """A guard that nobody else uses meanwhile."""
        try:
            guard = self._idle.pop()
        except IndexError:
            guard = Guard(limit)
        yield guard
        self._idle.append(guard)
