"""``cluster=slurm``: the workers of Slurm jobs, which join a scheduler in this process."""

from __future__ import annotations

import contextlib
import shutil
import signal
from collections.abc import Iterator
from functools import partial
from types import ModuleType

from pipeline.config.cluster import ClusterConfig
from pipeline.errors import StartError
from pipeline.runtime import clusters
from pipeline.runtime.admission import Admission
from pipeline.runtime.clusters.dask_executor import DaskExecutor, check_dashboard, run_on_worker, set_dask_options
from pipeline.runtime.clusters.executor import Executor
from pipeline.runtime.events import Listener, Note
from pipeline.runtime.interrupts import interrupts_handled_by
from pipeline.store.store import Store
from riot.errors import MissingExtraError, needs_extra


@contextlib.contextmanager
def open_slurm(config: ClusterConfig, store: Store | None, listen: Listener) -> Iterator[Executor]:
    """Submit the jobs and wait for a worker that is admitted; cancel the jobs afterwards."""
    with needs_extra("slurm"):
        from distributed import Client

    if config.dashboard:
        check_dashboard()
    set_dask_options(watched=config.dashboard)
    for program in ("sbatch", "scancel"):
        if shutil.which(program) is None:
            raise StartError(
                f"cluster=slurm: there is no `{program}` here; start the run where Slurm jobs are submitted"
            )
    slurm_jobs = _load_jobs()
    try:
        cluster = slurm_jobs.slurm_cluster(config)
    except (OSError, RuntimeError, ValueError) as error:  # no such interface, a size that is none, a folder for logs
        raise StartError(f"cluster=slurm: {error}; `python -m pipeline.run --help` lists its parameters") from error
    with cluster, Client(cluster) as client:
        if config.dashboard:
            listen(Note(f"dashboard: {client.dashboard_link}"))
        jobs = slurm_jobs.Jobs(cluster, config.jobs, lambda text: listen(Note(text)), config.minimum)
        jobs.submit()
        admission = Admission(client, store, lambda text: listen(Note(text)))
        admission.wait("cluster=slurm", config.wait, "look at `squeue`", lambda: jobs.refusals)
        task = partial(run_on_worker, limit=config.limit)
        most = 1 if config.minimum is None else config.jobs * (config.workers or 1)
        yield DaskExecutor(client, task, jobs.submit, admission, most)


def _load_jobs() -> ModuleType:
    """`pipeline.runtime.clusters.slurm_jobs`, which needs dask-jobqueue."""
    try:
        # Once dask-jobqueue is loaded, Ctrl-C would end this process with exit code 0, as if all were done.
        with needs_extra("slurm"), interrupts_handled_by(signal.getsignal(signal.SIGINT)):
            return clusters.slurm_jobs
    except MissingExtraError as error:
        raise StartError(f"cluster=slurm: {error}") from error
