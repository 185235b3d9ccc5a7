"""`riot match`: the partners of a new shape in a finished run are those of scoring it with every shape of the run."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import manifold3d
import numpy as np
import pytest
import trimesh
from PIL import Image, ImageDraw
from small_runs import CLEAN, QUICK, SHAPES, WITH_ERRORS, draw, pictures, run, run_here, table

from pipeline.cli.main import main
from pipeline.match.search import open_mined
from pipeline.match.slices import shortlists
from riot.geometry.silhouette import read
from riot.parameters import TrunkParameters
from riot.scores.qcrs import brute_force
from riot.scores.trunk_stack import stack
from riot.scores.trunks import quick_trunks

FOUND, NOTHING, BAD = 0, 1, 2
SETTINGS = TrunkParameters(min_area=0.05)
"""Not the default: a run's own parameters must count."""


@pytest.fixture(scope="module")
def mined(tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = tmp_path_factory.mktemp("mined")
    root = pictures(where / "pictures")
    (root / "bad.png").write_bytes(b"no picture")
    assert "trunks.min_area=0.05" not in QUICK
    assert run_here(where, root, f"trunks.min_area={SETTINGS.min_area}", "cluster=sync").returncode == WITH_ERRORS
    return where


@pytest.fixture
def copy(mined: Path, tmp_path: Path) -> Path:
    """A run that may be spoilt: its record still names the store of the one that it is a copy of."""
    shutil.copytree(mined, tmp_path / "copy")
    return tmp_path / "copy"


def matched(capsys: pytest.CaptureFixture[str], where: Path, picture: Path, *more: str) -> tuple[int, str, str]:
    code = main(["match", str(picture), "--in", str(where / "outputs" / "folder"), *more])
    printed = capsys.readouterr()
    return code, printed.out, printed.err


def refused(capsys: pytest.CaptureFixture[str], where: Path, picture: Path, *more: str) -> str:
    code, out, err = matched(capsys, where, picture, *more)
    assert (code, out) == (BAD, "")
    return err


def plain(where: Path, picture: Path) -> list[tuple[object, ...]]:
    """Score the picture with every shape of the run by trying everything, and sort."""
    shapes = table(where, "shapes")
    every = stack([quick_trunks(read(where / "pictures" / f"{row['name']}.png"), SETTINGS) for row in shapes])
    scores = brute_force(stack([quick_trunks(read(picture), SETTINGS)]), every)
    columns = (scores.j, scores.score, scores.n, scores.trunk_i, scores.trunk_j, scores.shift)
    order = np.lexsort((scores.j, -scores.score))
    names = [shapes[j]["name"] for j in scores.j[order]]
    rows = list(zip(names, *(column[order].tolist() for column in columns), strict=True))
    return [row for row in rows if row[2] > 0 and row[0] != picture.stem]


def partners(out: str) -> list[tuple[object, ...]]:
    names = ("name", "shape", "qcrs", "n", "trunk", "partner_trunk", "shift")
    return [tuple(row[name] for name in names) for row in json.loads(out)["partners"]]


@pytest.mark.parametrize("number", [20, 21, 24])
def test_partners_are_those_of_scoring_all(
    mined: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], number: int
) -> None:
    draw(tmp_path / "new.png", number)
    code, out, _ = matched(capsys, mined, tmp_path / "new.png", "--json", "--top", "99")
    expected = plain(mined, tmp_path / "new.png")
    assert code == FOUND
    assert len(expected) > 5
    assert partners(out) == expected
    code, out, _ = matched(capsys, mined, tmp_path / "new.png", "--json", "--top", "3")
    assert partners(out) == expected[:3]
    first = json.loads(out)["partners"][0]
    trunks = quick_trunks(read(tmp_path / "new.png"), SETTINGS)
    assert (first["rank"], first["class"]) == (1, first["name"].rpartition("-")[0])
    assert first["trunk_vertices"] == trunks.of(first["trunk"]).tolist()


