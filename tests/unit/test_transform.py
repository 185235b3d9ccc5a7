"""Transform, poses, certificate, the .riot file and the command line."""

from __future__ import annotations

import gc
import json
import math
import weakref
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely
from PIL import Image, ImageDraw

from riot import FormatError, Transform
from riot.cli.main import main
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.motion import motion_of
from riot.transform.certificate import certify
from riot.transform.deformation import boundary_distance, change_ratio, measure_deformation, overlap_ratio
from riot.transform.riot_file import from_json, to_json
from riot.transform.transform import Piece


@pytest.fixture(scope="module")
def transform() -> Transform:
    return exact_transform(exact_pair(5, 2))


def test_exact_pair_is_certified(transform: Transform) -> None:
    certificate = transform.certificate()
    assert certificate.passed
    assert certificate.failure == ""
    assert certificate.residual < 1e-12
    assert transform.deformation().iou == pytest.approx(1.0, abs=1e-9)
    assert transform.deformation().hausdorff_p < 1e-9


def test_poses_at_the_ends_are_the_shapes(transform: Transform) -> None:
    for t, outline in ((0.0, transform.outline_p()), (1.0, transform.outline_q())):
        union = shapely.union_all([shapely.Polygon(polygon) for polygon in transform.parts(transform.pose(t))])
        assert union.symmetric_difference(shapely.Polygon(outline)).area < 1e-9


@pytest.mark.parametrize("hinge", range(5))
def test_any_hinge_may_be_the_open_one(transform: Transform, hinge: int) -> None:
    for t, still in ((0.0, transform.pose(0.0)), (1.0, transform.pose(1.0))):
        pose = transform.pose(t, open_hinge=hinge)
        assert pose.origins == pytest.approx(still.origins, abs=1e-12)
        assert np.exp(1j * pose.headings) == pytest.approx(np.exp(1j * still.headings), abs=1e-12)
    # On the way all hinges but the open one hold.
    pose = transform.pose(0.4, open_hinge=hinge)
    for j in range(len(transform)):
        end = pose.place(j - 1, np.array([[transform.pieces[j - 1].length, 0.0]]))[0]
        apart = float(np.hypot(*(end - pose.origins[j])))
        assert (apart > 1e-3) if j == hinge else (apart < 1e-12)


def test_pieces_stay_rigid(transform: Transform) -> None:
    areas = [shapely.Polygon(piece.polygon).area for piece in transform.pieces]
    for t in (0.1, 0.5, 0.9):
        assert [shapely.Polygon(polygon).area for polygon in transform.parts(transform.pose(t))] == pytest.approx(
            areas, abs=1e-12
        )


def test_certificate_sees_a_wrong_piece(transform: Transform) -> None:
    fat = transform.pieces[0]
    bulged = Piece(fat.length, fat.lower * np.array([1.0, 1.02]), fat.upper)
    certificate = replace(transform, pieces=(bulged, *transform.pieces[1:])).certificate()
    assert not certificate.passed
    assert "Q: pieces" in certificate.failure
    assert "P:" not in certificate.failure.replace("Q:", "")


def test_certificate_sees_hinges_that_miss(transform: Transform) -> None:
    angles = transform.angles.copy()
    angles[1] += 1e-6
    certificate = replace(transform, angles=angles).certificate()
    assert not certificate.passed
    assert certificate.p.hinge > 1e-8
    assert "hinges" in certificate.failure


def test_certificate_sees_a_crossing_outline(transform: Transform) -> None:
    piece = transform.pieces[0]
    lower = np.concatenate([piece.lower[:1], piece.lower[1:-1][::-1], piece.lower[-1:]])
    certificate = replace(
        transform, pieces=(Piece(piece.length, lower, piece.upper), *transform.pieces[1:])
    ).certificate()
    assert not certificate.passed
    assert not certificate.p.simple
    # Its areas are numbers still: those of what is enclosed an odd number of times.
    assert np.isfinite([certificate.p.overlap, certificate.p.gap, certificate.q.overlap, certificate.q.gap]).all()
    assert certificate.residual > 1e-3


