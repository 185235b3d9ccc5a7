"""``cluster=external``: the workers of a Dask scheduler that somebody else started."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from functools import partial

from pipeline.config.cluster import ClusterConfig
from pipeline.errors import StartError
from pipeline.runtime.admission import Admission
from pipeline.runtime.clusters.dask_executor import DaskExecutor, run_on_worker, set_dask_options
from pipeline.runtime.clusters.executor import Executor
from pipeline.runtime.events import Listener, Note
from pipeline.store.store import Store
from riot.errors import needs_extra


@contextlib.contextmanager
def open_external(config: ClusterConfig, store: Store | None, listen: Listener) -> Iterator[Executor]:
    """Connect to the scheduler at ``config.address`` and wait for a worker that is admitted."""
    with needs_extra("mine"):
        from distributed import Client

    set_dask_options()
    try:
        client = Client(config.address, timeout=config.wait)
    except (OSError, TimeoutError, TypeError, ValueError) as error:  # TypeError: no certificate for tls://
        raise StartError(
            f"cluster.address={config.address}: no Dask scheduler answers there ({error}); "
            "start one with `dask scheduler` and workers with `dask worker`, or use cluster=local"
        ) from error
    with client:
        admission = Admission(client, store, lambda text: listen(Note(text)))
        admission.wait(
            f"cluster.address={config.address}", config.wait, f"start some with `dask worker {config.address}`"
        )
        yield DaskExecutor(client, partial(run_on_worker, limit=config.limit), admission=admission)
