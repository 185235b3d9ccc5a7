"""The process beside a worker: ``python -m pipeline.runtime.isolated_process NUMBER`` runs what the worker sends it."""

from __future__ import annotations

import contextlib
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from multiprocessing.connection import Connection

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)
from pipeline.plan.work_item import WorkItem
from pipeline.runtime.inputs import InputCache
from pipeline.runtime.worker import Receipt, run_items
from pipeline.store.store import Store

RunItems = Callable[[Store, Sequence[WorkItem], InputCache], Iterator[Receipt]]


def main(descriptor: int, run: RunItems = run_items) -> None:
    """Run task after task; end when the worker ends, or by the alarm's signal when an item takes too long."""
    # Python must not handle it: the system then ends the process, whatever code it is in.
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the run's own process answers
    cache = InputCache()
    with Connection(descriptor) as connection, contextlib.suppress(EOFError, OSError):
        while True:
            store, items, limit = connection.recv()
            receipts = run(store, items, cache)
            for _ in items:
                signal.setitimer(signal.ITIMER_REAL, limit or 0.0)
                receipt = next(receipts)
                signal.setitimer(signal.ITIMER_REAL, 0.0)
                connection.send(receipt)


if __name__ == "__main__":
    main(int(sys.argv[1]))
