"""Opening a cluster, whichever kind the configuration names."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from pipeline.config.cluster import ClusterConfig
from pipeline.runtime.clusters.dask_started import open_started
from pipeline.runtime.clusters.executor import Executor
from pipeline.runtime.clusters.external import open_external
from pipeline.runtime.clusters.local import open_local
from pipeline.runtime.clusters.slurm import open_slurm
from pipeline.runtime.clusters.sync import SyncExecutor
from pipeline.runtime.events import Listener
from pipeline.store.store import Store


def ignore(_event: object) -> None:
    """A listener that does nothing."""


@contextlib.contextmanager
def open_cluster(config: ClusterConfig, store: Store | None = None, listen: Listener = ignore) -> Iterator[Executor]:
    """Open the cluster that the configuration names and close it afterwards.

    Workers beyond this machine must see the store ``store``; ``listen`` gets a note of each worker that is refused.
    Raises `StartError` when the cluster cannot be reached or all of its workers are refused.
    """
    match config.kind:
        case "sync":
            yield SyncExecutor()
        case "local":
            with open_local(config, listen) as executor:
                yield executor
        case "external":
            with open_external(config, store, listen) as executor:
                yield executor
        case "ssh" | "kubernetes":
            with open_started(config, store, listen) as executor:
                yield executor
        case "slurm":
            with open_slurm(config, store, listen) as executor:
                yield executor
