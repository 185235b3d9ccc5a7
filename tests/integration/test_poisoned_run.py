"""A picture that crashes whatever decodes it: a row of the errors, and otherwise the run without it, to the byte."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest
from small_runs import CLEAN, WITH_ERRORS, command, digests, draw, pictures, run, stages, table

from riot.transform import Transform

POISON = """
import ctypes
from PIL import Image

opened = Image.open

def crash(path, *arguments, **options):
    if "poison" in str(path):
        ctypes.string_at(0)
    return opened(path, *arguments, **options)

Image.open = crash
"""
"""Run by every Python process that finds it as ``sitecustomize``."""


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = tmp_path_factory.mktemp("clean")
    done = run(where, pictures(where / "pictures", range(7)), "cluster=sync")
    assert done.returncode == CLEAN, done.stdout + done.stderr
    return where


def test_neighbours_of_a_deadly_picture_are_mined_as_if_it_were_not_there(clean: Path, tmp_path: Path) -> None:
    root = pictures(tmp_path / "pictures", range(7))
    draw(root / "kind1-poison-1.png", 77)
    (tmp_path / "poison").mkdir()
    (tmp_path / "poison" / "sitecustomize.py").write_text(POISON)
    found = filter(None, [os.environ.get("PYTHONPATH")])
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path / "poison"), *found])}
    done = subprocess.run(
        command(tmp_path, root, "cluster=local", "cluster.workers=1"),
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=environment,
        timeout=240,
    )
    assert done.returncode == WITH_ERRORS, done.stdout + done.stderr
    (error,) = table(tmp_path, "errors")
    assert (error["item"], error["stage"], error["type"]) == ("kind1-poison-1", "ingest", "ProcessLost")
    assert (error["reason"], error["attempts"]) == ("quarantined", 2) and "SIGSEGV" in str(error["message"])
    assert stages(tmp_path)["ingest"]["failed"] == 1 and "set aside" in done.stdout
    got, expected = digests(tmp_path), digests(clean)
    assert got.keys() == expected.keys()
    assert {name for name in got if got[name] != expected[name]} == {"errors.parquet"}


def test_transforms_of_a_run_tell_their_history(clean: Path) -> None:
    shapes = {row["name"]: row["digest"] for row in table(clean, "shapes")}
    files = [row for row in table(clean, "transforms") if row["file"]]
    assert files
    for row in files:
        history = Transform.load(clean / "outputs" / "folder" / str(row["file"])).history
        assert history is not None and history.maker == "pipeline.run"
        assert history.pictures == (shapes[row["name_i"]], shapes[row["name_j"]])
        names = [step.name for step in history.steps]
        assert names[:5] == ["ingest", "trunks_full", "crs", "refine", "construct"]
        assert {"numpy", "numba", "shapely"} <= history.versions.keys()
        for step in history.steps:
            for key in step.keys:
                # The key of a single shape names no artifact: batches hold shapes.
                folder = clean / "store" / step.name / key[:2] / key
                assert len(key) == 64 and (folder.is_dir() or step.name == "ingest")
