"""``cluster=local``: worker processes of this machine, with one thread each."""

from __future__ import annotations

import contextlib
import logging
import os
from collections.abc import Iterator
from functools import partial

from pipeline.config.cluster import ClusterConfig
from pipeline.runtime.clusters.dask_executor import DaskExecutor, check_dashboard, run_on_worker, set_dask_options
from pipeline.runtime.clusters.executor import Executor
from pipeline.runtime.events import Listener, Note
from pipeline.runtime.interrupts import interrupts_held
from pipeline.runtime.threads import ONE_THREAD
from riot.errors import needs_extra

LOOPBACK = "127.0.0.1"
"""All ports of the cluster are open to this machine alone."""


@contextlib.contextmanager
def open_local(config: ClusterConfig, listen: Listener) -> Iterator[Executor]:
    """Start the workers, as many as the machine has cores if the configuration does not say; end them afterwards."""
    with needs_extra("mine"):
        from distributed import Client, LocalCluster
    if config.dashboard:
        check_dashboard()

    set_dask_options(watched=config.dashboard)
    workers = config.workers or os.cpu_count() or 1
    # The terminal sends Ctrl-C to all processes, and only this one should answer.
    with interrupts_held():
        cluster = LocalCluster(
            n_workers=config.minimum or workers,
            threads_per_worker=1,
            processes=True,
            host=LOOPBACK,
            # With None Dask tries 8787 all the same; without a host it listens to all networks.
            dashboard_address=f"{LOOPBACK}:{8787 if config.dashboard else 0}",
            memory_limit=0,  # a limit would kill by the machine's size, so that results would depend on it
            env=ONE_THREAD,
            silence_logs=logging.CRITICAL,
        )
    with cluster, Client(cluster) as client:
        if config.dashboard:
            listen(Note(f"dashboard: {client.dashboard_link}"))
        task, most = partial(run_on_worker, limit=config.limit), 1
        if config.minimum is not None:
            cluster.adapt(minimum=config.minimum, maximum=workers)
            most = workers

        def replace_workers() -> None:
            # A worker that dies while it starts takes its nanny with it; scaling to the same size starts another.
            cluster.scale(workers if config.minimum is None else len(cluster.worker_spec))

        yield DaskExecutor(client, task, replace_workers, most=most)
