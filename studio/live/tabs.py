"""The tabs that look at a session: all hear the same news."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from studio.live.news import News, encoded

Send = Callable[[bytes], Awaitable[None]]
"""Sends a message to one tab."""


class Tabs:
    """The tabs of one session."""

    def __init__(self) -> None:
        """Nobody looks yet."""
        self._sends: set[Send] = set()

    def add(self, send: Send) -> None:
        """A tab that is told all news from now on."""
        self._sends.add(send)

    def remove(self, send: Send) -> None:
        """A tab is gone."""
        self._sends.discard(send)

    async def tell(self, message: News) -> None:
        """Send news to all tabs."""
        data = encoded(message)
        for send in tuple(self._sends):
            try:
                await send(data)
            except (RuntimeError, OSError):  # it was closed meanwhile
                self.remove(send)
