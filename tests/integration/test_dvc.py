"""DVC over the pipeline: a real `dvc repro` in a fresh clone, a second that does nothing, metrics and plots."""

from __future__ import annotations

import csv
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.exit_codes import BAD_START
from pipeline.plan.sources import ROOT
from pipeline.tables.measures import main

CLONED = ("conf", "pipeline", "riot", "dvc.yaml", "params.yaml", ".dvc", ".dvcignore", ".gitignore")
TOP = 1


def dvc(clone: Path, *arguments: str) -> str:
    # `python` in dvc.yaml is the one that is looked up first, as after activating the environment.
    environment = {**os.environ, "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])}
    line = [sys.executable, "-m", "dvc", *arguments]
    done = subprocess.run(line, cwd=clone, env=environment, capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def clone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The project as it is here, with a smaller task, after a first `dvc repro`."""
    pytest.importorskip("dvc")
    folder = tmp_path_factory.mktemp("clone")
    for name in CLONED:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy2
        copy(ROOT / name, folder / name)  # with compiled kernels, which .dvcignore leaves out
    subprocess.run(["git", "init", "--quiet"], cwd=folder, check=True)
    parameters = (folder / "params.yaml").read_text()
    for usual, small in (("limit: 96", "limit: 6"), ("top: 24", f"top: {TOP}"), ("cluster: local", "cluster: sync")):
        assert usual in parameters
        parameters = parameters.replace(usual, small)
    (folder / "params.yaml").write_text(parameters)
    said = dvc(folder, "repro")
    assert "Running stage 'mine'" in said and "Running stage 'measure'" in said
    return folder


@pytest.mark.system
def test_a_second_repro_does_nothing(clone: Path) -> None:
    record = clone / "outputs" / "mined" / "run.json"
    before = record.stat().st_mtime_ns
    said = dvc(clone, "repro")
    assert "Running stage" not in said and "up to date" in said
    assert record.stat().st_mtime_ns == before


@pytest.mark.system
def test_metrics_and_plots_are_those_of_the_run(clone: Path) -> None:
    shown = json.loads(dvc(clone, "metrics", "show", "--json"))
    (found,) = (file["data"] for place in shown.values() for file in place["data"].values())
    assert found["shapes"] == 6 and found["certified"] + found["rejected"] == TOP
    record = json.loads((clone / "outputs" / "mined" / "run.json").read_text())
    assert record["counts"].items() <= found.items()
    with (clone / "outputs" / "measures" / "deformation.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == found["certified"]
    if rows:
        assert max(float(row["iou"]) for row in rows) == found["iou_max"]
    page = dvc(clone, "plots", "show").strip().removeprefix("file://")
    assert "Time of the stages" in Path(page).read_text()


def test_measures_need_a_finished_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(tmp_path), "-o", str(tmp_path / "measures")]) == BAD_START
    assert "no finished run" in capsys.readouterr().err and not (tmp_path / "measures" / "measures.json").exists()
