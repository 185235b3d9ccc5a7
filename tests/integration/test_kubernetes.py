"""``cluster=kubernetes`` with a stand-in for the operator: what would be pods are processes. No Kubernetes is asked."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from distributed import LocalCluster
from small_runs import BAD_START, CLEAN, digests, run_here

from pipeline.runtime.clusters.dask_started import WORKER_COMMAND


def stand_in(monkeypatch: pytest.MonkeyPatch, credentials: bool = True) -> list[dict[str, Any]]:
    """Replace dask-kubernetes; returns what its cluster is made of, each time."""
    asked: list[dict[str, Any]] = []

    def kube_cluster(**options: Any) -> LocalCluster:
        asked.append(options)
        return LocalCluster(n_workers=options["n_workers"], threads_per_worker=1, host="127.0.0.1", memory_limit=0)

    def api() -> None:
        if not credentials:
            raise ValueError("Unable to find valid credentials")

    modules = {name: ModuleType(name) for name in ("dask_kubernetes", "dask_kubernetes.operator", "kr8s")}
    vars(modules["dask_kubernetes.operator"])["KubeCluster"] = kube_cluster
    vars(modules["kr8s"])["api"] = api
    for name, module in modules.items():
        monkeypatch.setitem(sys.modules, name, module)
    return asked


@pytest.mark.system
def test_pods_do_the_work_of_a_run(finished: Path, root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = stand_in(monkeypatch)
    line = ("cluster=kubernetes", "cluster.image=riot:1", "cluster.workers=1", "cluster.memory=2GB")
    ended = run_here(tmp_path, root, *line)
    assert ended.returncode == CLEAN, ended.stdout + ended.stderr
    assert digests(tmp_path) == digests(finished)
    (options,) = asked
    assert options["image"] == "riot:1" and options["n_workers"] == 1
    assert options["resources"] == {"requests": {"cpu": "1", "memory": "2G"}}


def test_without_credentials_there_is_no_start(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert not stand_in(monkeypatch, credentials=False)
    ended = run_here(tmp_path, root, "cluster=kubernetes", "cluster.image=riot")
    assert ended.returncode == BAD_START and "Unable to find valid credentials; look at `kubectl" in ended.stderr


def test_a_missing_package_names_its_extra(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for package, line in (
        ("dask_kubernetes", ("cluster=kubernetes", "cluster.image=riot")),
        ("asyncssh", ("cluster=ssh", "cluster.hosts=a")),
        ("bokeh", ("cluster=local", "cluster.dashboard=true")),
    ):
        monkeypatch.setitem(sys.modules, package, None)
        ended = run_here(tmp_path / package, root, *line)
        extra = {"dask_kubernetes": "kubernetes", "asyncssh": "ssh", "bokeh": "dashboard"}[package]
        assert ended.returncode == BAD_START and f"riot-shapes[{extra}]" in " ".join(ended.stderr.split())


def test_the_operator_takes_what_it_is_given() -> None:
    operator = pytest.importorskip("dask_kubernetes.operator", reason="the extra kubernetes")
    made = operator.make_cluster_spec(name="riot-1", image="riot", n_workers=3, worker_command=list(WORKER_COMMAND))
    (container,) = made["spec"]["worker"]["spec"]["containers"]
    assert made["spec"]["worker"]["replicas"] == 3 and container["image"] == "riot"
    assert container["args"][: len(WORKER_COMMAND)] == list(WORKER_COMMAND)
