"""Q on the back: cut as its mirror image, and shown everywhere as the hand sees it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely
from PIL import Image, ImageDraw

from riot import Shape, Transform
from riot.cli.main import main
from riot.draw import draw_transform
from riot.draw.film_camera import Camera
from riot.draw.panels import dissection_marks
from riot.draw.scene import PlacedPiece, extent, mirrored, placed
from riot.draw.strip import strip_scene
from riot.fabricate import design
from riot.fabricate.export.picture import puzzle_view
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.transform.riot_file import from_json, to_json
from riot.types import FloatArray

HAND = [(30, 40), (60, 30), (80, 90), (200, 100), (210, 200), (60, 210)]
"""A shape that its mirror image does not look like."""


def picture(path: Path, corners: list[tuple[int, int]]) -> Path:
    image = Image.new("L", (240, 240))
    ImageDraw.Draw(image).polygon(corners, fill=255)
    image.save(path)
    return path


@pytest.fixture(scope="module")
def back() -> Transform:
    return replace(exact_transform(exact_pair(4, 2)).planned(), mirrored_q=True)


def region(marks: list[PlacedPiece], transform: Transform) -> shapely.Geometry:
    return shapely.union_all([shapely.Polygon(placed(mark, transform.pieces[mark.piece].polygon)) for mark in marks])


def test_a_mirrored_shape_is_mirrored_and_knows_its_source() -> None:
    shape = Shape.from_polygon(HAND)
    twin = shape.mirrored()
    expected = shapely.Polygon(shape.points * [-1.0, 1.0])
    assert shapely.Polygon(twin.points).symmetric_difference(expected).area < 1e-12
    assert shapely.Polygon(twin.points).exterior.is_ccw
    assert np.allclose(twin.source(twin.points), shape.source(twin.points * [-1.0, 1.0]))
    assert twin.mirrored() == shape


def test_marks_from_the_back_are_the_mirror_image(back: Transform) -> None:
    marks = dissection_marks(back, "q")
    turned = mirrored(marks, 0.3)
    assert [mark for mark in mirrored(turned) if isinstance(mark, PlacedPiece) and mark.mirror] == []
    seen, front = (region([mark for mark in side if isinstance(mark, PlacedPiece)], back) for side in (turned, marks))
    expected = shapely.transform(front, lambda points: points * [-1.0, 1.0] + [0.6, 0.0])
    assert seen.symmetric_difference(expected).area < 1e-9
    x0, y0, x1, y1 = extent(marks, back.pieces)
    assert extent(turned, back.pieces) == pytest.approx((0.6 - x1, y0, 0.6 - x0, y1))


def test_pictures_show_the_back(back: Transform, tmp_path: Path) -> None:
    plain = replace(back, mirrored_q=False)
    assert len(strip_scene(back).marks) > len(strip_scene(plain).marks)
    for suffix in ("svg", "png", "pdf"):
        for name, transform in (("back", back), ("plain", plain)):
            draw_transform(transform, tmp_path / f"{name}.{suffix}")
        assert (tmp_path / f"back.{suffix}").read_bytes() != (tmp_path / f"plain.{suffix}").read_bytes()
    assert b"from the back" in (tmp_path / "back.svg").read_bytes()
    puzzle = design(plain)
    front, turned = (puzzle_view(replace(puzzle, transform=transform), "q") for transform in (plain, back))
    assert front.width == pytest.approx(turned.width, abs=1.0) and not np.array_equal(front.pixels, turned.pixels)


def test_a_film_ends_with_the_back(back: Transform) -> None:
    def ink(share: float) -> FloatArray:
        pixels: FloatArray = np.asarray(camera.turning(share), dtype=np.float64)
        return pixels

    camera = Camera(back, 160, 1, {})
    assert camera.turns and not Camera(replace(back, mirrored_q=False), 160, 1, {}).turns
    front, edge_on, end = ink(0.0), ink(0.5), ink(1.0)
    assert np.abs(front - np.asarray(camera.picture(1.0), dtype=np.float64)).mean() < 2.0
    covered = [(pixels < 250).any(axis=2) for pixels in (front, edge_on, end)]
    assert covered[1].sum() < 0.1 * covered[0].sum()
    columns = np.flatnonzero(covered[0].any(axis=0))
    middle = columns[0] + columns[-1]
    flipped = np.zeros_like(covered[0])
    flipped[:, middle - columns] = covered[0][:, columns]
    assert (flipped != covered[2]).mean() < 0.02  # the same place, mirrored


def test_the_file_keeps_it(back: Transform) -> None:
    assert from_json(to_json(back)) == back
    assert '"mirrored_q":true' in to_json(back) and "mirrored_q" not in to_json(replace(back, mirrored_q=False))


def test_make_mirrors_q_when_told_to(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    kite = picture(tmp_path / "kite.png", [(120, 20), (210, 110), (120, 225), (40, 110)])
    hand = picture(tmp_path / "hand.png", HAND)
    made = {}
    for how in ("no", "yes", "best"):
        out = tmp_path / how
        assert main(["make", str(kite), str(hand), "-o", str(out), f"--mirror-q={how}", "--min-iou", "0"]) == 0
        made[how] = Transform.load(out / "kite--hand.riot")
    assert (made["no"].mirrored_q, made["yes"].mirrored_q) == (False, True)
    ious = {how: min(transform.overlap_ratios) for how, transform in made.items()}
    assert ious["best"] == max(ious["no"], ious["yes"])
    assert np.allclose(made["yes"].q.points * [-1.0, 1.0], np.roll(made["no"].q.points[::-1], 1, axis=0), atol=0.5)
    areas = [shapely.Polygon(made[how].q.source(made[how].q.points)).area for how in ("no", "yes")]
    assert areas[0] == pytest.approx(areas[1])
    assert main(["make", str(kite), str(hand), "-o", str(tmp_path / "x"), "--mirror-q=maybe"]) == 2
    assert "--mirror-q" in capsys.readouterr().err
