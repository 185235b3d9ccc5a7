"""Slurm jobs whose workers join a scheduler in this process, through dask-jobqueue (the extra ``slurm``).

dask-jobqueue submits a job and cancels it. What it leaves to its caller is here: a submission that Slurm refuses is
told, and a job of several workers that has ended is replaced.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from pipeline.config.cluster import ClusterConfig
from pipeline.runtime.threads import ONE_THREAD
from riot.errors import needs_extra

with needs_extra("slurm"):
    from dask_jobqueue import SLURMCluster
    from dask_jobqueue.slurm import SLURMJob
    from distributed import SchedulerPlugin, Status


class Job(SLURMJob):  # type: ignore[misc]
    """A job, or what Slurm said when it refused it."""

    refusal = ""

    async def start(self) -> None:
        """Submit the job; what is wrong with that goes to `refusal`: an error raised here would end in a log."""
        try:
            await super().start()
        except (RuntimeError, ValueError, OSError) as error:  # sbatch failed, or said no number, or cannot be run
            self.refusal = str(error).rpartition("stderr:\n")[2].strip() or str(error)
            self.status = Status.running  # for Dask, to which a job that waits looks the same

    async def close(self) -> None:
        """Cancel the job."""
        await super().close()
        self.status = Status.closed  # Dask asks for it when it closes, and dask-jobqueue does not say it


class _Arrivals(SchedulerPlugin):  # type: ignore[misc]
    """Names of all workers that ever joined: one that came and went between two looks was there, too."""

    def __init__(self) -> None:
        self.names: set[str] = set()

    def add_worker(self, scheduler: Any, worker: str) -> None:
        """See `SchedulerPlugin.add_worker`."""
        self.names.add(str(scheduler.workers[worker].name))


class Jobs:
    """So many jobs, submitted again when they have ended or were refused."""

    def __init__(self, cluster: Any, count: int, tell: Callable[[str], None], minimum: int | None = None) -> None:
        """``cluster``: a `slurm_cluster`; ``tell`` gets a line for every new reason of a refusal.

        With a ``minimum`` there are as many as the work asks for, from that to ``count``.
        """
        self._cluster, self._count, self._tell, self._minimum = cluster, count, tell, minimum
        self._scales = False
        self._arrivals = _Arrivals()
        self._told: set[str] = set()
        cluster.scheduler.add_plugin(self._arrivals)

    @property
    def refusals(self) -> list[str]:
        """What Slurm said of jobs that it refused, if it refused all that there should be."""
        jobs = list(self._cluster.workers.values())
        said = sorted({job.refusal for job in jobs})
        return said if len(jobs) >= (self._minimum or self._count) and all(said) else []

    def submit(self) -> None:
        """Submit as many jobs as are missing, in place of those that have ended or were refused, too."""
        refused = {name: job.refusal for name, job in list(self._cluster.workers.items()) if job.refusal}
        for said in sorted(set(refused.values()) - self._told):
            self._tell(f"Slurm refuses {list(refused.values()).count(said)} of {self._count} jobs: {said}")
            self._told.add(said)
        came = set(self._arrivals.names)  # before those who are here: one that joins meanwhile is not gone
        here = {str(one.name) for one in list(self._cluster.scheduler.workers.values())}
        of_job = self._workers()
        ended = {job for job, names in of_job.items() if names & came and not names & here}
        gone = sorted(ended | refused.keys())
        if gone:
            self._cluster.sync(self._cluster.scale_down, gone)
            self._arrivals.names -= set().union(
                *(of_job.get(job, set()) for job in gone)
            )  # the next job may have the same name
        if self._minimum is None:
            self._cluster.scale(jobs=self._count)
        elif not self._scales:
            self._scales = True
            self._cluster.adapt(minimum_jobs=self._minimum, maximum_jobs=self._count)

    def _workers(self) -> dict[str, set[str]]:
        """The names of each job's workers: that of the job, with a suffix for each if there are several."""
        specs = list(self._cluster.worker_spec.items())
        return {job: {f"{job}{suffix}" for suffix in spec.get("group", ("",))} for job, spec in specs}


def slurm_cluster(config: ClusterConfig) -> Any:
    """The jobs of ``cluster=slurm`` and their scheduler, which runs in this process; no job is submitted yet."""
    workers = config.workers or 1
    return SLURMCluster(
        job_cls=Job,
        cores=workers,
        processes=workers,
        memory=config.memory,
        walltime=config.walltime,
        queue=config.queue,
        account=config.account,
        interface=config.interface,
        log_directory=config.logs,
        job_extra_directives=list(config.options),
        job_script_prologue=[f"export {name}={value}" for name, value in ONE_THREAD.items()],
        # The scheduler ends a job; a limit on memory would kill workers by the machine's size.
        worker_extra_args=["--memory-limit", "0"],
        python=sys.executable,
        scheduler_options={"dashboard_address": ":8787" if config.dashboard else ":0"},
    )
