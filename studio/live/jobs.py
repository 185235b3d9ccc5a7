"""Work that goes on while requests are answered: by name, of which an older one ends, or in its turn."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from typing import Any

Work = Coroutine[Any, Any, None]


class Jobs:
    """The tasks of a session."""

    def __init__(self) -> None:
        """No task yet."""
        self._named: dict[str, asyncio.Task[None]] = {}
        self._others: set[asyncio.Task[None]] = set()

    def start(self, name: str, work: Work) -> None:
        """Begin a job; an older one of that name is cancelled."""
        self.stop(name)
        self._named[name] = asyncio.create_task(work)

    def spawn(self, work: Work) -> None:
        """Begin what nothing cancels."""
        task = asyncio.create_task(work)
        self._others.add(task)
        task.add_done_callback(self._others.discard)

    def has(self, name: str) -> bool:
        """Whether a job of this name is under way."""
        return name in self._named and not self._named[name].done()

    def stop(self, *names: str) -> None:
        """Cancel jobs."""
        for name in names:
            job = self._named.pop(name, None)
            if job is not None:
                job.cancel()

    def stop_all(self) -> None:
        """Cancel all of them."""
        self.stop(*tuple(self._named))
        for task in tuple(self._others):
            task.cancel()
