"""Small real runs of the pipeline, in processes of their own or in this one, for tests."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
from PIL import Image, ImageDraw

from pipeline.run import main

CLEAN, FAILED, BAD_START, WITH_ERRORS, INTERRUPTED = 0, 1, 2, 3, 130
QUICK = (
    *("batch=4", "select=global", "select.top=3", "refine.candidates=2", "select.per_shape=2", "select.breadth=2"),
    *("bend.starts=1", "bend.modes=8", "bend.sketched=2", "bend.sketch_steps=4", "bend.steps=8"),
)
TIMED = {"timings.parquet", "run.json", "report.html"}
"""Files that hold times, and so differ between equal runs."""

SHAPES = 10


def draw(path: Path, number: int) -> None:
    """A silhouette of its own for every number: a polygon of 4 to 8 corners at varied distances."""
    corners = 4 + number % 5
    rng = np.random.default_rng(number)
    turns = 2 * math.pi * (np.arange(corners) + 0.25 * rng.random(corners)) / corners
    reach = 34 + 14 * rng.random(corners)
    image = Image.new("L", (100, 100), 0)
    ImageDraw.Draw(image).polygon(
        [(50 + r * math.cos(t), 50 + r * math.sin(t)) for r, t in zip(reach, turns, strict=True)], 255
    )
    image.save(path)


def pictures(folder: Path, numbers: range = range(SHAPES)) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    for number in numbers:
        draw(folder / f"kind{number % 4}-{number}.png", number)
    return folder


def command(where: Path, root: Path | None, *more: str) -> list[str]:
    data = ["+dataset=folder", f"dataset.root={root}"] if root is not None else []
    return [
        sys.executable,
        "-m",
        "pipeline.run",
        *data,
        f"outputs={where / 'outputs'}",
        f"store={where / 'store'}",
        *QUICK,
        *more,
    ]


def run(where: Path, root: Path | None, *more: str) -> subprocess.CompletedProcess[str]:
    where.mkdir(parents=True, exist_ok=True)
    return subprocess.run(command(where, root, *more), capture_output=True, text=True, cwd=where, timeout=240)


def run_here(where: Path, root: Path | None, *more: str) -> subprocess.CompletedProcess[str]:
    """`run` in this process: the same command without its start, for ``cluster=sync``."""
    arguments = command(where, root, *more)[3:]
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as err:
        code = main(arguments)
    return subprocess.CompletedProcess(arguments, code, out.getvalue(), err.getvalue())


def digests(where: Path) -> dict[str, str]:
    folder = where / "outputs" / "folder"
    return {
        file.relative_to(folder).as_posix(): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in sorted(folder.rglob("*"))
        if file.is_file() and file.name not in TIMED
    }


def table(where: Path, name: str) -> list[dict[str, object]]:
    return pq.read_table(where / "outputs" / "folder" / f"{name}.parquet").to_pylist()


def stages(where: Path, point: str = "") -> dict[str, dict[str, int]]:
    record = json.loads((where / "outputs" / point / "folder" / "run.json").read_text())
    return {stage["stage"]: stage for stage in record["stages"]}
