"""Paperwork: everything flat that comes with a puzzle, in one folder. Ours."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from riot.draw.texture.names import SIDES
from riot.fabricate.export.booklet import write_booklet
from riot.fabricate.export.drawing import Drawing, drawing_of
from riot.fabricate.export.flat import write_flat_files
from riot.fabricate.export.inlay import InlayTexture
from riot.fabricate.export.picture import draw_puzzle, png_of_puzzle, puzzle_view
from riot.fabricate.export.sheets import SHEET_DOTS_PER_INCH, write_sheets

if TYPE_CHECKING:
    from riot.draw.texture.names import Side
    from riot.draw.texture.paint import Texture
    from riot.fabricate.model import Design
    from riot.fabricate.solid import Part

SHEETS: Mapping[Side, str] = {"p": "texture-front.pdf", "q": "texture-back.pdf"}


def write_paperwork(
    design: Design,
    folder: Path,
    textures: Mapping[Side, Texture] | None = None,
    *,
    drawing: Drawing | None = None,
    dxf: bool = True,
    trays: tuple[Part, ...] = (),
    dots_per_inch: float = SHEET_DOTS_PER_INCH,
) -> list[Path]:
    """Write laser files, texture sheets, the booklet and pictures into a folder that exists; returns their paths.

    ``laser-*.svg`` and, with ``dxf``, ``laser-*.dxf``; ``texture-front.pdf`` and ``texture-back.pdf`` for sides that
    have a texture, their pictures with so many ``dots_per_inch``; ``assembly.pdf``; ``puzzle-p.png``, ``puzzle-q.png``,
    and ``apart-p.png``, ``apart-q.png``. ``trays`` are in the laser files and the booklet. The same input gives the
    same bytes. Raises `riot.errors.MissingExtraError` if a DXF file is asked for and ezdxf is not installed.
    """
    textures = textures or {}
    written = write_flat_files(design, folder, dxf=dxf, trays=trays)
    for side, texture in textures.items():
        written.append(folder / SHEETS[side])
        write_sheets(design, written[-1], texture, side, dots_per_inch)
    drawing = drawing or drawing_of(design)
    seen = textures if drawing is None else {side: InlayTexture(design, drawing, side) for side in SIDES}
    views = {side: puzzle_view(design, side, textures=seen) for side in SIDES}
    written.append(folder / "assembly.pdf")
    write_booklet(design, written[-1], views, trays)
    for side in SIDES:
        written += [folder / f"puzzle-{side}.png", folder / f"apart-{side}.png"]
        written[-2].write_bytes(png_of_puzzle(views[side]))
        draw_puzzle(design, written[-1], side, apart=True, textures=seen)
    return written