def test_a_crossing_that_encloses_nothing_costs_no_area_and_fails(transform: Transform) -> None:
    """A whisker, out and back along the outline's own line: the areas stay, the certificate does not."""
    piece = transform.pieces[0]
    middle = len(piece.lower) // 2
    root, tip = piece.lower[middle], piece.lower[middle] + 0.1 * (piece.lower[middle + 1] - piece.lower[middle])
    lower = np.concatenate([piece.lower[: middle + 1], [tip, root], piece.lower[middle + 1 :]])
    certificate = replace(
        transform, pieces=(Piece(piece.length, lower, piece.upper), *transform.pieces[1:])
    ).certificate()
    assert not certificate.passed and not certificate.p.simple
    assert certificate.residual < 1e-9


def test_change_is_compared_with_the_least() -> None:
    assert change_ratio(0.9, 0.9) == 1.0
    assert change_ratio(0.8, 0.9) == pytest.approx(2.0)
    assert change_ratio(1.0, 0.9) == 0.0
    assert math.isnan(change_ratio(0.99, 1.0)) and math.isnan(change_ratio(0.99, math.nan))


def test_comparison_of_shifted_squares() -> None:
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    moved = square + np.array([0.2, 0.0])
    far, mean = boundary_distance(moved, square)
    assert overlap_ratio(moved, square) == pytest.approx(0.8 / 1.2)
    assert far * 2.0 * math.sqrt(math.pi) == pytest.approx(0.2)
    assert 0.0 < mean < far


def test_file_reads_back_to_the_last_bit(transform: Transform, tmp_path: Path) -> None:
    path = tmp_path / "é 1.riot"
    transform.save(path)
    again = Transform.load(path)
    assert to_json(again) == path.read_text(encoding="utf-8") == to_json(transform)
    assert np.array_equal(again.outline_p(), transform.outline_p())
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("not json", "not JSON"),
        ("[1, 2]", "not a .riot file"),
        ("[" * 100_000, "not JSON"),
        ('{"format": "riot-transform", "version": 99}', "version 99"),
        ('{"format": "riot-transform", "version": 1}', "damaged"),
    ],
)
def test_other_files_are_refused(text: str, words: str) -> None:
    with pytest.raises(FormatError, match=words):
        from_json(text)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("pieces", 0, "lower", 0), [1.0]),
        (("pieces", 0, "lower"), [[0.0, 0.0], [5.0, 5.0]]),
        (("pieces", 0, "length"), math.nan),
        (("pieces", 0, "length"), -1.0),
        (("angles", 0), math.nan),
        (("place_q", 1), math.inf),
        (("p", "points", 0), [100.0, 100.0]),
        (("p", "feature"), [99999]),
        (("pieces",), 5),
    ],
)
def test_damaged_numbers_are_refused(transform: Transform, path: tuple[str | int, ...], value: object) -> None:
    document = json.loads(to_json(transform))
    container = document
    for key in path[:-1]:
        container = container[key]
    container[path[-1]] = value
    with pytest.raises(FormatError, match="damaged"):
        from_json(json.dumps(document))


def test_saving_where_it_cannot_leaves_nothing(transform: Transform, tmp_path: Path) -> None:
    target = tmp_path / "folder.riot"
    (target / "inner").mkdir(parents=True)
    with pytest.raises(OSError, match=r"folder\.riot"):
        transform.save(target)
    assert [path.name for path in tmp_path.iterdir()] == ["folder.riot"]
    with pytest.raises(FileNotFoundError, match=r"made\.riot"):
        transform.save(tmp_path / "missing" / "made.riot")


def draw(path: Path, points: list[tuple[float, float]]) -> Path:
    picture = Image.new("L", (240, 240), 255)
    ImageDraw.Draw(picture).polygon(points, fill=0)
    picture.save(path)
    return path


