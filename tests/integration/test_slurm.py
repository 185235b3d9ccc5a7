"""``cluster=slurm`` with jobs that run: `stand_in_slurm` starts their scripts here, no Slurm is asked."""

from __future__ import annotations

import asyncio
import signal
import subprocess
from pathlib import Path
from typing import Any

import pytest
from distributed import Client
from small_runs import BAD_START, CLEAN, INTERRUPTED, command, digests, run_here
from stand_in_slurm import Slurm, slurm

from pipeline.config.cluster import ClusterConfig
from pipeline.config.command_line import check_command, complete
from pipeline.errors import StartError
from pipeline.flow import run_pipeline
from pipeline.runtime.admission import Admission
from pipeline.runtime.clusters import open_cluster
from pipeline.runtime.clusters.slurm_jobs import Jobs, slurm_cluster
from pipeline.runtime.events import ItemDone, Note

__all__ = ["slurm"]

LIMIT = "sbatch: error: QOSMaxSubmitJobPerUserLimit"
HERE = ("cluster=slurm", "cluster.interface=lo")


def test_slurm_jobs_are_what_the_configuration_says(tmp_path: Path) -> None:
    config = ClusterConfig(
        "slurm",
        workers=6,
        jobs=2,
        memory="12GB",
        walltime="00:30:00",
        queue="short",
        account="shapes",
        logs=str(tmp_path / "logs"),
        options=("--qos=long", "--exclusive"),
        interface="lo",
    )
    with slurm_cluster(config) as cluster:
        script = cluster.job_script()
    head = [line.removeprefix("#SBATCH ") for line in script.splitlines() if line.startswith("#SBATCH")]
    wanted = {"-p short", "-A shapes", "-t 00:30:00", "--cpus-per-task=6", "--qos=long", "--exclusive"}
    assert wanted <= set(head) and any(line.startswith("--mem=12G") for line in head)
    assert any(line.startswith(f"-o {tmp_path / 'logs'}") for line in head)
    assert "export OMP_NUM_THREADS=1" in script and "export NUMBA_NUM_THREADS=1" in script
    (worker,) = [line for line in script.splitlines() if "distributed.cli.dask_worker" in line]
    assert "--nworkers 6" in worker and "--nthreads 1" in worker and "--memory-limit 0" in worker


