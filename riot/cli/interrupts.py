"""Ctrl-C ends a command within two seconds, whatever it is at.

Python answers Ctrl-C in the main thread, between two of its own instructions: not while a compiled function runs or a
lock is waited for, and what is then cleaned up may take long. So a thread watches: if the process has not ended by
itself soon after the key was pressed, the thread ends it. Nothing is lost: files are written under other names and then
renamed, and a run's store counts only what is whole.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import signal
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from typing import NoReturn

from riot.cli.parser import INTERRUPTED

GRACE = 1.0
"""Seconds in which an interrupted command may end by itself: less than the two that it may take in all."""

SECONDS_TO_NOTICE = 0.2
"""In which the thread notices the key; it does not notice a KeyboardInterrupt that no key raised."""


@contextlib.contextmanager
def interruptible(words: str) -> Iterator[None]:
    """While entered, and once Ctrl-C was pressed also after that, Ctrl-C ends the process with code `INTERRUPTED`.

    ``words`` go to standard error, and KeyboardInterrupt is raised as ever. If the process is still there after
    `GRACE`, or if Ctrl-C is pressed again, the watching thread ends it, and the processes that it started.

    Nobody watches outside of the main thread, and where the shell has Ctrl-C ignored, as it does for a command in the
    background. Ours.

    >>> with interruptible("Interrupted. Nothing is written."):
    ...     pass
    """
    say = _Once(words)
    try:
        with _watched(say):
            yield
    except KeyboardInterrupt:
        say()
        raise


@contextlib.contextmanager
def _watched(say: Callable[[], None]) -> Iterator[None]:
    in_main_thread = threading.current_thread() is threading.main_thread()
    if not in_main_thread or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    arrivals, wakeup = socket.socketpair()  # Python writes the number of a signal at once, whatever the process is at
    wakeup.setblocking(False)
    before = signal.set_wakeup_fd(wakeup.fileno(), warn_on_full_buffer=False)
    pressed = threading.Event()
    watch = threading.Thread(target=_watch, args=(arrivals, say, pressed), daemon=True, name="interrupts")
    watch.start()
    hook, sys.unraisablehook = sys.unraisablehook, _silent_about_interrupts(sys.unraisablehook)
    interrupted = False
    try:
        yield
    except KeyboardInterrupt:
        # If a key raised it, the thread stays, in case the end of the process takes long.
        interrupted = pressed.wait(timeout=SECONDS_TO_NOTICE)
        raise
    finally:
        if not interrupted:
            sys.unraisablehook = hook
            signal.set_wakeup_fd(before)
            wakeup.close()
            watch.join()


def _silent_about_interrupts(hook: Callable[[sys.UnraisableHookArgs], object]) -> Callable[..., object]:
    """A hook that says nothing of a KeyboardInterrupt that Python drops: the watching thread ends the process then.

    Python drops one that is raised where nobody could catch it, such as in the callback of a weak reference.
    """

    def say_others(dropped: sys.UnraisableHookArgs) -> None:
        if not issubclass(dropped.exc_type, KeyboardInterrupt):
            hook(dropped)

    return say_others


class _Once:
    """Words that are printed on standard error by the first caller only."""

    def __init__(self, words: str) -> None:
        self._words, self._lock = words, threading.Lock()

    def __call__(self) -> None:
        if self._lock.acquire(blocking=False):
            with contextlib.suppress(OSError, ValueError):
                print(self._words, file=sys.stderr, flush=True)


def _watch(arrivals: socket.socket, say: Callable[[], None], pressed: threading.Event) -> None:
    with arrivals:
        while signal.SIGINT not in (received := arrivals.recv(64)):
            if not received:
                return  # closed: nobody pressed Ctrl-C
        # If the key was pressed while Python ran generated code, it would end by the signal, not by the exit code.
        atexit.register(_end_flushed)
        pressed.set()
        arrivals.settimeout(GRACE)
        with contextlib.suppress(TimeoutError):
            while signal.SIGINT not in (received := arrivals.recv(64)):
                if not received:
                    return
    say()
    _end()  # without flushing: whoever reads may have stopped to


def _end_flushed() -> NoReturn:
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError):
            stream.flush()
    _end()


def _end() -> NoReturn:
    """End this process, and those that it started with those that they started."""
    with contextlib.suppress(Exception):
        import psutil  # comes with the extra mine, without which none are started that outlive this one

        for process in psutil.Process().children(recursive=True):
            with contextlib.suppress(psutil.NoSuchProcess):
                process.kill()
    os._exit(INTERRUPTED)
