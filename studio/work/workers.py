"""Processes beside the event loop: one answers a person at once, the others do what takes longer."""

from __future__ import annotations

import asyncio
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import ParamSpec, TypeVar

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

GIVING_WAY = 10
"""Niceness of what a person does not wait for while something moves."""


class Worker:
    """One process, started when it is needed, and anew when it died."""

    def __init__(self, niceness: int = 0) -> None:
        """Start nothing yet; the process gives way to others by ``niceness``."""
        self._pool: ProcessPoolExecutor | None = None
        self._niceness = niceness

    async def run(
        self, function: Callable[Arguments, Result], *arguments: Arguments.args, **named: Arguments.kwargs
    ) -> Result:
        """The result of a function of a module, computed in the process; what was asked for before comes first.

        When the asking task is cancelled, what has not begun does not run. If the process dies, the work is tried once
        more.
        """
        try:
            return await self._submit(function, *arguments, **named)
        except BrokenProcessPool:
            self.close()
            return await self._submit(function, *arguments, **named)

    async def _submit(
        self, function: Callable[Arguments, Result], *arguments: Arguments.args, **named: Arguments.kwargs
    ) -> Result:
        if self._pool is None:
            # Spawned: a fork would take the event loop and its threads along.
            context = multiprocessing.get_context("spawn")
            self._pool = ProcessPoolExecutor(1, mp_context=context, initializer=_begin, initargs=(self._niceness,))
        return await asyncio.wrap_future(self._pool.submit(function, *arguments, **named))

    def close(self) -> None:
        """End the process, whatever it is at."""
        if self._pool is None:
            return
        pool, self._pool = self._pool, None
        processes = list((getattr(pool, "_processes", None) or {}).values())
        pool.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.kill()


class Workers:
    """The processes of a studio: ``live`` answers, ``background`` looks further, ``workshop`` makes puzzles."""

    def __init__(self) -> None:
        """Start nothing yet."""
        self.live = Worker()
        self.background, self.workshop = Worker(GIVING_WAY), Worker(GIVING_WAY)

    def close(self) -> None:
        """End all of them."""
        for worker in (self.live, self.background, self.workshop):
            worker.close()


def _begin(niceness: int) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the server answers Ctrl-C
    os.nice(niceness)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """Do not stay behind when the server is killed."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)
