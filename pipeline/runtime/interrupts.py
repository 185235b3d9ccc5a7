"""Ctrl-C: who answers it while processes start and libraries load that would change that."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator
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
