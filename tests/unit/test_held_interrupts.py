"""Ctrl-C while workers start: it waits, is answered then, and never reaches what starts meanwhile."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest

from pipeline.runtime.interrupts import interrupts_held

CHILD = "import signal; print(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ()))"

pytestmark = pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="masks of signals are POSIX")


def test_a_press_is_answered_after_the_start() -> None:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    reached = []
    try:
        with pytest.raises(KeyboardInterrupt), interrupts_held():
            signal.raise_signal(signal.SIGINT)
            reached.append("the end of the start")
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
    assert reached


def test_a_process_that_starts_meanwhile_never_gets_it() -> None:
    with interrupts_held():
        child = subprocess.run([sys.executable, "-c", CHILD], capture_output=True, text=True, check=True)
    assert child.stdout.strip() == "True"
    after = subprocess.run([sys.executable, "-c", CHILD], capture_output=True, text=True, check=True)
    assert after.stdout.strip() == "False"
