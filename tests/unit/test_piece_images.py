"""Textures in pictures: every writer shows a piece's own place of its texture, wherever the piece lies."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import shapely
from PIL import Image

from riot import Transform
from riot.draw import animate_svg, draw_strip, draw_transform, write_film
from riot.draw.animate import swing_of
from riot.draw.figure import figure_scene
from riot.draw.panels import dissection_marks
from riot.draw.piece_image import PieceImages
from riot.draw.raster import png_bytes
from riot.draw.scene import PlacedPiece, Scene, extent, placed
from riot.draw.svg import document, naming, piece_id
from riot.draw.texture.names import SIDES, Side
from riot.draw.texture.sample import piece_images, sample_region
from riot.draw.texture.source import ByteArray
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.types import FloatArray

SPACE = "{http://www.w3.org/2000/svg}"


class Places:
    """A texture that tells the place: red along x, green along y, blue the same everywhere."""

    def __init__(self, blue: int) -> None:
        self.blue = blue

    def colours(self, piece: int, xy: FloatArray, step: float) -> ByteArray:
        return np.column_stack([self.of(xy), np.full(len(xy), self.blue)]).astype(np.uint8)

    def of(self, xy: FloatArray) -> FloatArray:
        return np.rint(np.clip(128.0 + 60.0 * xy, 0.0, 255.0))


TEXTURES: dict[Side, Places] = {"p": Places(10), "q": Places(240)}


@pytest.fixture(scope="module")
def transform() -> Transform:
    return exact_transform(exact_pair(4, 3)).planned()


@pytest.fixture(scope="module")
def images(transform: Transform) -> PieceImages:
    return piece_images(transform, TEXTURES)


def middles(transform: Transform) -> list[FloatArray]:
    """(1, 2) a place well within every piece, in its own frame."""
    return [
        np.array(shapely.maximum_inscribed_circle(shapely.Polygon(piece.polygon)).coords[:1])
        for piece in transform.pieces
    ]


@pytest.mark.parametrize("side", SIDES)
def test_a_skin_has_the_colours_of_the_assembled_shape(transform: Transform, images: PieceImages, side: Side) -> None:
    pose = transform.pose(0.0 if side == "p" else 1.0)
    for i, (skin, middle) in enumerate(zip(images[side], middles(transform), strict=True)):
        x0, y0, x1, y1 = skin.box
        points = transform.pieces[i].polygon
        assert (points.min(axis=0) > [x0, y0]).all() and (points.max(axis=0) < [x1, y1]).all()
        rows, columns = skin.pixels.shape[:2]
        column, row = (middle[0] - [x0, y1]) / [x1 - x0, y0 - y1] * [columns, rows]
        colour = skin.pixels[int(row), int(column)].astype(float)
        assert colour[:2] == pytest.approx(TEXTURES[side].of(pose.place(i, middle))[0], abs=1.0)
        assert colour[2] == TEXTURES[side].blue


def test_a_raster_covers_its_region_and_is_white_beyond() -> None:
    region = shapely.Polygon([(0.0, 0.0), (2.0, 0.0), (0.0, 1.0)])
    pixels, box = sample_region(region, 0.1, lambda points: np.zeros((len(points), 3), dtype=np.uint8))
    assert pixels.shape == (10, 20, 3) and box == pytest.approx((0.0, 0.0, 2.0, 1.0))
    assert (pixels[-1, 0] == 0).all() and (pixels[0, 0] == 0).all() and (pixels[0, -1] == 255).all()


def seen(picture: Image.Image, scene: Scene, placed_piece: PlacedPiece, point: FloatArray) -> FloatArray:
    """The mean colour of a picture of the scene around a place of a piece's frame."""
    x0, y0, x1, y1 = scene.box
    x, y = (placed(placed_piece, point)[0] - [x0, y1]) / [x1 - x0, y0 - y1] * [picture.width, picture.height]
    pixels = np.asarray(picture.convert("RGB"), dtype=np.float64)
    return pixels[int(y) - 1 : int(y) + 2, int(x) - 1 : int(x) + 2].mean(axis=(0, 1))


@pytest.mark.parametrize("side", SIDES)
def test_a_png_shows_them_where_the_pieces_lie(
    transform: Transform, images: PieceImages, side: Side, tmp_path: Path
) -> None:
    marks = tuple(mark for mark in dissection_marks(transform, side) if isinstance(mark, PlacedPiece))
    scene = Scene("", extent(marks, transform.pieces), 0.002, transform.pieces, marks, images)
    (tmp_path / "seen.png").write_bytes(png_bytes(scene))
    with Image.open(tmp_path / "seen.png") as picture:
        for placed_piece, middle in zip(marks, middles(transform), strict=True):
            colour = seen(picture, scene, placed_piece, middle)
            assert colour[:2] == pytest.approx(TEXTURES[side].of(placed(placed_piece, middle))[0], abs=4.0)
            assert colour[2] == pytest.approx(TEXTURES[side].blue, abs=4.0)


