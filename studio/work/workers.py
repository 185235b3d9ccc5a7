"""Processes beside the event loop: one answers a person at once, the others do what takes longer."""

from __future__ import annotations

import asyncio
import multiprocessing
import signal
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import ParamSpec, TypeVar

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


class Worker:
    """One process, started when it is needed, and anew when it died."""

    def __init__(self) -> None:
        """Start nothing yet."""
        self._pool: ProcessPoolExecutor | None = None

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
            self._pool = ProcessPoolExecutor(1, mp_context=context, initializer=_ignore_interrupts)
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
        self.background = Worker()
        self.workshop = Worker()

    def close(self) -> None:
        """End all of them."""
        for worker in (self.live, self.background, self.workshop):
            worker.close()


def _ignore_interrupts() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the server answers Ctrl-C
