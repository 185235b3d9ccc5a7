"""``cluster=slurm`` with jobs that run: `stand_in_slurm` starts their scripts here, no Slurm is asked."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from small_runs import BAD_START, CLEAN, command, digests, run_here
from stand_in_slurm import Slurm

from pipeline.closure import ROOT
from pipeline.cluster import open_cluster
from pipeline.command import check_command, complete
from pipeline.config import ClusterConfig
from pipeline.errors import StartError
from pipeline.events import ItemDone, Note
from pipeline.flow import run_pipeline
from pipeline.slurm import Jobs, slurm_cluster

LIMIT = "sbatch: error: QOSMaxSubmitJobPerUserLimit"
HERE = ("cluster=slurm", "cluster.interface=lo")


@pytest.fixture
def slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Slurm]:
    made = Slurm(tmp_path / "slurm")
    monkeypatch.setenv("PATH", f"{made.install()}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    yield made
    made.kill(*made.submitted)


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


def test_a_job_that_dies_is_replaced_and_the_bytes_are_the_same(
    slurm: Slurm, finished: Path, root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pipeline.cluster.PATIENCE", 3)
    noted: list[str] = []

    def listen(event: object) -> None:
        if isinstance(event, Note):
            noted.append(event.text)
        if isinstance(event, ItemDone) and event.stage == "trunks" and len(slurm.submitted) == 1:
            slurm.kill(*slurm.submitted)

    # One job of several workers: dask-jobqueue alone never sees that it has ended.
    line = command(tmp_path, root, *HERE, "cluster.jobs=1", "cluster.workers=2")[3:]
    outcome = run_pipeline(check_command(complete(line)), listen)
    assert outcome.code == CLEAN, slurm.said()
    assert digests(tmp_path) == digests(finished)
    assert "all workers have gone: waiting for others to join" in noted
    assert len(slurm.submitted) == 2 and set(slurm.cancelled) == set(slurm.submitted)
    assert slurm.ended()


def test_an_sbatch_that_fails_is_no_start(slurm: Slurm, root: Path, tmp_path: Path) -> None:
    slurm.refuse(LIMIT)
    done = run_here(tmp_path, root, *HERE)  # with the hour that the configuration would wait for a job
    assert done.returncode == BAD_START
    said = " ".join(done.stderr.split())
    assert f"Cannot start: cluster=slurm: no job could be submitted: {LIMIT}" in said and "Traceback" not in said
    assert not slurm.submitted


def test_refused_jobs_are_told_once_and_submitted_again(slurm: Slurm) -> None:
    told: list[str] = []
    with slurm_cluster(ClusterConfig("slurm", jobs=2, workers=2, interface="lo")) as cluster:

        async def settled() -> None:
            await cluster

        jobs = Jobs(cluster, 2, told.append)

        def submit() -> None:
            jobs.submit()
            cluster.sync(settled)

        slurm.refuse(LIMIT)
        submit()
        assert jobs.refusals == [LIMIT] and told == []
        submit()
        submit()
        assert told == [f"Slurm refuses 2 of 2 jobs: {LIMIT}"] and not slurm.submitted
        slurm.refuse(None)
        submit()
        assert len(slurm.submitted) == 2 and not jobs.refusals
        submit()
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
