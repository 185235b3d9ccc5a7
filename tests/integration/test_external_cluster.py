"""A real Dask scheduler with real workers of somebody else's making: ``cluster=external``."""

from __future__ import annotations

import shutil
import subprocess
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from dask_deployment import Deployment, deployment, kill
from small_runs import BAD_START, CLEAN, FAILED, command, digests, run_here, stages

from pipeline.config.command_line import check_command, complete
from pipeline.flow import run_pipeline
from pipeline.plan.sources import ROOT
from pipeline.runtime.events import Event, Note, StageEnded

__all__ = ["deployment"]


@pytest.fixture(scope="module")
def other_code(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The project with one more line in one module."""
    folder = tmp_path_factory.mktemp("other")
    for package in ("riot", "pipeline"):
        shutil.copytree(ROOT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
    with (folder / "riot" / "scores" / "trunks.py").open("a") as stream:
        stream.write("\nADDED = 1\n")
    return folder


@pytest.mark.system
def test_workers_come_and_go_and_the_bytes_are_the_same(
    deployment: Deployment, other_code: Path, finished: Path, root: Path, tmp_path: Path
) -> None:
    first = deployment.workers(2)
    deployment.workers(1, other_code)
    deployment.wait_for(3)

    def replace_all() -> None:
        kill(first)
        deployment.workers(1)

    where = tmp_path / "external"
    line = command(where, root, "cluster=external", f"cluster.address={deployment.address}")[3:]
    joining: dict[str, Callable[[], object]] = {"ingest": replace_all, "qcrs": lambda: deployment.workers(1)}
    told: list[str] = []

    def listen(event: Event) -> None:
        if isinstance(event, Note):
            told.append(event.text)
        if isinstance(event, StageEnded):
            joining.pop(event.stage, lambda: None)()

    outcome = run_pipeline(check_command(complete(line)), listen)
    assert outcome.code == CLEAN, told
    assert any("is refused: other code" in text and "code.riot.scores.trunks" in text for text in told) and not joining
    assert digests(where) == digests(finished)
    written = Counter(deployment.puts.read_text().splitlines())
    assert set(written.values()) == {1}  # no finished work item was done again
    counts = Counter(row.split(" ")[0] for row in written)
    done = stages(where)
    assert all(counts[name] == done[name]["computed"] for name in ("ingest", "trunks", "qcrs", "crs", "construct"))


@pytest.mark.system
def test_a_run_says_that_its_scheduler_is_gone_and_goes_on_with_another(
    deployment: Deployment, finished: Path, root: Path, tmp_path: Path
) -> None:
    deployment.workers(1)
    deployment.wait_for(1)
    where = tmp_path / "lost"
    line = command(where, root, "cluster=external", f"cluster.address={deployment.address}")
    process = subprocess.Popen(line, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    for text in process.stdout:
        if text.startswith("trunks"):
            kill(deployment.started[0])
            break
    _, errors = process.communicate(timeout=120)
    assert process.returncode == FAILED and "scheduler was lost" in errors and "Traceback" not in errors
    assert run_here(where, root).returncode == CLEAN and digests(where) == digests(finished)


def test_a_scheduler_without_workers_that_will_do_is_no_start(
    deployment: Deployment, other_code: Path, root: Path, tmp_path: Path
) -> None:
    options = ("cluster=external", f"cluster.address={deployment.address}", "cluster.wait=1")
    idle = run_here(tmp_path / "idle", root, *options)
    assert idle.returncode == BAD_START and "dask worker" in idle.stderr
    deployment.workers(1, other_code)
    deployment.wait_for(1)
    refused = run_here(tmp_path / "refused", root, *options)
    assert refused.returncode == BAD_START and "none of its workers will do" in refused.stderr
    assert "code.riot.scores.trunks" in refused.stderr and not deployment.puts.exists()
