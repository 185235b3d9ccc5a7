"""Pictures that are shapes, pictures that are none, and what the errors say."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
import shapely
from PIL import Image

from riot import Shape
from riot.errors import RiotError, SilhouetteError
from riot.geometry.picture import decode
from riot.geometry.silhouette import mask_shape, polygon_shape, read, read_image
from riot.parameters import ShapeParameters
from riot.types import FloatArray


def disc(side: int = 64, radius: float = 20.0, at: tuple[float, float] = (32.0, 32.0)) -> FloatArray:
    rows, columns = np.mgrid[:side, :side]
    return np.where((columns - at[0]) ** 2 + (rows - at[1]) ** 2 <= radius**2, 255, 0).astype(np.uint8)


def save(path: Path, values: FloatArray, **options: object) -> Path:
    Image.fromarray(values).save(path, **options)
    return path


def reason(action: object, *arguments: object) -> str:
    with pytest.raises(SilhouetteError) as caught:
        action(*arguments)  # type: ignore[operator]
    assert len(str(caught.value)) > 20
    return caught.value.reason


@pytest.mark.parametrize("suffix", [".png", ".gif", ".bmp", ".tif", ".jpg"])
def test_formats_agree(tmp_path: Path, suffix: str) -> None:
    path = save(tmp_path / f"café au lait{suffix}", disc())
    shape = read(path)
    assert shape.name == "café au lait"
    assert shape.source([[0.0, 0.0]])[0] == pytest.approx([32.0, 32.0], abs=0.1)
    assert np.linalg.norm(shape.points, axis=1) == pytest.approx(1.0 / np.sqrt(np.pi), rel=0.03)
    assert Shape.from_image(path).points == pytest.approx(shape.points)


def test_content_counts_not_suffix(tmp_path: Path) -> None:
    path = save(tmp_path / "picture.jpg", disc(), format="PNG")
    assert len(read(path).points) > 100
    text = tmp_path / "text.png"
    text.write_text("This is no picture.")
    assert reason(read, text) == "not-a-picture"


def test_unreadable(tmp_path: Path) -> None:
    whole = save(tmp_path / "whole.png", np.random.default_rng(0).integers(0, 255, (64, 64), dtype=np.uint8))
    (tmp_path / "truncated.png").write_bytes(whole.read_bytes()[:1500])
    (tmp_path / "empty.png").write_bytes(b"")
    (tmp_path / "folder.png").mkdir()
    assert reason(read, tmp_path / "truncated.png") == "unreadable"
    assert reason(read, tmp_path / "missing.png") == "unreadable"
    assert reason(read, tmp_path / "folder.png") == "unreadable"
    assert reason(read, tmp_path / "empty.png") == "not-a-picture"


@pytest.mark.parametrize("suffix", [".png", ".gif", ".tif", ".jpg", ".bmp"])
def test_any_truncation_is_a_shape_or_a_clean_error(tmp_path: Path, suffix: str) -> None:
    data = save(tmp_path / f"whole{suffix}", disc()).read_bytes()
    for size in range(0, len(data), max(1, len(data) // 25)):
        path = tmp_path / f"cut{suffix}"
        path.write_bytes(data[:size])
        try:
            read(path)
        except SilhouetteError as error:
            assert "cut" in str(error)


def test_pictures_without_object(tmp_path: Path) -> None:
    assert reason(read, save(tmp_path / "black.png", np.zeros((50, 50), np.uint8))) == "one-colour"
    assert reason(read, save(tmp_path / "pixel.png", np.zeros((1, 1), np.uint8))) == "one-colour"
    assert reason(read, save(tmp_path / "line.png", np.array([[0, 255, 0, 255]], np.uint8))) == "all-border"
    assert reason(mask_shape, np.eye(3)) == "too-small"
    assert reason(mask_shape, np.zeros((0, 4))) == "empty"
    assert reason(mask_shape, np.full((9, 9), np.nan)) == "unreadable"
    assert reason(mask_shape, np.zeros((9, 9, 3))) == "empty"
    assert reason(mask_shape, disc(64, 3.0)) == "too-small"
    assert len(mask_shape(disc(64, 3.0), parameters=ShapeParameters(min_pixels=20)).points) > 100


def test_frame_along_the_border_is_background() -> None:
    frame = np.full((60, 80), 255.0)
    frame[5:-5, 5:-5] = 0.0
    shape = mask_shape(frame)
    assert shape.source([[0.0, 0.0]])[0] == pytest.approx([39.5, 29.5])
    assert np.ptp(shape.points, axis=0) == pytest.approx(np.array([70.0, 50.0]) / np.sqrt(3500.0), rel=0.02)


def test_object_may_touch_the_border() -> None:
    half = np.zeros((80, 80))
    half[:30, 20:60] = 1.0
    shape = mask_shape(half)
    assert shape.source([[0.0, 0.0]])[0] == pytest.approx([39.5, 14.5], abs=0.05)
    assert shapely.Polygon(shape.source(shape.points)).area == pytest.approx(1200.0, rel=0.01)


def test_largest_of_two_blobs_and_no_holes() -> None:
    picture = np.maximum(disc(96, 20.0, (30.0, 40.0)), disc(96, 15.0, (75.0, 60.0))).astype(float)
    picture[35:45, 25:35] = 0.0
    shape = mask_shape(picture)
    assert shape.source([[0.0, 0.0]])[0] == pytest.approx([30.0, 40.0], abs=0.1)
    assert np.linalg.norm(shape.points, axis=1).min() > 0.5


def test_blobs_that_meet_at_a_corner_are_two() -> None:
    picture = np.zeros((60, 60))
    picture[5:30, 5:30] = 1.0
    picture[30:50, 30:50] = 1.0
    assert mask_shape(picture).source([[0.0, 0.0]])[0] == pytest.approx([17.0, 17.0], abs=0.1)


@pytest.mark.parametrize("width", [2.0, 5.0, 12.0])
def test_spiral(width: float) -> None:
    t = np.linspace(2.0, 9.0 * np.pi, 900)
    line = shapely.LineString(np.column_stack([t * np.cos(t), t * np.sin(t)]) * 8.0)
    band = line.buffer(width)
    rows, columns = np.mgrid[-240:240, -240:240]
    mask = shapely.contains_xy(band, columns.ravel(), rows.ravel()).reshape(rows.shape)
    shape = mask_shape(mask)
    outline = shapely.Polygon(shape.source(shape.points) - 240.0)
    assert outline.is_valid
    assert outline.intersection(band).area / outline.union(band).area > 0.75


def test_staircase_is_no_detail() -> None:
    rows, columns = np.mgrid[:200, :200]
    triangle = (rows > 20) & (columns > 20) & (rows + 2 * columns < 350)
    assert mask_shape(triangle).feature.sum() <= 5


def test_transparency_is_the_object(tmp_path: Path) -> None:
    rgba = np.zeros((64, 64, 4), np.uint8)
    rgba[..., 3] = disc(64, 30.0)  # black on transparent black, reaching most of the border's middle
    rgba[::2, :, 0] = 255
    shape = read(save(tmp_path / "alpha.png", rgba))
    assert np.linalg.norm(shape.points, axis=1) == pytest.approx(1.0 / np.sqrt(np.pi), rel=0.03)
    rgba[..., 3] = 255
    rgba[..., :3] = disc()[..., None]
    assert len(read(save(tmp_path / "opaque.png", rgba)).points) > 100


def test_deep_and_palette_pictures(tmp_path: Path) -> None:
    deep = disc().astype(np.uint16) * 200
    assert len(read(save(tmp_path / "deep.png", deep)).points) > 100
    assert len(read(save(tmp_path / "float.tif", disc().astype(np.float32) / 255.0)).points) > 100
    palette = Image.fromarray(disc() // 255).convert("P")
    palette.putpalette([0, 0, 0, 255, 255, 255])
    palette.save(tmp_path / "palette.png")
    assert len(read(tmp_path / "palette.png").points) > 100


def test_size_is_checked_before_decoding(tmp_path: Path) -> None:
    path = save(tmp_path / "wide.png", np.zeros((100, 300), np.uint8))
    path.write_bytes(path.read_bytes()[:60])  # the header alone
    assert reason(read_image, path, ShapeParameters(max_pixels=29_999)) == "too-large"
    assert reason(read_image, path, ShapeParameters(max_pixels=30_000)) == "unreadable"


def test_large_pictures_are_averaged_down(tmp_path: Path) -> None:
    picture = disc(3000, 900.0, (1600.0, 1400.0))
    path = save(tmp_path / "large.png", picture)
    assert decode(path, 10**8).factor == 2
    shape = read(path)
    assert shape.source([[0.0, 0.0]])[0] == pytest.approx([1600.0, 1400.0], abs=0.5)
    assert np.linalg.norm(shape.source(shape.points) - [1600.0, 1400.0], axis=1) == pytest.approx(900.0, rel=0.005)


def test_polygons_without_area_or_sense() -> None:
    line = [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]
    bow_tie = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]
    assert reason(polygon_shape, line) == "degenerate"
    assert reason(polygon_shape, [[1.0, 1.0]] * 5) == "degenerate"
    assert reason(polygon_shape, np.empty((0, 2))) == "degenerate"
    assert reason(polygon_shape, bow_tie) == "self-crossing"
    assert reason(polygon_shape, [[0.0, 0.0], [1.0, np.inf], [1.0, 0.0]]) == "unreadable"
    assert reason(polygon_shape, "triangle") == "unreadable"
    assert reason(polygon_shape, [[1.0, 2.0, 3.0]] * 4) == "degenerate"  # points with heights
    assert reason(polygon_shape, [[1.0, 2.0, 3.0, 4.0]] * 4) == "unreadable"
    assert reason(polygon_shape, np.array([[0j, 1j], [1j, 1j], [1j, 0j]])) == "unreadable"


@pytest.mark.filterwarnings("error")
def test_polygons_beyond_arithmetic() -> None:
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    for factor in (1e-300, 1e150, 1e307):
        assert reason(polygon_shape, factor * square) == "degenerate"
    assert reason(polygon_shape, square + 1e15) == "degenerate"
    # As long as 560 discs of its area: sampled, it would have 65,000 points.
    assert reason(polygon_shape, square * [1000.0, 0.001]) == "degenerate"
    for good in (1e-90 * square, 1e90 * square, square.astype(np.int8), square[::-1] + 1e6, [*square, square[0]]):
        assert len(polygon_shape(good).points) == len(polygon_shape(square).points)


@pytest.mark.filterwarnings("error")
def test_masks_beyond_arithmetic() -> None:
    disc = np.hypot(*np.mgrid[-9:10, -9:10]) < 6.0
    assert reason(mask_shape, disc * 1e-320) == "unreadable"
    assert reason(mask_shape, disc * 1e305) == "unreadable"
    assert reason(mask_shape, [[0, 1], [1]]) == "unreadable"
    assert mask_shape(disc * 1e-50).points == pytest.approx(mask_shape(disc).points)


def test_the_wrong_reader_is_told_of_the_right_one(tmp_path: Path) -> None:
    picture, drawing = tmp_path / "a.png", tmp_path / "b.svg"
    Image.new("L", (9, 9)).save(picture)
    drawing.write_text('<svg xmlns="http://www.w3.org/2000/svg"><rect width="9" height="9"/></svg>')
    with pytest.raises(SilhouetteError, match="from_image"):
        Shape.from_svg(picture)
    with pytest.raises(SilhouetteError, match="from_svg"):
        Shape.from_image(drawing)
    for reader in (Shape.from_image, Shape.from_svg, read):
        for path in (tmp_path, tmp_path / "missing", "nu\0ll"):
            assert reason(reader, path) == "unreadable"


def test_a_shape_made_by_hand_must_be_one() -> None:
    points = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    feature = np.ones(4, dtype=np.bool_)
    assert Shape(points, feature).perimeter == 4.0
    for wrong in (points.tolist(), points[:2], points[::-1], 2.0 * points, points.astype(np.float32), points * np.nan):
        assert reason(lambda given: Shape(given, np.ones(len(given), dtype=np.bool_)), wrong) == "degenerate"
    assert reason(lambda given: Shape(points, given), feature[:3]) == "degenerate"


def test_a_small_loop_is_cut_off() -> None:
    square = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [5.1, 10.0], [4.9, 10.2], [5.1, 10.2], [4.9, 10.0], [0.0, 10.0]]
    shape = polygon_shape(square)
    assert shape.points.max() == pytest.approx(0.5, abs=0.01)


def test_a_narrow_neck_keeps_its_sides_apart() -> None:
    neck = 0.004
    discs = [shapely.Point(-2.0, 0.0).buffer(1.0), shapely.Point(2.0, 0.1).buffer(1.0)]
    dumbbell = shapely.union_all([*discs, shapely.box(-2.0, -neck, 2.0, neck)])
    shape = polygon_shape(np.asarray(dumbbell.exterior.coords))
    assert shapely.Polygon(shape.points).is_valid


def test_errors_have_both_parents_and_travel() -> None:
    with pytest.raises(RiotError):
        polygon_shape([[0.0, 0.0]] * 3)
    with pytest.raises(ValueError, match="three distinct"):
        polygon_shape([[0.0, 0.0]] * 3)
    error = SilhouetteError("empty", "nothing")
    assert pickle.loads(pickle.dumps(error)).reason == "empty"
