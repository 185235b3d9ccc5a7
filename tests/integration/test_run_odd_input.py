"""Input that is bad, odd or missing: rows of the errors, words for the user, and exit codes."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from PIL import Image, ImageDraw
from small_runs import (
    BAD_START,
    CLEAN,
    SHAPES,
    WITH_ERRORS,
    draw,
    pictures,
    run_here,
    table,
)

from pipeline.run import main


def test_bad_pictures_are_rows_and_the_run_goes_on(root: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(root, tmp_path / "pictures"))
    (folder / "text-1.png").write_text("this is no picture")
    whole = (folder / "kind0-0.png").read_bytes()
    (folder / "cut-1.png").write_bytes(whole[: len(whole) // 2])
    Image.new("L", (40, 40), 255).save(folder / "plain-1.png")
    Image.new("L", (1, 1), 0).save(folder / "dot-1.png")
    (folder / "twin-1.png").write_bytes(whole)
    draw(folder / "mit Leerzeichen é-1.png", 55)
    (folder / "notes.txt").write_text("no item")
    (folder / "blank-1.png").touch()
    Image.fromarray(np.array([[0, 255, 255, 0]] * 2, dtype=np.uint8)).save(folder / "border-1.png")
    (folder / "gone-1.png").symlink_to(folder / "nothing.png")
    done = run_here(tmp_path, folder, "cluster=sync")
    assert done.returncode == WITH_ERRORS, done.stdout + done.stderr
    errors = {row["item"]: row for row in table(tmp_path, "errors")}
    reasons = {"text-1": "not-a-picture", "cut-1": "unreadable", "plain-1": "one-colour", "dot-1": "one-colour"}
    reasons |= {"twin-1": "duplicate", "blank-1": "not-a-picture", "border-1": "all-border", "gone-1": "unreadable"}
    assert {name: row["reason"] for name, row in errors.items()} == reasons
    assert all(row["message"] and row["attempts"] == 1 for row in errors.values())
    assert "Finished with 7 errors" in done.stdout and "1 file is left out" in done.stdout
    assert "1 file was ignored" in done.stdout
    assert not any(str(tmp_path) in str(row["message"]) for row in errors.values())
    names = {row["name"]: row["source"] for row in table(tmp_path, "shapes")}
    assert len(names) == SHAPES + 1 and names["mit Leerzeichen é-1"] == "mit Leerzeichen é-1.png"
    qcrs = pq.read_table(tmp_path / "outputs" / "folder" / "qcrs")
    assert len(qcrs) == (SHAPES + 1) * SHAPES // 2
    again = run_here(tmp_path, folder, "cluster=sync")
    assert again.returncode == WITH_ERRORS and "nothing was computed" in again.stdout


def test_odd_shapes_are_shapes_and_those_without_trunks_are_counted(root: Path, tmp_path: Path) -> None:
    folder = pictures(tmp_path / "pictures", range(2))
    needle = np.zeros((40, 1000), dtype=np.uint8)
    needle[19:21, 20:980] = 255
    Image.fromarray(needle).save(folder / "needle-1.png")
    blobs = Image.new("L", (120, 80))
    for box in ((5, 5, 50, 50), (60, 20, 110, 70)):
        ImageDraw.Draw(blobs).ellipse(box, fill=255)
    blobs.save(folder / "blobs-1.png")
    turn = np.linspace(0.0, 6 * np.pi, 2000)
    reach = 10 + 8 * turn
    spiral = Image.new("L", (400, 400))
    ImageDraw.Draw(spiral).line(
        [(200 + x, 200 + y) for x, y in zip(reach * np.cos(turn), reach * np.sin(turn), strict=True)], 255, width=12
    )
    spiral.save(folder / "spiral-1.png")
    done = run_here(tmp_path, folder, "cluster=sync")
    assert done.returncode == CLEAN, done.stdout + done.stderr
    trunks = {str(row["name"]): row["trunks"] for row in table(tmp_path, "shapes")}
    assert trunks.keys() == {"blobs-1", "kind0-0", "kind1-1", "needle-1", "spiral-1"}
    without = [name for name, count in trunks.items() if count == 0]
    assert "needle-1" in without and "kind0-0" not in without
    sentence = f"{len(without)} shape" + (" has" if len(without) == 1 else "s have") + " no trunk"
    assert sentence in done.stdout and sentence in (tmp_path / "outputs" / "folder" / "report.html").read_text()
    qcrs = pq.read_table(tmp_path / "outputs" / "folder" / "qcrs").to_pylist()
    needle_number = sorted(trunks).index("needle-1")
    lonely = [row for row in qcrs if needle_number in (row["i"], row["j"])]
    assert len(lonely) == len(trunks) - 1 and all(row["score"] == 0 and row["n"] == 0 for row in lonely)


def test_shapes_of_one_class_make_no_pair_and_that_is_said(tmp_path: Path) -> None:
    folder = tmp_path / "pictures" / "all"
    folder.mkdir(parents=True)
    for number in range(3):
        draw(folder / f"{number}.png", number)
    for policy in ("global", "paper"):
        done = run_here(tmp_path, folder.parent, "cluster=sync", f"select.policy={policy}")
        assert done.returncode == CLEAN, done.stdout + done.stderr
        assert f"No pair was selected: select.policy={policy}" in done.stdout
    assert table(tmp_path, "transforms") == []


def test_a_collection_without_one_shape_still_ends_well(tmp_path: Path) -> None:
    folder = tmp_path / "pictures"
    folder.mkdir()
    (folder / "text-1.png").write_text("this is no picture")
    done = run_here(tmp_path, folder, "cluster=sync")
    assert done.returncode == WITH_ERRORS, done.stdout + done.stderr
    assert table(tmp_path, "shapes") == [] and len(table(tmp_path, "errors")) == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["+dataset=folder", "dataset.root={empty}"], ["no pictures", "dataset.root"]),
        (["+dataset=folder", "dataset.root={empty}/none"], ["does not exist"]),
        (["+dataset=mpeg7", "dataset.root={empty}/none"], ["pipeline.fetch mpeg7"]),
        (["trunks.tau=1"], ["trunks.tau_s", "Allowed"]),
        (["trunks.tau_s=x"], ["number"]),
        (["outputs={file}"], ["cannot write", "outputs=DIR"]),
        (["outputs={file}/deeper"], ["cannot write", "outputs=DIR"]),
        (["store={file}"], ["cannot write", "store=DIR"]),
        (["outputs={file}/deeper", "-m", "select.top=1,2"], ["cannot write", "outputs=DIR"]),
        (["-m", "select.top=1,x"], ["select.top", "whole number"]),
        (["dataset.root={empty}"], ["+dataset=folder"]),
    ],
)
def test_what_cannot_start_says_why_and_does_nothing(
    arguments: list[str],
    words: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    empty, file, where = tmp_path / "empty", tmp_path / "file", tmp_path / "where"
    empty.mkdir()
    file.touch()
    where.mkdir()
    monkeypatch.chdir(where)
    assert main([argument.format(empty=empty, file=file) for argument in arguments]) == BAD_START
    complaint = capsys.readouterr().err
    assert all(word in complaint for word in words) and "Traceback" not in complaint
    assert not (where / "store").exists() or not list((where / "store").rglob("*.bin"))


def test_identical_files_alone_are_no_error(copied: Path, root: Path, tmp_path: Path) -> None:
    folder = tmp_path / "with a copy"
    shutil.copytree(root, folder)
    first = min(folder.glob("*.png"))
    shutil.copy(first, folder / f"{first.stem}~copy.png")
    done = run_here(copied, folder, "cluster=sync")
    assert done.returncode == CLEAN, done.stdout + done.stderr
    assert "1 file is left out: the same bytes as another" in done.stdout