def test_a_film_carries_them_along(transform: Transform, images: PieceImages, tmp_path: Path) -> None:
    write_film(transform, tmp_path / "swing.gif", 240, images)
    with Image.open(tmp_path / "swing.gif") as film:

        def dark(frame: int) -> tuple[FloatArray, float]:
            film.seek(frame)
            pixels = np.asarray(film.convert("RGB"), dtype=np.float64).reshape(-1, 3)
            shown = pixels[pixels.min(axis=1) < 60]
            return shown, len(shown) / len(pixels)

        # The front is seen, and nothing of the back, until the puzzle is turned over in the middle of the loop.
        assert dark(film.n_frames // 2)[1] < 0.01
        for frame in (0, film.n_frames // 8, film.n_frames // 4):
            shown, share = dark(frame)
            assert share > 0.1
            assert (np.abs(shown[:, 2] - TEXTURES["p"].blue) < 60).mean() > 0.95


def test_svg_defines_every_skin_once_and_uses_it(transform: Transform, images: PieceImages) -> None:
    scene = figure_scene(transform, images)
    root = ElementTree.fromstring(document(scene))
    ids = [group.attrib["id"] for group in root.find(f"{SPACE}defs") or ()]
    prefix, n = naming(scene.pieces, images), len(transform)
    assert ids == [f"{prefix}{side}{i}" for side in ("", "p", "q") for i in range(n)]
    uses = [use.attrib["href"] for use in root.iter(f"{SPACE}use")]
    assert uses.count(f"#{prefix}q0") == 2  # Q's own dissection, and Q as the hand sees it
    assert uses.count(f"#{prefix}p0") == 9 and f"#{prefix}0" not in uses
    links = re.findall(r'href="([^#][^"]*)"', document(scene))
    assert len(links) == 2 * n and all(link.startswith("data:image/jpeg;base64,") for link in links)


def test_the_motion_shows_the_front_and_the_back_while_it_is_up(transform: Transform, images: PieceImages) -> None:
    prefix = naming(transform.pieces, images)
    front = swing_of(transform, prefix, {"p": images["p"]}).body
    assert f"#{prefix}p0" in front and "visibility" not in front and 'type="scale"' not in front
    back = {"q": images["q"]}
    assert piece_id(prefix, 0, images=back) == f"{prefix}0" and piece_id(prefix, 0, "q", back) == f"{prefix}q0"
    for given, shown in ((images, f"{prefix}p0"), (back, f"{prefix}0")):
        root = ElementTree.fromstring(f'<svg xmlns="{SPACE[1:-1]}">{swing_of(transform, prefix, given).body}</svg>')
        (moving,) = (group for group in root.iter(f"{SPACE}g") if group.attrib.get("class") == "r-move")
        (turn,) = (entry for entry in moving.iter(f"{SPACE}animateTransform") if entry.attrib["type"] == "scale")
        scales = [float(value.split()[0]) for value in turn.attrib["values"].split(";")]
        assert min(scales) == -1.0 and scales[0] == scales[-1] == 1.0
        uses = {use.attrib["href"]: use for use in moving.iter(f"{SPACE}use")}
        for name, values in (
            (shown, ["visible", "hidden", "visible"]),
            (f"{prefix}q0", ["hidden", "visible", "hidden"]),
        ):
            (change,) = uses[f"#{name}"]
            assert change.attrib["values"].split(";") == values
            # It changes where the puzzle is edge-on.
            for time in change.attrib["keyTimes"].split(";")[1:]:
                at = float(time) * (len(scales) - 1)
                assert np.interp(at, np.arange(len(scales)), scales) == pytest.approx(0.0, abs=0.01)


def test_names_of_pieces_depend_on_their_images(transform: Transform, images: PieceImages) -> None:
    other = piece_images(transform, {"p": Places(11)})
    names = {naming(transform.pieces), naming(transform.pieces, images), naming(transform.pieces, other)}
    assert len(names) == 3


def test_pictures_are_the_same_every_time(transform: Transform, images: PieceImages, tmp_path: Path) -> None:
    again = piece_images(transform, TEXTURES)
    assert animate_svg(transform, images) == animate_svg(transform, again)
    for name in ("strip.svg", "strip.pdf", "figure.png"):
        for folder, some in (("one", images), ("two", again)):
            (tmp_path / folder).mkdir(exist_ok=True)
            draw = draw_strip if name.startswith("strip") else draw_transform
            draw(transform, tmp_path / folder / name, some)
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
