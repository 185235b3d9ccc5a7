"""A run that chooses: what is chosen comes first and alone has a motion, and wishes are heeded or refused."""

from __future__ import annotations

from pathlib import Path

import pyarrow.parquet as pq
import pytest
from small_runs import BAD_START, CLEAN, digests, pictures, run_here, stages, table

from pipeline.errors import StartError
from pipeline.study import recognition, variety
from pipeline.study.finished import StudiedRun

VARIED = ("cluster=sync", "select=varied", "select.top=2", "select.breadth=4", "select.pool=2", "select.min_iou=0.5")


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = tmp_path_factory.mktemp("varied")
    ended = run_here(where, pictures(where / "pictures"), *VARIED)
    assert ended.returncode == CLEAN, ended.stderr
    assert "constructed, 2 transforms certified" in ended.stdout
    return where


def test_the_chosen_come_first_and_alone_have_a_motion(finished: Path) -> None:
    rows = table(finished, "transforms")
    assert [row["chosen"] for row in rows[:3]] == [True, True, False]
    assert [row["rank"] for row in rows] == list(range(1, len(rows) + 1))
    assert [row["swings_flat"] is not None for row in rows] == [row["chosen"] for row in rows]
    assert stages(finished)["construct"]["computed"] <= 4 and stages(finished)["motion"]["computed"] == 2
    classes = {row[side] for row in rows[:2] for side in ("class_i", "class_j")}
    assert len(classes) == 4  # four kinds, all of them shown
    assert all(row["surprise"] > 0 for row in rows if row["file"])


def test_a_run_of_global_shares_the_scores_and_chooses_all(finished: Path) -> None:
    again = run_here(finished, finished / "pictures", "cluster=sync", "select=global", "dataset.name=all")
    assert again.returncode == CLEAN, again.stderr
    rows = pq.read_table(finished / "outputs" / "all" / "transforms.parquet").to_pylist()
    assert len(rows) == 3 and all(row["chosen"] for row in rows)


def test_a_run_without_classes_shows_different_shapes(finished: Path) -> None:
    plain = finished / "plain"
    for number, path in enumerate(sorted((finished / "pictures").iterdir())):
        plain.mkdir(exist_ok=True)
        (plain / f"{chr(ord('a') + number)}.png").write_bytes(path.read_bytes())
    assert run_here(finished, plain, *VARIED, "dataset.name=plain").returncode == CLEAN
    rows = pq.read_table(finished / "outputs" / "plain" / "transforms.parquet").to_pylist()
    first = [row for row in rows if row["chosen"]]
    assert len({row[side] for row in first for side in ("i", "j")}) == 4


def test_wishes_are_heeded(finished: Path) -> None:
    wishes = ("select.classes=kind1", "select.exclude=[kind2,kind3-3]", "select.flat=true", "select.pieces=3..5")
    ended = run_here(finished, finished / "pictures", *VARIED, *wishes, "dataset.name=wished")
    assert ended.returncode == CLEAN, ended.stderr
    rows = pq.read_table(finished / "outputs" / "wished" / "transforms.parquet").to_pylist()
    for row in rows:
        assert "kind1" in (row["class_i"], row["class_j"])
        assert not {"kind2", "kind3-3"} & {row["class_i"], row["class_j"], row["name_i"], row["name_j"]}
    assert all(row["swings_flat"] and 3 <= row["n"] <= 5 for row in rows if row["chosen"])


@pytest.mark.parametrize(
    ("wish", "words"),
    [
        ("select.classes=kind9", ["select.classes", "no class kind9", "did you mean kind"]),
        ("select.shapes=kind1-11", ["select.shapes", "no shape kind1-11", "did you mean kind1-1?"]),
        ("select.pieces=2", ["select.pieces", "3 or more"]),
    ],
)
def test_a_bad_wish_is_refused_before_any_work(finished: Path, wish: str, words: list[str]) -> None:
    before = digests(finished)
    ended = run_here(finished, finished / "pictures", *VARIED, wish)
    assert ended.returncode == BAD_START
    assert all(word in ended.stderr for word in words)
    assert digests(finished) == before


def test_studies_stand_runs_side_by_side(finished: Path) -> None:
    assert (
        run_here(finished, finished / "pictures", "cluster=sync", "select=global", "dataset.name=all").returncode
        == CLEAN
    )
    run, other = StudiedRun.open(finished / "outputs" / "folder"), str(finished / "outputs" / "all")
    shown = variety.study(run, variety.Parameters(others=(other,)), print).table.to_pylist()
    assert [(row["run"], row["first"]) for row in shown] == [("varied", 1), ("varied", 2)] + [
        ("global", k) for k in (1, 2, 3)
    ]
    assert shown[1]["classes"] == 4 and shown[1]["repeated"] == 0
    results = recognition.study(run, recognition.Parameters(top=1, others=(other,)), print).table.to_pylist()
    assert [row["run"] for row in results] == ["varied"] * 2 + ["global"] * 2
    assert all(row["recognised"] == (row["class"] == row["nearest_class"]) for row in results)
    assert all(row["name"] != row["nearest"] for row in results)
    with pytest.raises(StartError, match="no finished run"):
        variety.study(run, variety.Parameters(others=(str(finished),)), print)
