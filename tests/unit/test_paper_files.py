"""Texture sheets, assembly page and pictures of the puzzle: true size, mirrored where they must be, deterministic."""

from __future__ import annotations

import io
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely
from PIL import Image

from riot.draw.files import PictureFormatError
from riot.draw.scene import Bitmap, Label, Line, Region, Scene
from riot.draw.texture.names import Side
from riot.draw.texture.paint import PlainTexture, find_textures
from riot.draw.texture.source import ByteArray
from riot.fabricate import Design, FabricationParameters, design
from riot.fabricate.export.booklet import booklet, write_booklet
from riot.fabricate.export.faces import face, face_pixels
from riot.fabricate.export.flat import FlatFormatError
from riot.fabricate.export.flat_parts import KINDS
from riot.fabricate.export.laser_sheet import LASER_COLOURS
from riot.fabricate.export.page import page_scenes
from riot.fabricate.export.paper import Frame
from riot.fabricate.export.paperwork import write_paperwork
from riot.fabricate.export.picture import EYE, PICTURE_DOTS_PER_INCH, draw_puzzle
from riot.fabricate.export.sheets import sheet_scenes, write_sheets
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.types import FloatArray

SHAPE_SIDES: tuple[Side, Side] = ("p", "q")
RED = (255, 0, 0)


class Places:
    """A texture that tells the place by its colour."""

    def colours(self, piece: int, xy: FloatArray, step: float) -> ByteArray:
        red, green = np.rint(np.clip(128.0 + 60.0 * xy, 0.0, 255.0)).T
        return np.column_stack([red, green, np.full(len(xy), piece)]).astype(np.uint8)


class Red:
    """A texture without detail."""

    def colours(self, piece: int, xy: FloatArray, step: float) -> ByteArray:
        return np.broadcast_to(np.array(RED, dtype=np.uint8), (len(xy), 3))


@pytest.fixture(scope="module")
def puzzle_design() -> Design:
    return design(exact_transform(exact_pair(4, 3)), FabricationParameters(size_mm=150.0))


def cuts(pages: list[Scene]) -> list[shapely.Polygon]:
    """The cut lines on the pages."""
    marks = [mark for page in pages for mark in page.marks if isinstance(mark, Region)]
    assert all(mark.pen == "cut" for mark in marks)
    return [shapely.Polygon(mark.rings[0]) for mark in marks]


@pytest.mark.parametrize("mirror", [None, 210.0])
def test_frames_lead_there_and_back(mirror: float | None) -> None:
    frame = Frame(0.7, 31.0, -4.0, mirror)
    points = np.random.default_rng(3).uniform(-50.0, 50.0, (9, 2))
    placed = frame.paper(points)
    assert frame.piece(placed) == pytest.approx(points, abs=1e-12)
    triangle = shapely.LinearRing(points[:3])
    # Rigid; only the mirror turns the way around.
    assert shapely.LinearRing(placed[:3]).length == pytest.approx(triangle.length)
    assert (shapely.LinearRing(placed[:3]).is_ccw == triangle.is_ccw) == (mirror is None)


@pytest.mark.parametrize("side", SHAPE_SIDES)
def test_sheets_are_at_true_size(puzzle_design: Design, side: Side) -> None:
    pages = sheet_scenes(puzzle_design, PlainTexture(4), side, 40.0)
    faces = [face(puzzle_design, i, side) for i in range(len(puzzle_design.pieces))]
    cut_regions = cuts(pages)
    assert sorted(cut.area for cut in cut_regions) == pytest.approx(
        sorted(face_region.area for face_region in faces), rel=1e-9
    )
    page = shapely.box(*pages[0].box)
    for k, cut in enumerate(cut_regions):
        assert page.buffer(-10.0).contains(cut)
        assert all(cut.distance(other) > 4.0 for other in cut_regions[:k])


def test_faces_leave_the_hinges_free(puzzle_design: Design) -> None:
    for i, piece in enumerate(puzzle_design.pieces):
        outline = shapely.Polygon(piece.outline)
        for side in SHAPE_SIDES:
            face_region = face(puzzle_design, i, side)
            assert face_region.difference(outline).area < 1e-9
            assert 0.7 * outline.area < face_region.area <= outline.area


