"""What crashes its process, a picture or a pair: a row of the errors, and otherwise the run without it, to the byte."""

from __future__ import annotations

import math
import os
import subprocess
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest
from small_runs import CLEAN, WITH_ERRORS, command, digests, draw, pictures, run, stages, table

from riot import Transform

POISON = """
import ctypes, dataclasses, importlib, signal
from itertools import product
from PIL import Image

opened, load = Image.open, importlib.import_module
crashing, hanging = {crashing}, {hanging}  # areas of the first trunk of either shape, by which the work knows them

def open_or_crash(path, *arguments, **options):
    if "poison" in str(path):
        ctypes.string_at(0)
    return opened(path, *arguments, **options)

def areas(stack):
    return [float(stack.areas[start]) for start in stack.starts[:-1]]

def load_poisoned(name, *arguments):
    module = load(name, *arguments)
    if name == "pipeline.stages.qcrs" and not hasattr(module, "harmless"):
        module.harmless = module.run

        def run(inputs, parameters, spec):
            first, second = areas(inputs[0]), areas(inputs[-1])
            part = hasattr(spec, "pairs")
            pairs = spec.pairs() if part else product(range(len(first)), range(len(second)))
            found = [{{first[i], second[j]}} for i, j in pairs]
            if crashing in found:
                ctypes.string_at(0)
            if hanging in found:
                if signal.getitimer(signal.ITIMER_REAL)[0] > 0:  # there is a limit: most of it is over
                    signal.setitimer(signal.ITIMER_REAL, 0.1)
                ctypes.PyDLL(None).usleep(200_000_000)  # in C, with the interpreter locked, as a kernel does
            return module.harmless(inputs, parameters, spec)

        module.STAGE = dataclasses.replace(module.STAGE, run=run)
    return module

Image.open, importlib.import_module = open_or_crash, load_poisoned
"""
"""Run by every Python process that finds it as ``sitecustomize``."""

BATCHES = "batch=2"
"""Small ones: every halving of a block that crashes starts two processes."""


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = tmp_path_factory.mktemp("clean")
    done = run(where, pictures(where / "pictures", range(7)), BATCHES, "cluster=sync")
    assert done.returncode == CLEAN, done.stdout + done.stderr
    return where


@pytest.mark.system
def test_what_is_deadly_is_lost_alone(clean: Path, tmp_path: Path) -> None:
    """A picture and a pair that crash, and a pair that hangs; the pairs are of one class, which is never selected."""

    def areas(*names: str) -> set[object]:
        shapes = {row["shape"] for row in table(clean, "shapes") if row["name"] in names}
        return {row["area"] for row in table(clean, "trunks") if row["trunk"] == 0 and row["shape"] in shapes}

    root = pictures(tmp_path / "pictures", range(7))
    draw(root / "kind1-poison-1.png", 77)
    (tmp_path / "poison").mkdir()
    poison = POISON.format(crashing=areas("kind1-1", "kind1-5"), hanging=areas("kind0-0", "kind0-4"))
    (tmp_path / "poison" / "sitecustomize.py").write_text(poison)
    paths = filter(None, [os.environ.get("PYTHONPATH")])
    done = subprocess.run(
        command(tmp_path, root, BATCHES, "cluster=local", "cluster.workers=1"),
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path / "poison"), *paths])},
        timeout=240,
    )
    assert done.returncode == WITH_ERRORS, done.stdout + done.stderr
    errors = {row["item"]: row for row in table(tmp_path, "errors")}
    columns = ("stage", "type", "reason", "attempts")
    assert {name: tuple(row[column] for column in columns) for name, row in errors.items()} == {
        "kind1-poison-1": ("ingest", "ProcessLost", "quarantined", 2),
        "kind1-1 × kind1-5": ("qcrs", "ProcessLost", "quarantined", 2),
        "kind0-0 × kind0-4": ("qcrs", "TimeLimit", "time-limit", 1),
    }
    words = {name: str(row["message"]) for name, row in errors.items()}
    assert "SIGSEGV" in words["kind1-poison-1"] and "SIGSEGV" in words["kind1-1 × kind1-5"]
    assert words["kind0-0 × kind0-4"].startswith("stopped after 600 s; raise cluster.limit")
    assert stages(tmp_path)["ingest"]["failed"] == 1 and "set aside" in done.stdout
    assert all(name in done.stdout for name in errors)
    got, expected = digests(tmp_path), digests(clean)
    assert got.keys() == expected.keys()
    differ = {name for name in got if got[name] != expected[name]}
    assert {name for name in differ if not name.startswith("qcrs/")} == {
        "artifacts.json",
        "check.html",
        "errors.parquet",
    }
    rows, wanted = scores(tmp_path), scores(clean)
    lost = [row for row in rows if row["n"] == -1]
    assert len(lost) == 2 and all(math.isnan(row["score"]) for row in lost)
    assert len([row for row in rows if row in wanted]) == len(rows) - len(lost) and len(rows) == len(wanted)


def scores(where: Path) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = pq.read_table(where / "outputs" / "folder" / "qcrs").to_pylist()
    return rows


def test_transforms_of_a_run_tell_their_history(finished: Path) -> None:
    shapes = {row["name"]: row["digest"] for row in table(finished, "shapes")}
    files = [row for row in table(finished, "transforms") if row["file"]]
    assert files
    for row in files:
        history = Transform.load(finished / "outputs" / "folder" / str(row["file"])).history
        assert history is not None and history.maker == "pipeline.run"
        assert history.pictures == (shapes[row["name_i"]], shapes[row["name_j"]])
        names = [step.name for step in history.steps]
        assert names[:5] == ["ingest", "trunks_full", "crs", "refine", "construct"]
        assert {"numpy", "numba", "shapely"} <= history.versions.keys()
        for step in history.steps:
            for key in step.keys:
                # The key of a single shape names no artifact: batches hold shapes.
                folder = finished / "store" / step.name / key[:2] / key
                assert len(key) == 64 and (folder.is_dir() or step.name == "ingest")
