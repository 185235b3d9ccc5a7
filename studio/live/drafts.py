"""Answer what moves: of many requests only the latest is worth an answer."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Generic, TypeVar

Item = TypeVar("Item")


class Latest(Generic[Item]):
    """Handles one item at a time; of those that come meanwhile only the latest."""

    def __init__(self, handle: Callable[[Item], Awaitable[None]]) -> None:
        """Handle nothing yet."""
        self._handle = handle
        self._next: Item | None = None
        self._task: asyncio.Task[None] | None = None

    def put(self, item: Item) -> None:
        """Handle an item as soon as the one before is done, unless another comes or `drop` is called."""
        self._next = item
        if self._task is None or self._task.done():
            self._task = asyncio.create_task(self._run())

    def drop(self) -> None:
        """Forget what has not begun."""
        self._next = None

    async def _run(self) -> None:
        while self._next is not None:
            item, self._next = self._next, None
            await self._handle(item)
