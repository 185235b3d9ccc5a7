"""Warps of made shapes to inputs, and the textures they carry."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
import shapely
from blobs import blob_polygon
from PIL import Image

from riot import Shape, SilhouetteError, Transform
from riot.draw.texture.names import PATTERNS, SIDES, Side
from riot.draw.texture.paint import PictureTexture, PlainTexture, pattern_texture, picture_texture
from riot.draw.texture.source import TextureError, load_picture
from riot.draw.texture.warp import Warp, WarpError, make_warp, warp_side
from riot.geometry.polyline import signed_area
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.types import FloatArray


@pytest.fixture(scope="module")
def exact() -> Transform:
    return exact_transform(exact_pair(4, 3))


def deformed(seed: int) -> tuple[FloatArray, FloatArray]:
    """A unit-area blob and the same one with ripples that were not there."""
    target = blob_polygon(seed)
    target = target / np.sqrt(signed_area(target))
    angle = np.arctan2(target[:, 1], target[:, 0])
    ripple = 1.0 + 0.05 * np.sin(7.0 * angle + seed)
    return target * ripple[:, None], target


@lru_cache
def blob_warp(seed: int) -> tuple[Warp, FloatArray, FloatArray]:
    assembled, target = deformed(seed)
    starts = np.array([0, 60, 120])
    return make_warp(assembled, starts, target, target[starts]), assembled, target


@pytest.mark.parametrize("side", SIDES)
def test_no_deformation_is_the_identity(exact: Transform, side: Side) -> None:
    warp = warp_side(exact, side)
    assert np.abs(warp.images - warp.points).max() < 1e-9
    assert warp.folded == 0.0
    inside = warp.points[warp.triangles].mean(axis=1)
    assert np.abs(warp(inside) - inside).max() < 1e-9


@pytest.mark.parametrize("seed", range(4))
def test_boundary_goes_to_the_boundary(seed: int) -> None:
    warp, assembled, target = blob_warp(seed)
    for outline, matched in ((assembled, warp.points[: warp.boundary]), (target, warp.images[: warp.boundary])):
        ring = shapely.LinearRing(outline)
        assert shapely.distance(ring, shapely.points(matched)).max() < 1e-12
        # Every vertex is there, and the way leads once around: the two regions are the same.
        assert signed_area(matched) == pytest.approx(signed_area(outline), abs=1e-12)
        assert shapely.LinearRing(matched).length == pytest.approx(ring.length, abs=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_corners_correspond_as_given(seed: int) -> None:
    warp, assembled, target = blob_warp(seed)
    starts = [0, 60, 120]
    assert np.abs(warp(assembled[starts]) - target[starts]).max() < 1e-6


@pytest.mark.parametrize("seed", range(4))
def test_triangles_fill_the_shape_and_do_not_fold(seed: int) -> None:
    warp, assembled, target = blob_warp(seed)
    for points, outline in ((warp.points, assembled), (warp.images, target)):
        a, b, c = (points[warp.triangles[:, k]] for k in range(3))
        sizes = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
        assert sizes.min() > 0.0
        assert sizes.sum() == pytest.approx(signed_area(outline), abs=1e-9)
    assert warp.folded == 0.0


def star(size: float, points: int = 9) -> FloatArray:
    """A unit-area star, (2 · points, 2), whose first corner is a tip if ``size`` is positive, a notch else."""
    angle = np.arange(2 * points) * np.pi / points
    radius = 1.0 + size * np.cos(points * angle)
    outline = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    return outline / np.sqrt(signed_area(outline))


@pytest.mark.parametrize("size", [0.05, 0.08])
def test_tips_become_notches_without_folds(size: float) -> None:
    # A harmonic map alone folds 0.6 % of the larger of the two stars.
    assembled, target = star(size), star(-size)
    assert make_warp(assembled, np.array([0, 6]), target, target[[0, 6]]).folded == 0.0


def test_fold_is_reported() -> None:
    warp, _, _ = blob_warp(0)
    images = warp.images.copy()
    images[-1] += 0.5
    share = replace(warp, images=images).folded
    assert 0.0 < share < 0.1


def test_points_move_little_where_the_outline_moves_little() -> None:
    warp, _, _ = blob_warp(1)
    moved = np.hypot(*(warp.images - warp.points).T)
    assert moved[warp.boundary :].max() <= moved[: warp.boundary].max() + 0.01


def test_warp_is_deterministic() -> None:
    first, again = blob_warp(2)[0], blob_warp.__wrapped__(2)[0]
    assert first.points.tobytes() == again.points.tobytes()
    assert first.images.tobytes() == again.images.tobytes()
    assert first.triangles.tobytes() == again.triangles.tobytes()


def test_what_cannot_be_mapped_is_refused() -> None:
    assembled, target = deformed(0)
    starts = np.array([0, 60, 120])
    with pytest.raises(WarpError, match="in order"):
        make_warp(assembled, starts, target, target[[0, 120, 60]])
    crossing = assembled.copy()
    crossing[[0, 50]] = crossing[[50, 0]]
    with pytest.raises(WarpError, match="crosses itself"):
        make_warp(crossing, starts, target, target[starts])


def painted(path: Path, size: int = 200) -> tuple[Path, Shape]:
    """A picture of a blob, red at its rim, its colour otherwise telling the place; and its shape."""
    outline = blob_polygon(5) * (0.3 * size) + 0.5 * size
    x, y = np.meshgrid(np.arange(size), np.arange(size))
    at = shapely.points(x.ravel(), y.ravel())
    region = shapely.Polygon(outline)
    shapely.prepare(region)
    opaque = shapely.contains(region, at).reshape(size, size)
    rim = (shapely.distance(at, region.exterior) < 0.04 * size).reshape(size, size)
    red = np.where(rim, 255, 0)
    rgba = np.stack([red, x * 200 // size, y * 200 // size, 255 * opaque], axis=2).astype(np.uint8)
    rgba[~opaque, :3] = 255  # a white background, which must not show
    Image.fromarray(rgba, "RGBA").save(path)
    return path, Shape.from_image(path)


def test_picture_follows_the_outline(tmp_path: Path, exact: Transform) -> None:
    path, shape = painted(tmp_path / "blob.png")
    # Another shape than the picture's: its outline is where that of the blob must appear.
    assembled, _ = deformed(5)
    starts = np.array([0, 60, 120])
    corners = shape.points[[0, len(shape.points) // 3, 2 * len(shape.points) // 3]]
    nearest = [int(np.argmin(((assembled - corner) ** 2).sum(axis=1))) for corner in corners]
    order = np.argsort(nearest)
    starts = np.array(nearest)[order]
    texture = PictureTexture(
        load_picture(path, shape), shape, make_warp(assembled, starts, shape.points, corners[order])
    )
    rim = texture.colours(0, assembled, 0.004)
    assert (rim[:, 0] > 200).all()
    middle = texture.colours(0, np.zeros((1, 2)), 0.004)[0]
    assert middle[0] < 30


def test_undeformed_picture_is_the_picture(tmp_path: Path, exact: Transform) -> None:
    path, shape = painted(tmp_path / "blob.png")
    corners = np.array([0, 40, 80])
    warp = make_warp(shape.points, corners, shape.points, shape.points[corners])
    texture = PictureTexture(load_picture(path, shape), shape, warp)
    xy = shape.points * 0.7
    at = shape.source(xy)
    colours = texture.colours(0, xy, 0.001).astype(float)
    assert np.abs(colours[:, 1] - at[:, 0]).max() < 2.0
    assert np.abs(colours[:, 2] - at[:, 1]).max() < 2.0


def test_wrong_pictures_are_refused(tmp_path: Path) -> None:
    path, shape = painted(tmp_path / "blob.png")
    with Image.open(path) as image:
        image.convert("RGB").save(tmp_path / "flat.png")
        image.resize((400, 400)).save(tmp_path / "large.png")
        image.transpose(Image.Transpose.FLIP_LEFT_RIGHT).save(tmp_path / "other.png")
    (tmp_path / "words.png").write_text("no picture")
    with pytest.raises(TextureError, match="transparent") as no_alpha:
        load_picture(tmp_path / "flat.png", shape)
    assert no_alpha.value.reason == "no-alpha"
    with pytest.raises(TextureError, match="same size") as large:
        load_picture(tmp_path / "large.png", shape)
    assert large.value.reason == "other-shape"
    with pytest.raises(TextureError, match="same picture"):
        load_picture(tmp_path / "other.png", shape)
    with pytest.raises(SilhouetteError, match=r"words\.png"):
        load_picture(tmp_path / "words.png", shape)
    with pytest.raises(SilhouetteError, match=r"missing\.png"):
        load_picture(tmp_path / "missing.png", shape)


def test_a_picture_without_transparency_needs_its_mask(tmp_path: Path) -> None:
    path, shape = painted(tmp_path / "blob.png")
    with Image.open(path) as image:
        mask = image.getchannel("A")
        image.convert("RGB").save(tmp_path / "photo.jpg", quality=95, subsampling=0)
    mask.save(tmp_path / "mask.png")
    mask.resize((100, 100)).save(tmp_path / "small.png")
    mask.transpose(Image.Transpose.FLIP_LEFT_RIGHT).save(tmp_path / "other.png")
    pixels = load_picture(tmp_path / "photo.jpg", shape, tmp_path / "mask.png").astype(float)
    wanted = load_picture(path, shape).astype(float)
    assert pixels.shape == wanted.shape
    # All of the picture is the object, its rim carried outwards; of the white background nothing is left.
    assert np.abs(pixels - wanted).mean() < 6.0 and pixels.min(axis=2).max() < 215.0
    with pytest.raises(TextureError, match=r"200 × 200 pixels, its mask .* 100 × 100") as small:
        load_picture(tmp_path / "photo.jpg", shape, tmp_path / "small.png")
    assert small.value.reason == "other-size"
    with pytest.raises(TextureError, match=r"other\.png: its object") as other:
        load_picture(tmp_path / "photo.jpg", shape, tmp_path / "other.png")
    assert other.value.reason == "other-shape"


def test_picture_of_another_shape_is_refused(tmp_path: Path, exact: Transform) -> None:
    path, _ = painted(tmp_path / "blob.png")
    with pytest.raises(TextureError, match="was read from"):
        picture_texture(path, exact, "p")


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_patterns_have_both_tints(exact: Transform, side: Side, pattern: str) -> None:
    texture = pattern_texture(pattern, exact, side)  # type: ignore[arg-type]
    warp = warp_side(exact, side)
    colours = texture.colours(0, warp.points, 0.001)
    kinds, counts = np.unique(colours, axis=0, return_counts=True)
    assert len(kinds) >= 2
    assert np.sort(counts)[-2:].min() > 0.2 * len(colours)


def test_unknown_pattern_is_refused(exact: Transform) -> None:
    with pytest.raises(ValueError, match="choose bands"):
        pattern_texture("tartan", exact, "p")  # type: ignore[arg-type]


def test_plain_pieces_differ() -> None:
    texture = PlainTexture(5)
    colours = {tuple(texture.colours(i, np.zeros((3, 2)), 0.01)[0].tolist()) for i in range(5)}
    assert len(colours) == 5


@pytest.mark.parametrize("side", SIDES)
def test_exact_transform_shows_its_picture(tmp_path: Path, exact: Transform, side: Side) -> None:
    shape = exact.p if side == "p" else exact.q
    size = 300
    shape = replace(shape, to_source=np.array([[90.0, 0.0, 150.0], [0.0, -90.0, 150.0]]))
    x, y = np.meshgrid(np.arange(size), np.arange(size))
    region = shapely.Polygon(shape.source(shape.points))
    opaque = shapely.contains_xy(region, x.ravel(), y.ravel()).reshape(size, size)
    rgba = np.stack([x * 200 // size, y * 200 // size, 0 * x, 255 * opaque], axis=2).astype(np.uint8)
    Image.fromarray(rgba, "RGBA").save(tmp_path / "exact.png")
    transform = replace(exact, p=shape) if side == "p" else replace(exact, q=shape)
    texture = picture_texture(tmp_path / "exact.png", transform, side)
    # Whatever piece a place lies on: pieces in their closed pose carry the picture without seams.
    pose = exact.pose(0.0 if side == "p" else 1.0)
    for i, piece in enumerate(exact.pieces):
        middle = np.array(shapely.Polygon(piece.polygon).representative_point().coords)
        placed = pose.place(i, middle)
        colour = texture.colours(i, placed, 0.002).astype(float)[0, :2]
        assert colour == pytest.approx(shape.source(placed)[0] * 200.0 / size, abs=1.5)