def test_pdf_pages_are_paper(puzzle_design: Design, tmp_path: Path) -> None:
    write_sheets(puzzle_design, tmp_path / "sheet.pdf", PlainTexture(4), "p", 40.0)
    write_booklet(puzzle_design, tmp_path / "page.pdf")
    for name in ("sheet.pdf", "page.pdf"):
        data = (tmp_path / name).read_bytes()
        boxes = [[float(x) for x in box.split()] for box in re.findall(rb"/MediaBox \[([^\]]+)\]", data)]
        assert boxes
        assert all(box == pytest.approx([0.0, 0.0, 210.0 / 25.4 * 72.0, 297.0 / 25.4 * 72.0]) for box in boxes)
        assert b"Date" not in data


def test_back_is_the_mirrored_front(puzzle_design: Design) -> None:
    front = [cut.centroid.x for cut in cuts(sheet_scenes(puzzle_design, PlainTexture(4), "p", 40.0))]
    back = [cut.centroid.x for cut in cuts(sheet_scenes(puzzle_design, PlainTexture(4), "q", 40.0))]
    # The two faces of a piece differ by its hinges alone.
    assert [210.0 - x for x in back] == pytest.approx(front, abs=1.5)


@pytest.mark.parametrize("side", SHAPE_SIDES)
def test_colours_are_where_the_pieces_have_them(puzzle_design: Design, side: Side) -> None:
    mirror = 210.0 if side == "q" else None
    frame, region = Frame(0.5, 90.0, 70.0, mirror), face(puzzle_design, 2, side)
    on_paper = frame.region(region)
    pixels, (x0, _, _, y1) = face_pixels(puzzle_design, Places(), side, 2, frame, on_paper, 0.5)
    pose = puzzle_design.transform.pose(0.0 if side == "p" else 1.0)
    for point in (region.representative_point().coords[0], shapely.maximum_inscribed_circle(region).coords[0]):
        c, s = math.cos(0.5), math.sin(0.5)
        x, y = 90.0 + c * point[0] - s * point[1], 70.0 + s * point[0] + c * point[1]
        x = x if mirror is None else mirror - x
        seen = pixels[int((y1 - y) / 0.5), int((x - x0) / 0.5)]
        (position,) = pose.place(2, np.array([point]) / puzzle_design.scale)
        assert seen[:2].astype(float) == pytest.approx(128.0 + 60.0 * position, abs=1.5)
        assert seen[2] == 2


def test_large_pieces_get_large_paper(puzzle_design: Design) -> None:
    large = replace(
        puzzle_design,
        pieces=tuple(replace(piece, outline=3.0 * piece.outline) for piece in puzzle_design.pieces),
        scale=3.0 * puzzle_design.scale,
    )
    page = sheet_scenes(large, PlainTexture(4), "p", 10.0)[0]
    assert page.box[2] > 210.0


def test_assembly_page_tells_all(puzzle_design: Design) -> None:
    pages = page_scenes(replace(puzzle_design, warnings=("the moon is made of cheese",) * 60))
    seen = [[mark.text for mark in page.marks if isinstance(mark, Label)] for page in pages]
    words = [line for page in seen for line in page]
    assert len(seen) >= 3  # many warnings go on, on a further page
    assert sum("the moon is made of cheese" in line for line in words) == 60
    for piece in puzzle_design.pieces:
        assert f"1 × {piece.name}" in words
    assert f"{puzzle_design.pins[0].count} × pin" in words
    assert "P ⇄ Q" in seen[0]
    # Numbers of the pieces: in P, in Q and on the chain.
    assert all(seen[0].count(str(i + 1)) == 3 for i in range(len(puzzle_design.pieces)))
    # All of it is on paper.
    for page in pages:
        assert all(10.0 < mark.x < 200.0 and 10.0 < mark.y < 290.0 for mark in page.marks if isinstance(mark, Label))