@pytest.mark.system
def test_an_interrupt_cancels_all_jobs_and_one_that_dies_is_replaced(
    slurm: Slurm, finished: Path, root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One run in two lives, so that its work is done once: it is interrupted, goes on, and loses all its workers."""
    here = (*HERE, "cluster.wait=60")
    with subprocess.Popen(
        command(tmp_path, root, *here, "cluster.jobs=2", "cluster.workers=1"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # Where the tests run in the background, interrupts are ignored, and processes inherit that.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    ) as driver:
        assert driver.stdout is not None
        assert any(line.startswith("ingest") for line in driver.stdout), slurm.said()
        driver.send_signal(signal.SIGINT)
        _, said = driver.communicate(timeout=120)
    assert driver.returncode == INTERRUPTED and "the same command goes on" in said and "Traceback" not in said
    assert len(slurm.submitted) == 2 and set(slurm.cancelled) == set(slurm.submitted) and slurm.ended()

    monkeypatch.setattr("pipeline.runtime.clusters.dask_executor.PATIENCE", 3)
    noted: list[str] = []

    def listen(event: object) -> None:
        if isinstance(event, Note):
            noted.append(event.text)
        if isinstance(event, ItemDone) and event.stage == "qcrs" and len(slurm.submitted) == 3:
            slurm.kill(slurm.submitted[-1])

    # One job of several workers: dask-jobqueue alone never sees that it has ended.
    line = command(tmp_path, root, *here, "cluster.jobs=1", "cluster.workers=2")[3:]
    outcome = run_pipeline(check_command(complete(line)), listen)
    assert outcome.code == CLEAN, slurm.said()
    assert digests(tmp_path) == digests(finished)
    assert "all workers have gone: waiting for others to join" in noted
    assert len(slurm.submitted) == 4 and set(slurm.cancelled) == set(slurm.submitted)
    assert slurm.ended()


def test_an_interrupt_while_jobs_wait_cancels_them(slurm: Slurm, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Admission, "threads", lambda _: signal.raise_signal(signal.SIGINT))
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt), open_cluster(ClusterConfig("slurm", jobs=2, interface="lo", wait=60)):
            pass
    finally:
        signal.signal(signal.SIGINT, before)
    assert set(slurm.cancelled) == set(slurm.submitted) and slurm.ended()


def test_an_sbatch_that_fails_is_no_start(slurm: Slurm, root: Path, tmp_path: Path) -> None:
    slurm.refuse(LIMIT)
    done = run_here(tmp_path, root, *HERE)  # with the hour that the configuration would wait for a job
    assert done.returncode == BAD_START
    said = " ".join(done.stderr.split())
    assert f"Cannot start: cluster=slurm: no job could be submitted: {LIMIT}" in said and "Traceback" not in said
    assert not slurm.submitted


def submit(jobs: Jobs, cluster: Any) -> None:
    """Have missing jobs submitted, and wait until they are."""

    async def settled() -> None:
        await cluster

    jobs.submit()
    cluster.sync(settled)


@pytest.mark.system
def test_one_of_several_jobs_that_dies_is_replaced(slurm: Slurm) -> None:
    with slurm_cluster(ClusterConfig("slurm", jobs=2, workers=1, interface="lo")) as cluster, Client(cluster) as client:
        jobs = Jobs(cluster, 2, lambda _: None)
        submit(jobs, cluster)
        client.wait_for_workers(2, timeout=60)
        first, second = slurm.submitted
        slurm.kill(first)
        while len(cluster.scheduler_info["workers"]) == 2:
            client.sync(asyncio.sleep, 0.05)
        submit(jobs, cluster)  # it came and went between two looks
        assert len(slurm.submitted) == 3 and slurm.cancelled == [first] and slurm.processes(second)
    assert set(slurm.cancelled) == set(slurm.submitted) and slurm.ended()


def test_refused_jobs_are_told_once_and_submitted_again(slurm: Slurm) -> None:
    told: list[str] = []
    with slurm_cluster(ClusterConfig("slurm", jobs=2, workers=2, interface="lo")) as cluster:
        jobs = Jobs(cluster, 2, told.append)
        slurm.refuse(LIMIT)
        submit(jobs, cluster)
        assert jobs.refusals == [LIMIT] and told == []
        submit(jobs, cluster)
        submit(jobs, cluster)
        assert told == [f"Slurm refuses 2 of 2 jobs: {LIMIT}"] and not slurm.submitted
        slurm.refuse(None)
        submit(jobs, cluster)
        assert len(slurm.submitted) == 2 and not jobs.refusals
        submit(jobs, cluster)
        assert len(slurm.submitted) == 2  # those that wait are not submitted again
    assert set(slurm.cancelled) == set(slurm.submitted) and slurm.ended() and len(told) == 1


@pytest.mark.parametrize("wrong", [{"interface": "nowhere0"}, {"memory": "much"}])
def test_what_no_job_can_be_is_no_start(slurm: Slurm, wrong: dict[str, str]) -> None:
    config = ClusterConfig(**{"kind": "slurm", "interface": "lo", **wrong})  # type: ignore[arg-type]
    with pytest.raises(StartError, match=f"cluster=slurm: .*{next(iter(wrong.values()))}"), open_cluster(config):
        pass
    assert not slurm.submitted


@pytest.mark.parametrize("missing", ["sbatch", "scancel"])
def test_without_slurm_there_is_no_start(missing: str, slurm: Slurm, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(slurm.folder / "bin"))
    (slurm.folder / "bin" / missing).unlink()
    with pytest.raises(StartError, match=f"no `{missing}` here"), open_cluster(ClusterConfig("slurm")):
        pass
