"""``cluster=ssh`` and ``cluster=kubernetes``: workers that Dask's own deployments start on other machines, and end.

What they need beyond ours is in Dask's configuration (``~/.config/dask``) and in that of `ssh` and `kubectl`.
"""

from __future__ import annotations

import contextlib
import importlib
from collections.abc import Iterator
from functools import partial
from typing import Any

from pipeline.config.cluster import ClusterConfig
from pipeline.errors import StartError
from pipeline.runtime.admission import Admission
from pipeline.runtime.clusters.dask_executor import DaskExecutor, check_dashboard, run_on_worker, set_dask_options
from pipeline.runtime.clusters.executor import Executor
from pipeline.runtime.events import Listener, Note
from pipeline.runtime.interrupts import interrupts_held
from pipeline.store.store import Store
from riot.errors import MissingExtraError, needs_extra

WORKER_COMMAND = ("dask", "worker", "--nthreads", "1", "--memory-limit", "0")
"""What a pod runs; the operator adds name and scheduler."""


@contextlib.contextmanager
def open_started(config: ClusterConfig, store: Store | None, listen: Listener) -> Iterator[Executor]:
    """Start scheduler and workers, wait for one that is admitted, and end all of them afterwards."""
    kind = config.kind
    try:
        with needs_extra(kind):
            importlib.import_module({"ssh": "asyncssh", "kubernetes": "dask_kubernetes"}[kind])
    except MissingExtraError as error:
        raise StartError(f"cluster={kind}: {error}") from error
    with needs_extra("mine"):
        from distributed import Client

    if config.dashboard and kind == "ssh":  # a pod has its own packages
        check_dashboard()
    set_dask_options(watched=config.dashboard)
    start, hint = (_ssh, "try `ssh HOST`") if kind == "ssh" else (_kubernetes, "look at `kubectl get daskclusters`")
    try:
        with interrupts_held():
            cluster = start(config)
    except Exception as error:  # each library has its own
        raise StartError(f"cluster={kind}: it cannot be started: {error}; {hint}") from error
    with cluster, Client(cluster) as client:
        if config.dashboard:
            listen(Note(f"dashboard: {client.dashboard_link}"))
        admission = Admission(client, store, lambda text: listen(Note(text)))
        admission.wait(f"cluster={kind}", config.wait, hint)
        yield DaskExecutor(client, partial(run_on_worker, limit=config.limit), admission=admission)


def _ssh(config: ClusterConfig) -> Any:
    """The scheduler on the first host, and workers on all."""
    from distributed import SSHCluster

    return SSHCluster(
        [config.hosts[0], *config.hosts],
        # A limit would kill by the machine's size, so that results would depend on it.
        worker_options={"n_workers": config.workers or 1, "nthreads": 1, "memory_limit": 0},
        scheduler_options={"port": 0, "dashboard": config.dashboard},
        remote_python=config.python,
    )


def _kubernetes(config: ClusterConfig) -> Any:
    """A ``DaskCluster`` resource of dask-kubernetes' operator, with a worker in each pod."""
    import kr8s
    from dask_kubernetes.operator import KubeCluster

    kr8s.api()  # raises without credentials; a KubeCluster would try again, and fail, as this process ends
    return KubeCluster(
        name="riot-{uuid}",
        image=config.image,
        n_workers=config.workers or 1,
        worker_command=list(WORKER_COMMAND),
        resources={"requests": {"cpu": "1", "memory": config.memory.removesuffix("B")}},
        quiet=True,
    )
