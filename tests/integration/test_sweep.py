"""Sweeps: what jobs share, the table of all of them, and jobs that fail."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from small_runs import BAD_START, CLEAN, INTERRUPTED, SHAPES, digests, run_here, stages, table

from pipeline import flow as flow_module
from pipeline.cli import summary as summary_module
from pipeline.config.schema import Config
from pipeline.errors import StartError
from pipeline.exit_codes import FAILED
from pipeline.flow import RunOutcome
from pipeline.run import main
from pipeline.runtime.events import Listener
from riot import Transform


def test_a_sweep_shares_what_its_parameters_do_not_touch(copied: Path, root: Path) -> None:
    before = digests(copied)
    done = run_here(copied, root, "cluster=sync", "-m", "construct.method=exact,laplacian")
    assert done.returncode == CLEAN, done.stdout + done.stderr
    assert done.stdout.count("Best transforms") == 2
    points = [f"construct.method={method}" for method in ("exact", "laplacian")]
    counts = [stages(copied, point) for point in points]
    assert [one["refine"]["computed"] for one in counts] == [0, 0]
    assert [one["construct"]["computed"] for one in counts] == [0, 3]
    # What the paper's method makes is listed as what it is, and gets no motion.
    folder = copied / "outputs" / points[1] / "folder"
    approximate = pq.read_table(folder / "transforms.parquet").to_pylist()
    assert {row["status"] for row in approximate} == {"approximate"} and counts[1]["motion"]["total"] == 0
    assert all(row["gap_p"] > 0.0 and row["swings_flat"] is None for row in approximate)
    assert [row["iou"] for row in approximate] == sorted((row["iou"] for row in approximate), reverse=True)
    made = Transform.load(folder / approximate[0]["file"])
    assert not made.certificate().passed and made.plan is None
    assert "3 transforms are approximate" in done.stdout
    assert digests(copied) == before  # a sweep leaves the plain run's tables alone
    told = copied / "outputs" / "sweep=construct.method"
    rows = pq.read_table(told / "sweep.parquet").to_pylist()
    assert [row["construct.method"] for row in rows] == ["exact", "laplacian"]
    assert [row["folder"] for row in rows] == [f"{point}/folder" for point in points]
    for row, point in zip(rows, points, strict=True):
        record = json.loads((copied / "outputs" / point / "folder" / "run.json").read_text())
        assert row["status"] == "clean" and all(row[name] == record["counts"][name] for name in ("shapes", "certified"))
    best = {row["status"]: row["iou"] for row in reversed(table(copied, "transforms"))}["certified"]
    assert rows[0]["iou_max"] == best and rows[1]["iou_max"] is None and rows[1]["approximate"] == 3
    assert rows[0]["crs_max"] == rows[1]["crs_max"] == max(row["score"] for row in table(copied, "crs"))  # type: ignore[type-var]
    spent = pq.read_table(told / "timings.parquet").to_pylist()
    assert {(row["construct.method"], row["stage"]): row["computed"] for row in spent}["laplacian", "construct"] == 3


class Runs:
    """Stands in for runs: what becomes of each is told by the value of ``batch``."""

    def __init__(self, folder: Path, failing: dict[int, BaseException]) -> None:
        self.folder, self.failing = folder, failing
        self.done: list[int] = []

    def __call__(self, config: Config, listen: Listener) -> RunOutcome:
        self.done.append(config.batch)
        if config.batch in self.failing:
            raise self.failing[config.batch]
        target = config.outputs / "sample"
        if not target.exists():
            shutil.copytree(self.folder, target)
        return RunOutcome(CLEAN, target, None, False, 0.0, None)  # type: ignore[arg-type]


@pytest.fixture
def sweep(finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., tuple[int, list[int]]]:
    """Runs a sweep whose jobs are scripted; returns its exit code and the jobs that were begun."""
    monkeypatch.setattr(summary_module, "show_outcome", lambda outcome, console, *, verbose: None)

    def swept(values: str, **failing: BaseException) -> tuple[int, list[int]]:
        runs = Runs(finished / "outputs" / "folder", {int(name[1:]): error for name, error in failing.items()})
        monkeypatch.setattr(flow_module, "run_pipeline", runs)
        code = main(["-m", f"batch={values}", f"outputs={tmp_path / 'outputs'}", f"store={tmp_path / 'store'}"])
        return code, runs.done

    return swept


def test_a_sweep_survives_its_jobs(sweep: Callable[..., tuple[int, list[int]]], tmp_path: Path) -> None:
    told = tmp_path / "outputs" / "sweep=batch" / "sweep.parquet"
    assert sweep("10,9,11", _9=StartError("no room"), _10=LookupError("a mistake")) == (BAD_START, [10, 9, 11])
    rows = pq.read_table(told).to_pylist()
    assert [(row["batch"], row["status"]) for row in rows] == [(9, "refused"), (10, "failed"), (11, "clean")]
    assert [row["message"] for row in rows] == ["no room", "LookupError: a mistake", ""]
    assert [row["shapes"] for row in rows] == [None, None, SHAPES] and rows[0]["folder"] is None
    # Run again once what was wrong is mended, it is whole; the order of the jobs is no part of it.
    assert sweep("10,9,11")[0] == CLEAN
    whole = told.read_bytes()
    assert sweep("11,9,10")[0] == CLEAN and told.read_bytes() == whole
    assert [row["status"] for row in pq.read_table(told).to_pylist()] == ["clean"] * 3
    assert not list(told.parent.glob(".tmp-*"))


def test_a_job_that_breaks_off_is_in_the_exit_code(sweep: Callable[..., tuple[int, list[int]]]) -> None:
    assert sweep("1,2", _1=LookupError("a mistake")) == (FAILED, [1, 2])


@pytest.mark.system
def test_an_interrupt_ends_the_whole_sweep(sweep: Callable[..., tuple[int, list[int]]], tmp_path: Path) -> None:
    assert sweep("1,2,3", _2=KeyboardInterrupt()) == (INTERRUPTED, [1, 2])
    assert not (tmp_path / "outputs" / "sweep=batch").exists()
    assert sweep("1,2,3") == (CLEAN, [1, 2, 3])


@pytest.mark.system
def test_logs_of_two_sweeps_at_once_stay_apart(sweep: Callable[..., tuple[int, list[int]]], tmp_path: Path) -> None:
    for _ in range(3):
        sweep("1,2")
    logs = list((tmp_path / "outputs" / ".hydra").iterdir())
    assert len(logs) == 3 and all({"0", "1"} <= {path.name for path in log.iterdir()} for log in logs)
