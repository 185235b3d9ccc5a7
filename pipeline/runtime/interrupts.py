"""Ctrl-C: who answers it while processes start and libraries load that would change that.

A terminal sends Ctrl-C to every process of a command. Only the run's own process answers (`riot.cli.interrupts`): it
ends the others.
"""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator
from multiprocessing import resource_tracker
from types import FrameType
from typing import Any


@contextlib.contextmanager
def interrupts_handled_by(handler: Any) -> Iterator[None]:
    """While entered ``handler`` answers Ctrl-C, also in processes that start meanwhile; then as before."""
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread handles signals
        return
    before = signal.signal(signal.SIGINT, handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextlib.contextmanager
def interrupts_held() -> Iterator[None]:
    """While entered Ctrl-C waits, and then is answered as before; threads and processes that start never get it.

    >>> with interrupts_held():
    ...     print("workers start")
    workers start
    """
    pressed: list[int] = []

    def remember(number: int, _: FrameType | None) -> None:
        pressed.append(number)

    if hasattr(resource_tracker, "ensure_running"):
        resource_tracker.ensure_running()  # later it would let a thread that starts processes get Ctrl-C again
    with interrupts_handled_by(remember):
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if hasattr(signal, "pthread_sigmask") else None
        try:
            yield
        finally:
            if mask is not None:
                signal.pthread_sigmask(signal.SIG_SETMASK, mask)
    if pressed:
        signal.raise_signal(signal.SIGINT)
