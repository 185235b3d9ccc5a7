"""Shapes that may have been read wrongly: told by commands, kept by the store, left out of the selection."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from arrow import ARROW, SIDE
from PIL import Image

from pipeline.config.build import make_config
from pipeline.config.selection import SelectConfig
from pipeline.stages.all import BY_NAME
from pipeline.stages.qualities import pack_qualities, qualities
from pipeline.stages.quality_columns import columns
from pipeline.stages.select import Selecting, run
from pipeline.stages.wishes import WishedShapes
from pipeline.store.artifact import Artifact
from riot.cli.main import main
from riot.geometry.pixels import pixels_shape
from riot.geometry.quality import REMARKS, ReadingQuality
from riot.parameters import ShapeParameters

COMMAND = (sys.executable, "-m", "pipeline.cli.main")
HALVES = np.zeros((SIDE, SIDE), dtype=bool)
HALVES[40:100, 40:100] = HALVES[100:160, 100:160] = True


def batch(*doubtful: bool) -> Artifact:
    shape = pixels_shape(ARROW, "arrow")
    return Artifact(
        pack_qualities([replace(shape, quality=ReadingQuality(kept=0.5 if of else 1.0)) for of in doubtful])
    )


def test_qualities_survive_the_store() -> None:
    shape = pixels_shape(ARROW, "arrow")
    known = ReadingQuality(0.5, 0.25, 3, 0.75, 2, 0.125, 0.0625, REMARKS[1:3])
    artifact = Artifact(pack_qualities([replace(shape, quality=known), None]))
    assert qualities(artifact)[0] == known
    assert artifact.arrays["quality_doubtful"].tolist() == [True, False]
    assert columns(artifact)["remarks"] == ["; ".join(REMARKS[1:3]), ""]
    assert columns(artifact)["covered"] == [0.25, None]


@pytest.mark.parametrize("policy", ["global", "paper", "varied"])
def test_doubtful_shapes_are_not_selected(policy: str) -> None:
    i, j = np.triu_indices(4, 1)
    pairs = {"i": i.astype(np.int32), "j": j.astype(np.int32), "n": np.full(6, 4, np.int8)}
    block = Artifact({**pairs, "score": np.linspace(1.0, 0.5, 6)})
    rated = Artifact({"score": np.ones(4)})
    settings = SelectConfig(policy=policy)  # type: ignore[arg-type]
    spec = Selecting(("a", "b", "c", "d"), (0,), ((0, 0),), (), (0,), False, WishedShapes((), ()))
    everything = run([block, rated], (settings, True, "keep"), spec).arrays["pairs"]
    read = batch(False, True, False, False)
    clear = run([block, rated, read], (settings, True, "drop"), replace(spec, read=(0,))).arrays["pairs"]
    assert (everything == 1).any()
    assert len(clear) == 3 and not (clear == 1).any()


def test_what_becomes_of_doubtful_shapes_changes_no_reading() -> None:
    ingest = BY_NAME["ingest"]
    drop, keep = (make_config({"dataset": {}, "shape": {"doubtful": choice}}) for choice in ("drop", "keep"))
    assert ingest.recipe(drop).parameters == ingest.recipe(keep).parameters == (ShapeParameters(),)
    assert BY_NAME["select"].recipe(drop).parameters != BY_NAME["select"].recipe(keep).parameters


def test_make_tells_a_doubtful_outline(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Image.fromarray(HALVES).save(tmp_path / "halves.png")
    Image.fromarray(ARROW).save(tmp_path / "arrow.png")
    inputs = (str(tmp_path / f"{name}.png") for name in ("halves", "arrow"))
    code = main(["make", *inputs, "-o", str(tmp_path / "out"), "--json", "--min-iou", "0"])
    printed = capsys.readouterr()
    assert code == 4
    assert "halves.png: the outline may be wrong: only 50% of the object is kept" in printed.err
    readings = json.loads(printed.out)["readings"]
    assert readings[0]["kept"] == 0.5 and readings[0]["doubts"] and not readings[1]["doubts"]
    assert (tmp_path / "out" / "halves--arrow.riot").exists()


@pytest.mark.parametrize("encoding", ["cp1252", "ascii"])
def test_output_that_is_not_utf8_costs_no_result(tmp_path: Path, encoding: str) -> None:
    stem = "é" * 100  # 200 bytes: twice it, no file system takes
    for name in (stem, f"{stem}2"):
        Image.fromarray(ARROW).save(tmp_path / f"{name}.png")
    finished = subprocess.run(
        [*COMMAND, "make", f"{stem}.png", f"{stem}2.png", "-o", "out", "--min-iou", "0"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONIOENCODING": encoding},
        capture_output=True,
        timeout=300,
        check=False,
    )
    assert finished.returncode == 0, finished.stderr
    assert b"<>" in finished.stdout
    assert any(path.suffix == ".riot" for path in (tmp_path / "out").iterdir())


def test_a_name_that_is_no_text_is_refused_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9.png")
    with Path(path).open("wb") as file:
        Image.fromarray(ARROW).save(file, "PNG")
    assert main(["make", path, path, "-o", str(tmp_path / "out")]) == 2
    assert "the name is no text (UTF-8); rename the file" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
