"""The parameters of where a run computes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pipeline.config.parsing import parse_names
from riot.errors import ParameterError
from riot.parameters import ParameterGroup, parameter


@dataclass(frozen=True)
class ClusterConfig(ParameterGroup):
    """Where the work runs, which changes no key and no result."""

    kind: Literal["local", "sync", "external", "slurm", "ssh", "kubernetes"] = parameter(
        "local",
        meaning="local: worker processes on this machine, one thread each. sync: this process, one work item after "
        "another. external: any Dask deployment whose workers see the store and the data set. slurm: jobs of Slurm. "
        "ssh: machines that SSH reaches. kubernetes: pods.",
    )
    workers: int | None = parameter(
        None,
        at_least=1,
        meaning="Worker processes: of local, null = one for each CPU; of each job of slurm or host of ssh, null = one; "
        "pods of kubernetes, null = one.",
    )
    minimum: int | None = parameter(
        None,
        at_least=1,
        meaning="Workers of local, or jobs of slurm, that stay when there is little to do: Dask scales from this to "
        "as many as there may be. null = all from the start to the end.",
    )
    address: str | None = parameter(None, meaning="Scheduler of external, such as tcp://host:8786.")
    wait: int = parameter(
        30,
        at_least=0,
        unit="s",
        meaning="How long external waits for the scheduler and its first worker, the others for their first worker.",
    )
    dashboard: bool = parameter(False, meaning="Serve Dask's dashboard (not external; extra dashboard).")
    limit: float | None = parameter(
        600.0,
        above=0,
        unit="s",
        meaning="A work item (a batch of shapes, a block of pairs, a pair) that takes longer is stopped and becomes an "
        "error; null = never. sync stops nothing.",
    )
    hosts: tuple[str, ...] = parameter(
        (),
        parse=parse_names,
        meaning="Machines of ssh, such as a,b, as `ssh` knows them; the first one has the scheduler, too.",
    )
    python: str | None = parameter(
        None, meaning="The Python with riot on the machines of ssh; null = the path of the one that runs here."
    )
    image: str | None = parameter(None, meaning="The image of kubernetes; docker/Dockerfile makes one.")
    jobs: int = parameter(1, at_least=1, meaning="Jobs of slurm.")
    memory: str = parameter("4GB", meaning="Memory of a job of slurm for all its workers, of a pod of kubernetes.")
    walltime: str = parameter(
        "01:00:00", meaning="A job of slurm ends after this time, and another one replaces it; hours:minutes:seconds."
    )
    queue: str | None = parameter(None, meaning="Partition of slurm; null = the cluster's own choice.")
    account: str | None = parameter(None, meaning="Account of slurm; null = the cluster's own choice.")
    interface: str | None = parameter(
        None,
        meaning="Network interface by which scheduler and workers of slurm see one another, such as ib0; null = the "
        "machine's first.",
    )
    logs: str | None = parameter(
        None, meaning="Folder for what the jobs of slurm print; null = where the run was started."
    )
    options: tuple[str, ...] = parameter(
        (), meaning="Further options of sbatch, each in quotes, such as ['--qos=long','--exclusive']."
    )

    def check_together(self) -> None:
        """Check that a kind has what it needs; raises `riot.errors.ParameterError`."""
        if self.kind == "external" and not self.address:
            raise ParameterError("address", "cluster=external needs the scheduler's address, such as tcp://host:8786")
        if self.kind == "ssh" and not self.hosts:
            raise ParameterError("hosts", "cluster=ssh needs the machines, such as cluster.hosts=a,b")
        if self.kind == "kubernetes" and not self.image:
            raise ParameterError(
                "image", "cluster=kubernetes needs an image that has riot; docker/Dockerfile makes one"
            )
        if self.minimum is not None:
            most = {"local": self.workers, "slurm": self.jobs}
            if self.kind not in most:
                raise ParameterError("minimum", f"needs cluster=local or slurm; {self.kind} does not scale")
            if self.minimum > (most[self.kind] or self.minimum):
                raise ParameterError("minimum", f"is more than the {most[self.kind]} that there may be")
