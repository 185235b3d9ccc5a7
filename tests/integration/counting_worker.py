"""Preloaded by Dask workers of tests: a line in ``$PUTS`` for every artifact that a worker writes."""

import os

from pipeline.store import Store

_put = Store.put


def _counted(self, parts, artifact, cost=None):
    key = _put(self, parts, artifact, cost)
    descriptor = os.open(os.environ["PUTS"], os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    os.write(descriptor, f"{parts.stage} {key}\n".encode())
    os.close(descriptor)
    return key


def dask_setup(worker):
    """Called by Dask in every worker process before its first task."""
    Store.put = _counted
