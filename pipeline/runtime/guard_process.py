"""The process beside a worker: ``python -m pipeline.runtime.guard_process DESCRIPTOR`` does what the guard sends it."""

from __future__ import annotations

import contextlib
import signal
import sys
from multiprocessing.connection import Connection

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)
from pipeline.runtime.inputs import Kept
from pipeline.runtime.worker import perform


def main(descriptor: int) -> None:
    """Do task after task; end when the worker does, or by the alarm's signal when an item takes too long."""
    # Nothing of Python's handles it: the system ends the process, whatever it is in.
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the run's own process answers
    kept = Kept()
    with Connection(descriptor) as connection, contextlib.suppress(EOFError, OSError):
        while True:
            root, items, limit = connection.recv()
            receipts = perform(root, items, kept)
            for _ in items:
                signal.setitimer(signal.ITIMER_REAL, limit or 0.0)
                receipt = next(receipts)
                signal.setitimer(signal.ITIMER_REAL, 0.0)
                connection.send(receipt)


if __name__ == "__main__":
    main(int(sys.argv[1]))
