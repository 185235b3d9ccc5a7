"""``cluster.minimum``: workers come when there is work for them, go when there is none, and the bytes are the same."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from distributed import Client
from small_runs import CLEAN, digests, run
from stand_in_slurm import Slurm, slurm

from pipeline.config.cluster import ClusterConfig
from pipeline.config.command_line import check_command, complete
from pipeline.errors import ConfigError
from pipeline.plan.work_item import WorkItem
from pipeline.runtime.clusters import open_cluster
from pipeline.runtime.clusters.dask_executor import DaskExecutor
from pipeline.runtime.clusters.slurm_jobs import Jobs, slurm_cluster
from pipeline.runtime.worker import Receipt
from pipeline.store.keys import KeyParts
from pipeline.store.store import Store

__all__ = ["slurm"]


def meeting() -> Callable[[str], None]:
    """Work that ends once two processes are at it: with one worker alone it goes on and on."""

    def meet(folder: str) -> None:  # within a function, so that it is sent as it is
        import os
        import time

        open(os.path.join(folder, str(os.getpid())), "w").close()  # noqa: PTH118, PTH123
        while len(os.listdir(folder)) < 2:  # noqa: PTH208
            time.sleep(0.05)  # an endless loop would keep the worker from its own work

    return meet


@pytest.mark.system
def test_a_second_worker_comes_for_work_that_the_first_is_slow_at(tmp_path: Path) -> None:
    meet = meeting()

    def task(store: Store, bundle: Sequence[WorkItem]) -> list[Receipt]:
        meet(store.text)
        return [Receipt(item.stage, item.key) for item in bundle]

    items = [WorkItem(KeyParts("crs", {"name": name}, (), {}, {}), (), (), name, (0,)) for name in "abcdef"]
    with open_cluster(ClusterConfig("local", workers=2, minimum=1)) as opened:
        assert isinstance(opened, DaskExecutor)
        assert opened.workers == 2 and len(opened.client.nthreads()) == 1
        executor = DaskExecutor(opened.client, task, opened.replace_workers, most=opened.most)
        assert {receipt.key for receipt in executor.run(Store(tmp_path), [[item] for item in items])} == {
            item.key for item in items
        }
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.system
def test_a_run_on_workers_that_come_and_go_is_the_same(finished: Path, root: Path, tmp_path: Path) -> None:
    ended = run(tmp_path / "scaled", root, "cluster.workers=2", "cluster.minimum=1")
    assert ended.returncode == CLEAN, ended.stdout + ended.stderr
    assert digests(tmp_path / "scaled") == digests(finished)


@pytest.mark.system
def test_jobs_are_submitted_for_work_and_cancelled_without(slurm: Slurm, tmp_path: Path) -> None:
    config = ClusterConfig("slurm", jobs=2, workers=1, minimum=1, interface="lo")
    with slurm_cluster(config) as cluster, Client(cluster) as client:
        jobs = Jobs(cluster, 2, lambda _: None, minimum=1)
        jobs.submit()
        client.wait_for_workers(1, timeout=60)
        assert len(slurm.submitted) == 1
        (tmp_path / "met").mkdir()
        at_work = [
            client.submit(meeting(), str(tmp_path / "met"), key=f"meet-{number}", pure=False) for number in range(6)
        ]
        client.gather(at_work)
        assert len(slurm.submitted) == 2
        del at_work
        while not slurm.cancelled:
            jobs.submit()  # as a run does now and then
        assert len(cluster.worker_spec) == 1 and len(slurm.submitted) == 2
    assert set(slurm.cancelled) == set(slurm.submitted) and slurm.ended()


@pytest.mark.parametrize(
    ("line", "what"),
    [
        (["cluster=local", "cluster.workers=2", "cluster.minimum=3"], "more than the 2"),
        (["cluster=slurm", "cluster.jobs=2", "cluster.minimum=3"], "more than the 2"),
        (["cluster=external", "cluster.address=tcp://host:8786", "cluster.minimum=1"], "does not scale"),
        (["cluster=ssh"], "cluster.hosts=a,b"),
        (["cluster=kubernetes"], "needs an image"),
    ],
)
def test_what_cannot_be_is_told_before_the_run(line: list[str], what: str) -> None:
    with pytest.raises(ConfigError, match=what):
        check_command(complete(line))
