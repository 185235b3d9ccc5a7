"""Scenes as files: SVG, PNG and PDF show the same marks at the same places, and PDF pages have their true size."""

from __future__ import annotations

import re
import zlib
from pathlib import Path

import numpy as np
import pytest
import shapely

from riot.draw.files import write_scene
from riot.draw.pdf import POINTS_PER_MM, pdf_bytes
from riot.draw.raster import pixels_of_png, png_bytes
from riot.draw.scene import Bitmap, Dot, Label, Line, Mark, Region, Scene, extent, moved
from riot.fabricate.export.paper import rings
from riot.types import FloatArray

GREY = (220, 218, 212)
BLACK = np.zeros((3, 4, 3), dtype=np.uint8)
SQUARE_WITH_HOLE = shapely.box(10.0, 10.0, 50.0, 40.0) - shapely.box(20.0, 20.0, 30.0, 30.0)


def scene(*marks: Mark) -> Scene:
    return Scene("some marks", (0.0, 0.0, 100.0, 50.0), 0.2, (), marks)


def contents(data: bytes) -> bytes:
    """What the streams of a PDF file say."""
    streams = re.findall(rb"stream\r?\n(.*?)\r?\nendstream", data, flags=re.S)
    return b"\n".join(zlib.decompress(stream) for stream in streams)


def inside(pixels: FloatArray, region: shapely.Geometry) -> FloatArray:
    """(rows, columns) which pixels of a picture of the scene have their middles in a region."""
    rows, columns = pixels.shape[:2]
    x, y = np.meshgrid((np.arange(columns) + 0.5) * 100.0 / columns, 50.0 - (np.arange(rows) + 0.5) * 50.0 / rows)
    return shapely.contains_xy(region, x, y)


def test_a_png_fills_a_region_and_leaves_its_holes() -> None:
    pixels = pixels_of_png(png_bytes(scene(Region(rings(SQUARE_WITH_HOLE), "silhouette")), 400))
    assert pixels.shape == (200, 400, 3)
    filled = inside(pixels, SQUARE_WITH_HOLE)
    assert (pixels[filled] == GREY).all() and (pixels[~filled] == 255).all()


def test_a_png_shows_a_bitmap_pixel_by_pixel_within_its_clip() -> None:
    colours = np.random.default_rng(5).integers(0, 256, (200, 400, 3), dtype=np.uint8)
    whole = pixels_of_png(png_bytes(scene(Bitmap(colours, (0.0, 0.0, 100.0, 50.0))), 400))
    assert np.array_equal(whole, colours)
    cut = pixels_of_png(png_bytes(scene(Bitmap(colours, (0.0, 0.0, 100.0, 50.0), rings(SQUARE_WITH_HOLE))), 400))
    within = inside(cut, SQUARE_WITH_HOLE)
    assert np.array_equal(cut[within], colours[within]) and (cut[~within] == 255).all()


def test_words_are_written_without_the_fonts_of_the_machine() -> None:
    for anchor, columns in (("start", slice(200, None)), ("end", slice(None, 200)), ("middle", slice(100, 300))):
        pixels = pixels_of_png(png_bytes(scene(Label(50.0, 20.0, "P ⇄ Q · ⌀ 3 mm", size=20.0, anchor=anchor)), 400))
        dark = pixels.max(axis=2) < 128
        assert dark.sum() > 100
        assert dark[:, columns].sum() == dark.sum()


def test_a_pdf_page_has_its_true_size_and_places() -> None:
    marks = (Region(rings(SQUARE_WITH_HOLE), "silhouette"), Line(np.array([[1.0, 2.0], [99.0, 48.0]]), "outline"))
    data = pdf_bytes([scene(*marks), scene()], unit_mm=1.0)
    boxes = [[float(x) for x in box.split()] for box in re.findall(rb"/MediaBox \[([^\]]+)\]", data)]
    assert boxes == [pytest.approx([0.0, 0.0, 100.0 * POINTS_PER_MM, 50.0 * POINTS_PER_MM])] * 2
    numbers = re.findall(rb"([\d.]+) ([\d.]+) [ml]\b", contents(data))
    places = np.array(numbers, dtype=float) / POINTS_PER_MM
    wanted = np.concatenate([*marks[0].rings, marks[1].points])
    distances = np.hypot(*(places[:, None] - wanted[None]).T)
    assert distances.min(axis=1).max() < 1e-4  # mm: every corner is there


@pytest.mark.parametrize("suffix", ["svg", "png", "pdf"])
def test_a_scene_with_all_kinds_of_marks_is_the_same_every_time(suffix: str, tmp_path: Path) -> None:
    marks = (
        Region(rings(SQUARE_WITH_HOLE), "cut"),
        Line(np.array([[0.0, 0.0], [9.0, 9.0]]), "seam"),
        Dot(60.0, 20.0, "open"),
        Label(70.0, 20.0, "a & b <c>"),
        Bitmap(
            np.zeros((3, 4, 3), dtype=np.uint8), (80.0, 10.0, 84.0, 13.0), rings(shapely.box(81.0, 11.0, 83.0, 12.0))
        ),
    )
    for name in ("first", "second"):
        write_scene(tmp_path / f"{name}.{suffix}", lambda: scene(*marks))
    data = (tmp_path / f"first.{suffix}").read_bytes()
    assert data == (tmp_path / f"second.{suffix}").read_bytes()
    assert b"Date" not in data


def test_moving_marks_moves_their_extent() -> None:
    marks: list[Mark] = [
        Region(rings(SQUARE_WITH_HOLE), "cut"),
        Line(np.array([[0.0, 0.0], [9.0, 9.0]]), "seam"),
        Dot(60.0, 20.0, "open"),
        Bitmap(BLACK, (80.0, 10.0, 84.0, 13.0)),
    ]
    for mark in marks:
        x0, y0, x1, y1 = extent([mark], ())
        assert extent(moved([mark], 5.0, -3.0, 2.0), ()) == pytest.approx(
            (2 * x0 + 5, 2 * y0 - 3, 2 * x1 + 5, 2 * y1 - 3)
        )
