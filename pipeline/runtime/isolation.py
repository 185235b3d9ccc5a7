"""Isolation: work items run in a process beside the worker, so that one that hangs or crashes costs only itself.

A compiled kernel answers no signal, and a crash in a library takes its whole process along. The worker therefore hands
its tasks to a process of its own (`pipeline.runtime.isolated_process`), which sends a receipt for each item as it ends.
When that process is lost, the first item without a receipt is the one that it was at.

A process pool of a library, such as pebble's, cannot stand in: it starts processes by ``multiprocessing``, which Dask's
workers, being daemons, may not, and it leaves one that hangs alive when the worker itself is killed.
"""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from multiprocessing.connection import Connection

from pipeline.plan.work_item import WorkItem
from pipeline.runtime.retries import PROCESS_LOST, PROCESS_TRIES, TIME_LIMIT
from pipeline.runtime.worker import Failure, Receipt
from pipeline.store.store import Store

SECONDS_TO_END = 30.0
"""An idle process that is told to end and takes longer is killed."""


class IsolatedProcess:
    """A process that runs work items. It starts when it is needed, and again when it is lost.

    ``limit``: an item that takes more seconds is stopped, with its process; None = never; it may be set anew for each
    task. ``program``: what Python runs, with the number of an open socket as its last argument.
    """

    def __init__(
        self, limit: float | None, program: Sequence[str] = ("-m", "pipeline.runtime.isolated_process")
    ) -> None:
        self.limit, self._program = limit, program
        self._process: subprocess.Popen[bytes] | None = None
        self._connection: Connection | None = None

    @property
    def pid(self) -> int:
        """The process's id; starts it if it is not running."""
        self._start()
        assert self._process is not None
        return self._process.pid

    def run_items(self, store: Store, items: Sequence[WorkItem]) -> Iterator[Receipt]:
        """As `pipeline.runtime.worker.run_items`: a receipt for every item, in order."""
        waiting, tries = deque(items), 0
        while waiting:
            try:
                connection = self._start()
                connection.send((store, tuple(waiting), self.limit))
                while waiting:
                    receipt: Receipt = connection.recv()
                    waiting.popleft()
                    tries = 0
                    yield receipt
            except (EOFError, OSError):
                code = self.close()
                tries += 1
                if code == -signal.SIGALRM or tries == PROCESS_TRIES:
                    item = waiting.popleft()
                    yield Receipt(item.stage, item.key, failure=self._failure(code, tries))
                    tries = 0

    def close(self) -> int:
        """End the process, if there is one; returns its exit code, negative = the signal that killed it."""
        if self._connection is not None:
            self._connection.close()
        code = 0
        if self._process is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(timeout=SECONDS_TO_END)  # it ends by itself when the connection is closed
            if self._process.poll() is None:
                self._process.kill()
            code = self._process.wait()
        self._process = self._connection = None
        return code

    def _start(self) -> Connection:
        if self._connection is None:
            ours, theirs = socket.socketpair()
            with theirs:
                number = theirs.fileno()
                # Modules are looked for where this process finds them, installed or not.
                environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
                self._process = subprocess.Popen(
                    [sys.executable, *self._program, str(number)],
                    pass_fds=[number],
                    stdin=subprocess.DEVNULL,
                    env=environment,
                )
            self._connection = Connection(ours.detach())
        return self._connection

    def _failure(self, code: int, tries: int) -> Failure:
        if code == -signal.SIGALRM:
            message = f"stopped after {self.limit:g} s; raise cluster.limit, or leave the item out"
            return Failure(TIME_LIMIT, message, tries, "time-limit")
        cause = signal.Signals(-code).name if code < 0 else f"exit code {code}"
        message = (
            f"it ended its process {tries} times ({cause}) and is set aside; look at the file, or give its worker more "
            "memory; the same command tries it again"
        )
        return Failure(PROCESS_LOST, message, tries, "quarantined")


class IdleProcesses:
    """The isolated processes of a worker that are idle: it takes one for each task that it does at a time."""

    def __init__(self, make: Callable[[float | None], IsolatedProcess] = IsolatedProcess) -> None:
        """``make`` gets the limit of a task for which there is no process."""
        self._idle: list[IsolatedProcess] = []
        self._make = make

    @contextlib.contextmanager
    def take(self, limit: float | None) -> Iterator[IsolatedProcess]:
        """A process that nobody else uses meanwhile."""
        try:
            process = self._idle.pop()
        except IndexError:
            process = self._make(limit)
        process.limit = limit  # a worker outlives a run, and the next one may have another limit
        yield process
        self._idle.append(process)