def test_a_shape_of_the_collection_is_not_its_own_partner(mined: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = mined / "pictures" / "kind1-1.png"
    code, out, err = matched(capsys, mined, picture, "--json", "--top", "99")
    assert code == FOUND
    assert "as kind1-1, and is left out" in err
    assert json.loads(out)["query"]["itself"] == "kind1-1"
    assert partners(out) == plain(mined, picture)


def test_the_table_and_the_timings(mined: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    draw(tmp_path / "new.png", 21)
    code, out, err = matched(capsys, mined, tmp_path / "new.png", "--top", "2", "--timings")
    assert code == FOUND
    best = plain(mined, tmp_path / "new.png")
    lines = [line for line in out.splitlines() if "kind" in line]
    assert len(lines) == 2
    assert [
        str(name) in line and f"{score:.4f}" in line for line, (name, _, score, *_) in zip(lines, best, strict=False)
    ]
    assert f"{SHAPES} shapes of folder" in out
    for step in ("index loaded", "shape read, trunks found", "searched"):
        assert f"ms  {step}" in err


def test_the_index_is_saved_and_a_damaged_one_built_again(
    copy: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    draw(tmp_path / "new.png", 22)
    more = ("--json", "--top", "99", "--store", str(copy / "store"))
    shutil.rmtree(copy / "store" / "index", ignore_errors=True)
    _, first, err = matched(capsys, copy, tmp_path / "new.png", *more)
    assert "building the index" in err
    _, second, err = matched(capsys, copy, tmp_path / "new.png", *more)
    assert (second, err) == (first, "")
    payload = max((copy / "store" / "index").rglob("payload.bin"), key=lambda path: path.stat().st_size)
    payload.write_bytes(payload.read_bytes()[:-1] + b"\xff")
    _, third, err = matched(capsys, copy, tmp_path / "new.png", *more)
    assert third == first
    assert "building the index" in err
    _, fourth, err = matched(capsys, copy, tmp_path / "new.png", *more)
    assert (fourth, err) == (first, "")


def test_a_shape_without_trunks_has_no_partners(
    mined: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    image = Image.new("L", (200, 200), 0)
    ImageDraw.Draw(image).arc((10, 10, 190, 190), 20, 340, 255, 6)
    image.save(tmp_path / "thin.png")
    code, out, err = matched(capsys, mined, tmp_path / "thin.png")
    assert (code, out) == (NOTHING, "")
    assert "thin has no trunk" in err
    code, out, _ = matched(capsys, mined, tmp_path / "thin.png", "--json")
    assert (code, json.loads(out)["partners"]) == (NOTHING, [])


def test_what_is_no_picture_is_refused(mined: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "bad.png" in refused(capsys, mined, mined / "pictures" / "bad.png")
    assert "absent.png: No such file" in refused(capsys, mined, tmp_path / "absent.png")
    assert main(["match", "a.png", "--in", str(mined), "--top", "0"]) == BAD
    assert "'0' is not a whole number above 0" in capsys.readouterr().err


def test_what_is_no_finished_run_is_refused(copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture, run_folder = copy / "pictures" / "kind1-1.png", copy / "outputs" / "folder"
    assert main(["match", str(picture), "--in", str(copy / "absent")]) == BAD
    assert "does not exist" in capsys.readouterr().err
    assert main(["match", str(picture), "--in", str(copy / "outputs")]) == BAD
    assert f"one of {run_folder}" in capsys.readouterr().err
    record = (run_folder / "run.json").read_text()
    (run_folder / "run.json").write_text(record[:-9])
    assert "damaged" in refused(capsys, copy, picture)
    (run_folder / "run.json").unlink()
    assert "no finished run" in refused(capsys, copy, picture)


def test_a_run_mined_otherwise_than_here_is_refused(copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture, file = copy / "pictures" / "kind1-1.png", copy / "outputs" / "folder" / "run.json"
    record = json.loads(file.read_text())
    spacing = record["configuration"]["shape"]["spacing"]
    record["configuration"]["shape"]["spacing"] = spacing + 1
    file.write_text(json.dumps(record))
    assert f"shape.spacing {spacing!r} → {spacing + 1!r}" in refused(capsys, copy, picture)
    record["configuration"]["shape"]["unheard_of"] = 1
    file.write_text(json.dumps(record))
    assert "another version" in refused(capsys, copy, picture)


def test_a_store_that_is_gone_or_altered_is_refused(copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture, store = copy / "pictures" / "kind1-1.png", copy / "store"
    options = ("--store", str(store))
    shutil.rmtree(store / "index", ignore_errors=True)
    payload = max((store / "trunks").rglob("payload.bin"), key=lambda path: path.stat().st_size)  # read by any search
    payload.write_bytes(payload.read_bytes()[:-1] + b"\xff")
    assert "gone or altered" in refused(capsys, copy, picture, *options)
    shutil.rmtree(payload.parent)
    assert "is gone; give --store LOCATION" in refused(capsys, copy, picture, *options)
    shutil.rmtree(store)
    assert f"{store}: the store of" in refused(capsys, copy, picture, *options)
    (copy / "outputs" / "folder" / "shapes.parquet").write_bytes(b"")
    assert "shapes.parquet: altered" in refused(capsys, copy, picture)


def test_the_store_is_found_from_anywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    root = pictures(tmp_path / "pictures", range(3))
    done = run(tmp_path, root, "store=beside", "cluster=sync")  # relative to where the run was started
    assert done.returncode == CLEAN
    monkeypatch.chdir(tmp_path / "pictures")
    assert matched(capsys, tmp_path, root / "kind1-1.png")[0] in (FOUND, NOTHING)


def test_slices_look_for_the_same_partners(mined: Path, tmp_path: Path) -> None:
    draw(tmp_path / "new.png", 20)
    opened = open_mined(mined / "outputs" / "folder")
    lists = shortlists(opened, [read(tmp_path / "new.png"), read(tmp_path / "new.png")], 3, print)
    expected = [(name, score) for name, _, score, *_ in plain(mined, tmp_path / "new.png")[:3]]
    assert [[(candidate.shape.name, candidate.qcrs) for candidate in candidates] for candidates in lists] == [
        expected,
        expected,
    ]
    for candidate in lists[0]:
        again = read(mined / "pictures" / f"{candidate.shape.name}.png", opened.config.shape)
        assert np.array_equal(candidate.shape.points, again.points)


def test_slices_become_shapes_of_a_run(mined: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    solid = manifold3d.Manifold.cylinder(40.0, 45.0, 36.0, 40).scale((1.3, 1.0, 1.0)).to_mesh64()
    trimesh.Trimesh(solid.vert_properties[:, :3], solid.tri_verts.astype(np.int64)).export(tmp_path / "bowl.stl")
    arguments = ["slices", str(tmp_path / "bowl.stl"), "--count", "2", "--thickness", "20", "-o", str(tmp_path / "set")]
    assert main([*arguments, "--in", str(mined / "outputs" / "folder"), "--candidates", "2"]) == FOUND
    document = json.loads((tmp_path / "set" / "set.json").read_text(encoding="utf-8"))
    names = {row["name"] for row in table(mined, "shapes")}
    assert all(entry["certified"] and entry["counterpart"] in names for entry in document["slices"])
    assert main([*arguments[:-1], str(tmp_path / "other")]) == BAD
    assert "either as files (--into A.png,B.png) or as a run (--in RUN)" in capsys.readouterr().err
    assert main([*arguments[:-1], str(tmp_path / "other"), "--in", str(tmp_path)]) == BAD
    assert "no finished run" in capsys.readouterr().err
