"""Other programs read what is written for a laser, for paper and as films: Inkscape, librsvg, poppler, ffmpeg."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from ezdxf.addons.drawing.matplotlib import qsave
from ezdxf.filemanagement import readfile
from PIL import Image

from riot.draw import write_film
from riot.fabricate import Design, FabricationParameters, design
from riot.fabricate.export.booklet import booklet, write_booklet
from riot.fabricate.export.flat import write_flat, write_flat_files
from riot.fabricate.export.flat_parts import flat_parts
from riot.groundtruth.pairs import exact_pair, exact_transform

pytestmark = pytest.mark.system

RED, BLACK = (255, 0, 0), (0, 0, 0)


def needs(program: str) -> pytest.MarkDecorator:
    return pytest.mark.skipif(shutil.which(program) is None, reason=f"{program} is not installed")


def output(*command: str | Path) -> str:
    return subprocess.run(list(map(str, command)), capture_output=True, text=True, check=True, timeout=250).stdout


@pytest.fixture(scope="module")
def puzzle() -> Design:
    return design(exact_transform(exact_pair(4, 3)), FabricationParameters(size_mm=150.0))


@pytest.fixture(scope="module")
def folder(puzzle: Design, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("laser")
    write_flat_files(puzzle, path, dxf=False)
    return path


def ink(path: Path, colour: tuple[int, int, int]) -> float:
    """Share of the pixels that lean towards a colour from white, each as far as it does."""
    pixels = 255.0 - np.asarray(Image.open(path).convert("RGB"), dtype=np.float64)
    wanted = 255.0 - np.array(colour, dtype=np.float64)
    along = (pixels * wanted).sum(axis=2) / (wanted**2).sum()
    off = np.abs(pixels - along[..., None] * wanted).max(axis=2)
    return float((along * (off < 30.0)).mean())


@needs("inkscape")
def test_inkscape_sees_parts_at_true_size_in_layers(puzzle: Design, folder: Path) -> None:
    lines = output("inkscape", "--query-all", folder / "laser-layers.svg").splitlines()
    boxes = {}
    for name, *numbers in (line.split(",") for line in lines if line.count(",") == 4):
        boxes[name] = np.array(numbers, dtype=float) * 25.4 / 96.0
    assert {"engrave", "cut"} <= boxes.keys()
    for part in flat_parts(puzzle, "layers"):
        wide, high = boxes[part.name][2:]
        x0, y0, x1, y1 = part.region.bounds
        # It lies turned: the box changes, but not its longest chord, and the line is as wide as it is.
        reach = max(np.hypot(x1 - x0, y1 - y0), 1.0)
        assert max(wide, high) < reach + 0.2
        assert wide * high > 0.99 * part.region.area


@needs("inkscape")
@needs("rsvg-convert")
@pytest.mark.parametrize("name", ["laser-layers", "laser-strips", "laser-coupon"])
def test_every_viewer_shows_lines_and_numbers(folder: Path, tmp_path: Path, name: str) -> None:
    source = folder / f"{name}.svg"
    assert 'id="cut"' in source.read_text()
    output("rsvg-convert", "-b", "white", "-o", tmp_path / "rsvg.png", source)
    output("inkscape", "--export-type=png", f"--export-filename={tmp_path / 'inkscape.png'}", "-b", "white", source)
    with Image.open(tmp_path / "rsvg.png") as first, Image.open(tmp_path / "inkscape.png") as second:
        assert np.abs(np.subtract(first.size, second.size)).max() <= 1
    for colour in (RED, BLACK):
        seen = [ink(tmp_path / f"{program}.png", colour) for program in ("rsvg", "inkscape")]
        assert min(seen) > 1e-5 and max(seen) < 1.5 * min(seen)


@needs("chromium")
@needs("rsvg-convert")
@pytest.mark.parametrize("name", ["laser-layers", "laser-strips", "laser-coupon"])
def test_a_browser_shows_the_same_sheet(folder: Path, tmp_path: Path, name: str) -> None:
    source = folder / f"{name}.svg"
    output("rsvg-convert", "-b", "white", "-o", tmp_path / "rsvg.png", source)
    quiet = ["--disable-background-networking", "--disable-component-update", "--disable-sync", "--no-first-run"]
    size, profile = "--window-size=1000,1000", f"--user-data-dir={tmp_path / 'profile'}"
    command = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", *quiet, profile, size]
    output(*command, f"--screenshot={tmp_path / 'browser.png'}", f"file://{source}")
    with Image.open(tmp_path / "rsvg.png") as first, Image.open(tmp_path / "browser.png") as second:
        second.crop((0, 0, *first.size)).save(tmp_path / "cut.png")
    for colour in (RED, BLACK):
        seen = [ink(tmp_path / f"{program}.png", colour) for program in ("rsvg", "cut")]
        assert min(seen) > 1e-5 and max(seen) < 1.5 * min(seen)


def test_dxf_is_drawn_in_the_colours_of_its_layers(puzzle: Design, tmp_path: Path) -> None:
    write_flat(puzzle, tmp_path / "sheet.dxf", "layers")
    drawing = readfile(tmp_path / "sheet.dxf")
    assert not drawing.audit().errors
    qsave(drawing.modelspace(), str(tmp_path / "dxf.png"), bg="#FFFFFF", dpi=100)
    assert ink(tmp_path / "dxf.png", RED) > 1e-4 and ink(tmp_path / "dxf.png", BLACK) > 1e-5


@needs("pdfinfo")
@needs("pdftotext")
def test_poppler_reads_the_booklet(puzzle: Design, tmp_path: Path) -> None:
    write_booklet(puzzle, tmp_path / "assembly.pdf")
    information = output("pdfinfo", tmp_path / "assembly.pdf")
    assert re.search(rf"Pages:\s+{len(booklet(puzzle))}\b", information) and "A4" in information
    text = " ".join(output("pdftotext", "-layout", tmp_path / "assembly.pdf", "-").split())
    assert "Put it together" in text and "Cut it with a laser" in text and "P ⇄ Q" in text


@needs("ffmpeg")
def test_ffmpeg_decodes_what_it_wrote(puzzle: Design, tmp_path: Path) -> None:
    for suffix in ("gif", "mp4"):
        write_film(puzzle.transform, tmp_path / f"film.{suffix}", width=160)
        output("ffmpeg", "-v", "error", "-i", tmp_path / f"film.{suffix}", tmp_path / f"{suffix}-%03d.png")
        frames = sorted(tmp_path.glob(f"{suffix}-*.png"))
        first, half = (np.asarray(Image.open(frames[k]).convert("RGB"), dtype=float) for k in (0, len(frames) // 4))
        assert len(frames) > 80 and np.abs(first - half).mean() > 2.0