MADE = (".riot", ".svg", ".png", ".strip.svg", ".strip.png", ".swing.svg")


def test_make_writes_transform_and_pictures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    house = draw(tmp_path / "house.png", [(40, 210), (40, 110), (120, 30), (200, 110), (200, 210)])
    kite = draw(tmp_path / "kite.png", [(120, 20), (210, 110), (120, 225), (40, 110)])
    assert main(["make", str(house), str(kite), "-o", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    assert "certificate: passed" in printed
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names == sorted(f"house--kite{suffix}" for suffix in MADE)
    transform = Transform.load(tmp_path / "out" / "house--kite.riot")
    assert transform.certificate().passed
    assert transform.plan is not None
    words = f"motion: {transform.plan.words}"
    assert words in printed
    assert main(["show", str(tmp_path / "out" / "house--kite.riot")]) == 0
    shown = capsys.readouterr().out
    assert words in shown
    (change,) = (line for line in shown.splitlines() if "change / least change" in line)
    deformation = transform.deformation()
    assert f"{change_ratio(deformation.iou_p, transform.bound_p):.3f}" in change
    assert "bending / input's" in shown and "directions off, degrees" in shown


def test_make_says_that_a_likeness_is_poor_and_keeps_the_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    house = draw(tmp_path / "house.png", [(40, 210), (40, 110), (120, 30), (200, 110), (200, 210)])
    kite = draw(tmp_path / "kite.png", [(120, 20), (210, 110), (120, 225), (40, 110)])
    make = ["make", str(house), str(kite), "-o", str(tmp_path / "out")]
    assert main([*make, "--min-iou", "0.9999"]) == 4
    complaint = capsys.readouterr().err
    transform = Transform.load(tmp_path / "out" / "house--kite.riot")
    assert f"{transform.overlap_ratios[0]:.2f} with house" in complaint and "riot match" in complaint
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(f"house--kite{end}" for end in MADE)
    assert main(make) == 2
    assert "house--kite.png is there already, as are 5 more" in (complaint := capsys.readouterr().err)
    assert "replace them (--force)" in complaint
    assert main([*make, "--force"]) == 0
    capsys.readouterr()
    assert main([*make, "--min-iou", "1.5"]) == 2
    assert "'1.5' is not a number from 0 to 1" in capsys.readouterr().err


def test_commands_tell_what_is_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = tmp_path / "text.png"
    text.write_text("no picture")
    square = draw(tmp_path / "square.png", [(40, 40), (200, 40), (200, 200), (40, 200)])
    out = str(tmp_path / "out")
    for arguments, words in (
        (["make", str(text), str(square), "-o", out], "text.png"),
        (["make", str(square), str(tmp_path), "-o", out], "directory"),
        (["make", str(square), str(tmp_path / "missing.png"), "-o", out], "missing.png"),
        (["make", str(square), str(square), "-o", str(text)], "text.png: a file"),
        (["make", str(square), str(square), "-o", str(text / "sub")], "text.png"),
        (["show", str(tmp_path / "missing.riot")], "missing.riot"),
        (["show", str(tmp_path)], "directory"),
        (["show", str(square)], "not a .riot file"),
    ):
        assert main(arguments) == 2
        output = capsys.readouterr()
        assert words in output.err
        assert output.out == ""
    assert not Path(out).exists()


def test_a_certificate_is_computed_once_and_does_not_keep_its_transform_alive() -> None:
    transform = exact_transform(exact_pair(3, 1))
    assert certify(transform) is certify(transform)
    assert certify(transform) is not certify(replace(transform))
    watched = weakref.ref(transform)
    del transform
    gc.collect()
    assert watched() is None


def test_the_face_offers_the_class_of_the_data_with_methods() -> None:
    transform = exact_transform(exact_pair(3, 1))
    assert isinstance(transform, Transform)
    assert transform.certificate() is certify(transform)
    assert transform.deformation() == measure_deformation(transform)
    assert transform.motion() is motion_of(transform)
    assert transform.planned().plan is transform.motion()