def test_the_booklet_shows_every_step(puzzle_design: Design) -> None:
    pages = booklet(puzzle_design)
    assert [page.title for page in pages] == ["front page", "steps", "assembly", "assembly", "laser"]
    words = [" ".join(mark.text for mark in page.marks if isinstance(mark, Label)) for page in pages]
    assert "P ⇄ Q" in words[0] and sum(isinstance(mark, Bitmap) for mark in pages[0].marks) == 2
    n, first = len(puzzle_design.pieces), puzzle_design.motion.open_hinge
    # A picture of every joint; none reaches into the words below it.
    joints = [mark for mark in pages[1].marks if isinstance(mark, Bitmap)]
    assert len(joints) == n - 1
    lines = [mark for mark in pages[1].marks if isinstance(mark, Label) and mark.text.startswith("Lay the knuckle")]
    for joint, line in zip(joints, lines, strict=True):
        assert joint.box[1] > line.y + 3.0 and joint.box[0] < line.x + 80.0
    for k in range(n - 1):
        before, after = (first + k) % n + 1, (first + k + 1) % n + 1
        upper = after if puzzle_design.pieces[after - 1].start.role == "upper" else before
        assert f"Lay the knuckle of {upper} on that of {before + after - upper}." in words[1]
    assert words[1].count("Press a pin") == sum(pin.count for pin in puzzle_design.pins)
    for layer, colour in LASER_COLOURS.items():
        assert f"{layer}:" in words[-1] and colour in words[-1]
    assert "laser-layers: " in words[-1]
    pens = [mark.pen for mark in pages[-1].marks if isinstance(mark, Region | Line)]
    assert pens.count("laser-cut") == 1 + 2 * n and pens.count("laser-engrave") == 1 + 2 * n and "laser-score" in pens
    turned = replace(puzzle_design, transform=replace(puzzle_design.transform, mirrored_q=True))
    assert any("Turn it over." in mark.text for mark in booklet(turned)[1].marks if isinstance(mark, Label))
    for page in pages:
        assert all(9.0 < mark.x < 201.0 and 9.0 < mark.y < 288.0 for mark in page.marks if isinstance(mark, Label))


def png(path: Path) -> Image.Image:
    return Image.open(io.BytesIO(path.read_bytes())).convert("RGB")


@pytest.mark.parametrize("side", SHAPE_SIDES)
def test_picture_shows_the_faces_at_scale(puzzle_design: Design, tmp_path: Path, side: Side) -> None:
    draw_puzzle(puzzle_design, tmp_path / "whole.png", side, textures={side: Red()})
    pixels = np.asarray(png(tmp_path / "whole.png"))
    shown = float((pixels == RED).all(axis=2).sum()) * (25.4 / PICTURE_DOTS_PER_INCH) ** 2
    faces = sum(face(puzzle_design, i, side).area for i in range(len(puzzle_design.pieces))) * math.sin(EYE.elevation)
    assert 0.93 * faces < shown <= 1.001 * faces  # less what outlines cover


def test_picture_taken_apart_is_larger(puzzle_design: Design, tmp_path: Path) -> None:
    draw_puzzle(puzzle_design, tmp_path / "whole.png", "p")
    draw_puzzle(puzzle_design, tmp_path / "apart.png", "p", apart=True)
    whole, apart = png(tmp_path / "whole.png"), png(tmp_path / "apart.png")
    assert apart.width > whole.width
    assert apart.height > whole.height


def test_paper_is_deterministic(puzzle_design: Design, tmp_path: Path) -> None:
    for name in ("first", "second"):
        write_sheets(puzzle_design, tmp_path / f"{name}.pdf", Places(), "q", 60.0)
        write_booklet(puzzle_design, tmp_path / f"{name}-page.pdf")
        draw_puzzle(puzzle_design, tmp_path / f"{name}.png", "q", apart=True, textures={"q": Places()})
    for suffix in (".pdf", "-page.pdf", ".png"):
        assert (tmp_path / f"first{suffix}").read_bytes() == (tmp_path / f"second{suffix}").read_bytes()


def test_other_formats_are_refused(puzzle_design: Design, tmp_path: Path) -> None:
    with pytest.raises(FlatFormatError, match=r"\.pdf"):
        write_sheets(puzzle_design, tmp_path / "sheet.svg", PlainTexture(4), "p")
    with pytest.raises(FlatFormatError, match=r"\.pdf"):
        write_booklet(puzzle_design, tmp_path / "page.png")
    with pytest.raises(PictureFormatError, match=r"\.png"):
        draw_puzzle(puzzle_design, tmp_path / "whole.pdf", "p")
    assert not list(tmp_path.iterdir())


def test_paperwork_is_complete(puzzle_design: Design, tmp_path: Path) -> None:
    textures = find_textures(puzzle_design.transform, {}, pattern="checks")
    written = write_paperwork(puzzle_design, tmp_path, textures, dxf=False, dots_per_inch=60.0)
    assert sorted(written) == sorted(tmp_path.iterdir())
    assert all(path.stat().st_size > 1000 for path in written)
    assert {path.name for path in written} == {
        *(f"laser-{kind}{kerf}.svg" for kind in KINDS for kerf in ("", "-kerf")),
        "laser-coupon.svg",
        "texture-front.pdf",
        "texture-back.pdf",
        "assembly.pdf",
        *(f"{what}-{side}.png" for what in ("puzzle", "apart") for side in SHAPE_SIDES),
    }
    assert not find_textures(puzzle_design.transform, {})
