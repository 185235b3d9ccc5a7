"""Pictures are read as a person sees them, and what may be wrong is told."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
import shapely
from arrow import ARROW, OUTLINE, SIDE, drawn, likeness, painted
from PIL import Image

import riot
from riot.geometry.pixels import pixels_shape
from riot.geometry.quality import ReadingQuality
from riot.geometry.shape import Shape
from riot.geometry.silhouette import polygon_shape, read
from riot.types import FloatArray

ROWS, COLUMNS = np.mgrid[:SIDE, :SIDE]
RED, GREEN = (255, 0, 0), (0, 130, 0)  # of the same lightness


def image(values: FloatArray) -> Image.Image:
    return Image.fromarray(np.clip(np.rint(values), 0, 255).astype(np.uint8))


def with_alpha(values: FloatArray, alpha: FloatArray) -> Image.Image:
    picture = image(values)
    picture.putalpha(Image.fromarray(alpha.astype(np.uint8)))
    return picture


def jpeg(picture: Image.Image, quality: int = 80) -> Image.Image:
    stream = io.BytesIO()
    picture.save(stream, "JPEG", quality=quality)
    return Image.open(io.BytesIO(stream.getvalue()))


def quality(shape: Shape) -> ReadingQuality:
    assert shape.quality is not None
    return shape.quality


def opaque_pages() -> dict[str, Image.Image]:
    specks = np.where(np.random.default_rng(1).random((SIDE, SIDE)) < 0.01, 254, 255)
    edge = np.full((SIDE, SIDE), 255)
    edge[0] = edge[:, -1] = 250
    corner = 40
    x, y = np.minimum(COLUMNS, SIDE - 1 - COLUMNS), np.minimum(ROWS, SIDE - 1 - ROWS)
    rounded = np.where((x < corner) & (y < corner) & (np.hypot(x - corner, y - corner) > corner), 0, 255)
    return {
        name: with_alpha(painted(), alpha) for name, alpha in (("specks", specks), ("edge", edge), ("rounded", rounded))
    }


def colours() -> dict[str, Image.Image]:
    halves = np.where((COLUMNS < SIDE // 2)[..., None], 255.0, 0.0)
    parts = np.where((ROWS < SIDE // 2)[..., None], (250.0, 225.0, 40.0), (20.0, 20.0, 60.0))
    eyes = painted((255, 214, 0))
    eyes[(np.hypot(ROWS - 80, COLUMNS - 85) < 8) | (np.hypot(ROWS - 80, COLUMNS - 115) < 8)] = 0.0
    pale = np.where((ROWS < 120)[..., None], (30.0, 30.0, 30.0), (200.0, 200.0, 200.0))
    return {
        "isoluminant": image(painted(RED, GREEN)),
        "isoluminant-jpeg": jpeg(image(painted(RED, GREEN))),
        "halves-on-grey": image(painted(halves, (128, 128, 128))),
        "two-colours": image(painted(parts)),
        "eyes": image(eyes),
        "pale-part": image(painted(pale)),
    }


def pages() -> dict[str, Image.Image]:
    noise = np.random.default_rng(2).normal(0.0, 4.0, (SIDE, SIDE, 3))
    away = np.hypot(ROWS - SIDE / 2, COLUMNS - SIDE / 2)[..., None] / (SIDE / np.sqrt(2.0))
    checks = np.where(((ROWS // 10 + COLUMNS // 10) % 2 == 0)[..., None], 255.0, 204.0)
    column = painted((20, 20, 20), (5, 5, 5))
    edge_column, inner_row = column.copy(), column.copy()
    edge_column[:, -1] = 255.0
    inner_row[190] = 255.0
    lid = painted((60, 60, 60), (235, 235, 235))
    lid[:12] = lid[:, :8] = 12.0
    hot = column.copy()
    hot[5:9, 5:9] = 255.0
    framed, inset, coloured = painted(), painted(), painted(RED, (250, 250, 250))
    framed[:2] = framed[-2:] = framed[:, :2] = framed[:, -2:] = 0.0
    inset[6:8, 6:-6] = inset[-8:-6, 6:-6] = inset[6:-6, 6:8] = inset[6:-6, -8:-6] = 0.0
    coloured[:3] = coloured[-3:] = coloured[:, :3] = coloured[:, -3:] = (0.0, 0.0, 120.0)
    return {
        "vignette": image(painted((25, 25, 25), 200.0 * (1.0 - 0.85 * away**2.5)) + noise),
        "shadow": image(painted((40, 30, 30), 230.0 - 150.0 * np.exp(-COLUMNS / 30.0)[..., None]) + noise),
        "slope": image(painted((60, 60, 60), 90.0 + 150.0 * COLUMNS[..., None] / SIDE) + noise),
        "checks": image(painted((228, 228, 228), checks)),
        "checks-coloured": jpeg(image(painted((90, 160, 220), checks)), 90),
        "edge-column": image(edge_column),
        "inner-row": image(inner_row),
        "lid": image(lid + noise),
        "hot-pixels": image(hot),
        "framed": image(framed),
        "framed-inset": image(inset),
        "framed-in-colour": image(coloured),
        "photo": image(painted((150, 90, 60), (120, 150, 170)) + 3.0 * noise),
    }


KINDS = opaque_pages() | colours() | pages()


@pytest.mark.parametrize("kind", KINDS)
def test_the_object_is_what_a_person_sees(kind: str) -> None:
    shape = pixels_shape(KINDS[kind], kind)
    assert likeness(shape) > 0.97  # of the pixels: the rim of 700 of 10,000 counts half
    assert quality(shape).doubtful == (kind == "lid")  # which is a part that is dropped


def test_a_pale_object_is_not_its_shadow() -> None:
    x, y = COLUMNS - 30.0, ROWS - 30.0
    soft = np.exp(-((x - 90.0) ** 2 + (y - 80.0) ** 2) / 4000.0)[..., None]
    assert likeness(pixels_shape(image(painted((20, 20, 20), 250.0 - 60.0 * soft)), "shadow")) > 0.97


def test_an_opaque_page_with_a_hole_shows_the_hole() -> None:
    assert likeness(pixels_shape(with_alpha(painted(), np.where(ARROW, 0, 255)), "stencil")) > 0.97


def test_opacity_that_separates_decides() -> None:
    noise = np.random.default_rng(3).integers(0, 256, (SIDE, SIDE, 3)).astype(float)
    assert likeness(pixels_shape(with_alpha(noise, np.where(ARROW, 255, 0)), "cut out")) > 0.97
    assert likeness(pixels_shape(with_alpha(noise, np.where(ARROW, 70, 0)), "watermark")) > 0.97


@pytest.mark.parametrize("orientation", range(1, 9))
def test_orientation_is_applied(tmp_path: Path, orientation: int) -> None:
    exif = Image.Exif()
    exif[0x0112] = orientation
    path = tmp_path / "turned.jpg"
    image(painted()[: SIDE - 10]).save(path, quality=95, exif=exif)
    with Image.open(path) as stored:
        turn = {1: None, 2: 0, 3: 3, 4: 1, 5: 5, 6: 4, 7: 6, 8: 2}[orientation]
        seen = stored if turn is None else stored.transpose(Image.Transpose(turn))
        upright = np.asarray(seen.convert("L")) < 128
    page = np.zeros((SIDE, SIDE), dtype=bool)
    page[: upright.shape[0], : upright.shape[1]] = upright
    assert likeness(read(path), page) > 0.97


@pytest.mark.parametrize("form", ["WEBP", "AVIF"])
def test_newer_formats(tmp_path: Path, form: str) -> None:
    path = tmp_path / "picture.png"  # the content counts
    image(painted()).save(path, form)
    assert likeness(read(path)) > 0.97


def test_parts_that_do_not_touch_are_told() -> None:
    halves = np.zeros((SIDE, SIDE), dtype=bool)
    halves[40:100, 40:100] = halves[100:160, 100:160] = True  # joined by a corner
    seen = quality(pixels_shape(halves, "halves"))
    assert seen.kept == pytest.approx(0.5)
    assert seen.dropped == 1
    assert "50%" in seen.doubts[0]
    necked = np.full((SIDE, SIDE), 250.0)
    necked[40:90, 40:160] = necked[110:160, 40:160] = 0.0
    necked[90:110, 99:101] = 200.0  # a faint neck
    assert quality(pixels_shape(image(necked), "neck")).doubtful


def test_noise_and_the_whole_page_are_doubtful() -> None:
    noise = np.random.default_rng(4).integers(0, 256, (SIDE, SIDE)).astype(np.uint8)
    assert quality(pixels_shape(noise, "noise")).doubtful
    page = np.full((SIDE, SIDE), 255, np.uint8)
    page[0, :] = page[:, 0] = page[-1, :] = page[:, -1] = 0
    assert quality(pixels_shape(page, "page")).doubtful


def test_quality_is_no_part_of_the_content() -> None:
    shape = pixels_shape(ARROW, "arrow")
    other = Shape(shape.points, shape.feature, shape.name, shape.to_source)
    assert other.quality is None
    assert shape == other and hash(shape) == hash(other)
    seen = quality(shape)
    assert seen.kept == 1.0 and seen.dropped == seen.sides == 0
    assert seen.covered == pytest.approx(ARROW.mean())
    assert seen.separation == pytest.approx(1.0)
    assert 0.0 <= seen.roughness < 0.1


def test_sides_of_the_page_are_counted() -> None:
    cut = np.zeros((SIDE, SIDE), dtype=bool)
    cut[:120, 30:] = True
    assert quality(pixels_shape(cut, "cut")).sides == 2


def test_a_repair_tells_how_much_it_changed() -> None:
    assert quality(polygon_shape(OUTLINE, "arrow")).changed == 0.0
    bow = [(0, 0), (10, 0), (10, 10), (9.5, 10.5), (10.5, 10.5), (10, 10), (0, 10)]  # a small loop at a corner
    repaired = polygon_shape(bow, "loop")
    assert quality(repaired).changed == pytest.approx(0.25 / 100.25, rel=1e-6)
    ring = [(0, 0), (9, 0), (9, 9), (0, 9), (0, 0), (3, 3), (3, 6), (6, 6), (6, 3), (3, 3)]  # encloses a hole
    with pytest.warns(UserWarning, match="its repair changed"):
        filled = polygon_shape(ring, "ring")
    assert quality(filled).changed == pytest.approx(9.0 / 72.0, rel=0.01)
    assert "repair" in quality(filled).doubts[0]


def test_all_ways_leave_a_plain_picture_as_it_is() -> None:
    plain = pixels_shape(np.where(ARROW, 0, 255).astype(np.uint8), "arrow")
    coloured = pixels_shape(image(painted((0, 0, 0), (255, 255, 255))), "arrow")
    assert plain == coloured
    assert drawn(plain.source(plain.points)).sum() > 0


def test_polygons_of_other_libraries() -> None:
    plain = polygon_shape(OUTLINE, "arrow")
    corners = np.array(OUTLINE)
    assert polygon_shape(corners[:, None], "arrow") == plain  # OpenCV
    assert polygon_shape(np.column_stack([corners, np.arange(len(corners))]), "arrow") == plain  # with heights
    assert riot.Shape.from_polygon(shapely.Polygon(OUTLINE), "arrow") == plain


def test_a_needle_across_the_page_is_an_object_if_there_is_no_other() -> None:
    needle = np.zeros((40, 1000), dtype=np.uint8)
    needle[19:21, 20:980] = 255
    assert pixels_shape(needle, "needle").perimeter > 10.0
