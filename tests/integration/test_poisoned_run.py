"""What crashes its process, a picture or a pair: a row of the errors, and otherwise the run without it, to the byte."""

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

POISONED_PAIR = """
import ctypes, importlib
from itertools import product

load, deadly = importlib.import_module, {areas}

def areas(stack):
    return [float(stack.areas[start]) for start in stack.starts[:-1]]

def crash(name, *arguments):
    module = load(name, *arguments)
    if name == "pipeline.work.qcrs" and not hasattr(module, "harmless"):
        module.harmless = module.run

        def run(inputs, parameters, spec):
            first, second = areas(inputs[0]), areas(inputs[-1])
            part = hasattr(spec, "pairs")
            pairs = spec.pairs() if part else product(range(len(first)), range(len(second)))
            if any({{first[i], second[j]}} == deadly for i, j in pairs):
                ctypes.string_at(0)
            return module.harmless(inputs, parameters, spec)

        module.run = run
    return module

importlib.import_module = crash
"""
"""The same for two shapes, which are known by the area of the first trunk of each."""


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = tmp_path_factory.mktemp("clean")
    done = run(where, pictures(where / "pictures", range(7)), "cluster=sync")
    assert done.returncode == CLEAN, done.stdout + done.stderr
    return where


def poisoned(where: Path, root: Path, script: str) -> subprocess.CompletedProcess[str]:
    """A run on a worker, whose processes run the script first, that ends with errors."""
    (where / "poison").mkdir()
    (where / "poison" / "sitecustomize.py").write_text(script)
    found = filter(None, [os.environ.get("PYTHONPATH")])
    done = subprocess.run(
        command(where, root, "cluster=local", "cluster.workers=1"),
        capture_output=True,
        text=True,
        cwd=where,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(where / "poison"), *found])},
        timeout=240,
    )
    assert done.returncode == WITH_ERRORS, done.stdout + done.stderr
    return done


def test_neighbours_of_a_deadly_picture_are_mined_as_if_it_were_not_there(clean: Path, tmp_path: Path) -> None:
    root = pictures(tmp_path / "pictures", range(7))
    draw(root / "kind1-poison-1.png", 77)
    done = poisoned(tmp_path, root, POISON)
    (error,) = table(tmp_path, "errors")
    assert (error["item"], error["stage"], error["type"]) == ("kind1-poison-1", "ingest", "ProcessLost")
    assert (error["reason"], error["attempts"]) == ("quarantined", 2) and "SIGSEGV" in str(error["message"])
    assert stages(tmp_path)["ingest"]["failed"] == 1 and "set aside" in done.stdout
    got, expected = digests(tmp_path), digests(clean)
    assert got.keys() == expected.keys()
    assert {name for name in got if got[name] != expected[name]} == {"errors.parquet"}


def test_a_deadly_pair_is_lost_alone(clean: Path, tmp_path: Path) -> None:
    names = [row["name"] for row in table(clean, "shapes")]
    p, q = names.index("kind1-1"), names.index("kind1-5")  # of one class, which is never selected
    areas = {row["area"] for row in table(clean, "trunks") if row["trunk"] == 0 and row["shape"] in (p, q)}
    done = poisoned(tmp_path, pictures(tmp_path / "pictures", range(7)), POISONED_PAIR.format(areas=areas))
    (error,) = table(tmp_path, "errors")
    assert (error["item"], error["stage"], error["type"]) == ("kind1-1 × kind1-5", "qcrs", "ProcessLost")
    assert (error["reason"], error["attempts"]) == ("quarantined", 2) and "SIGSEGV" in str(error["message"])
    assert "set aside: kind1-1 × kind1-5" in done.stdout
    got, expected = digests(tmp_path), digests(clean)
    differ = {name for name in got if got[name] != expected[name]}
    assert got.keys() == expected.keys() and len(differ) == 3  # one part of the table of pairs has another row
    assert {name for name in differ if not name.startswith("qcrs/")} == {"artifacts.json", "errors.parquet"}


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
