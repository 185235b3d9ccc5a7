"""Texture sheets: what is printed, cut out and glued on the pieces, at true size (theory §9). Ours.

The front of the pieces carries P's texture. The back carries Q's; it is seen from the other side, and so the sheets of
the back are mirrored as a whole: printed on the back of the front's sheets, turned over the long side, they match.
"""

from __future__ import annotations

import os
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import shapely

from riot.draw.palette import LIGHT
from riot.draw.texture.sample import painted as raster
from riot.fabricate.export.flat import FlatFormatError
from riot.fabricate.export.paper import MM_PER_INCH, Frame, Page, new_page, pdf_bytes
from riot.fabricate.model import polygons
from riot.fabricate.shelves import Spot, shelves
from riot.transform.pose import rotate

if TYPE_CHECKING:
    from riot.draw.texture.names import Side
    from riot.draw.texture.paint import Texture
    from riot.draw.texture.source import ByteArray
    from riot.fabricate.model import Design
    from riot.types import FloatArray

PAPERS = ((210.0, 297.0), (297.0, 420.0), (420.0, 594.0), (594.0, 841.0), (841.0, 1189.0))
"""A4 to A0, upright, mm; the first on which every piece fits is used."""

MARGIN_MM = 12.0
FOOT_MM = 22.0
"""Free at the sides, and below for the words."""

APART_MM = 8.0
BLEED_MM = 1.0
"""The texture goes so far beyond the cut."""

DOTS_PER_INCH = 300.0
RULER_MM = 50.0

NAME = 40
"""Letters of a name that fit."""


def write_sheets(
    design: Design, path: str | os.PathLike[str], texture: Texture, side: Side, dots_per_inch: float = DOTS_PER_INCH
) -> None:
    """Write the texture sheets of one side of the pieces as a PDF: P's (side "p") on the front, Q's ("q") on the back.

    Every page has a ruler; it is to be printed at 100 %. The same input gives the same bytes. Raises
    `riot.fabricate.export.flat.FlatFormatError` for a suffix other than .pdf.
    """
    target = Path(path)
    if target.suffix.lower() != ".pdf":
        raise FlatFormatError(f"cannot write the texture sheets {target.name!r}: use a file name that ends in .pdf")
    target.write_bytes(pdf_bytes(sheet_pages(design, texture, side, dots_per_inch)))


def sheet_pages(design: Design, texture: Texture, side: Side, dots_per_inch: float = DOTS_PER_INCH) -> list[Page]:
    """The pages of `write_sheets`."""
    faces = [face(design, i, side) for i in range(len(design.pieces))]
    width, height, spots = _layout([piece.outline for piece in design.pieces])
    count = 1 + max(spot.page for spot in spots)
    pages = [new_page(width, height) for _ in range(count)]
    for number, page in enumerate(pages):
        _words(page, design, side, number, count)
    for i, spot in enumerate(spots):
        frame = _frame(design.pieces[i].outline, spot, width, height, side)
        _piece(pages[spot.page], design, texture, side, i, frame, faces[i], dots_per_inch)
    return pages


def _frame(outline: FloatArray, spot: Spot, width: float, height: float, side: Side) -> Frame:
    """How a piece lies on its spot, rows from the top of the page; the back's mirrored."""
    angle = 0.5 * np.pi if spot.turned else 0.0
    turned = rotate(outline, angle)
    left, top = float(turned[:, 0].min()), float(turned[:, 1].max())
    mirror = width if side == "q" else None
    return Frame(angle, MARGIN_MM + spot.x - left, height - MARGIN_MM - spot.y - top, mirror)


def _layout(outlines: Sequence[FloatArray]) -> tuple[float, float, list[Spot]]:
    """Width and height of the paper, and where the pieces lie."""
    sizes = np.array([np.ptp(outline, axis=0) for outline in outlines])
    for width, height in PAPERS:
        try:
            return width, height, shelves(sizes, width - 2 * MARGIN_MM, height - FOOT_MM - MARGIN_MM, APART_MM)
        except ValueError:
            continue
    # Larger than any paper: the page is made for it.
    side = float(sizes.max())
    return side + 2 * MARGIN_MM, side + FOOT_MM + MARGIN_MM, shelves(sizes, side, side, APART_MM)


def face(design: Design, index: int, side: Side) -> shapely.Polygon:
    """The upper face of a piece (side "p") or the lower one ("q") within its outline, in its own frame, mm.

    What it gives up for its neighbours' knuckles is left out, and so is what of its own knuckles stands off.
    """
    piece = design.pieces[index]
    slab = piece.slabs[-1 if side == "p" else 0]
    within = polygons(shapely.intersection(slab.section, shapely.Polygon(piece.outline)))
    return max(within, key=lambda part: float(part.area))


def _piece(
    page: Page,
    design: Design,
    texture: Texture,
    side: Side,
    index: int,
    frame: Frame,
    within: shapely.Polygon,
    dots_per_inch: float,
) -> None:
    cut = frame.region(within)
    with_bleed = cut.buffer(BLEED_MM)
    pixels, box = painted(design, texture, side, index, frame, with_bleed, MM_PER_INCH / dots_per_inch)
    page.image(pixels, box, with_bleed)
    page.region(cut, None, LIGHT["ink"], 0.1)
    x0, y0, x1, _ = cut.bounds
    page.text(0.5 * (x0 + x1), y0 - 4.6, str(index + 1), 3.0, "muted", "center")


def painted(
    design: Design, texture: Texture, side: Side, index: int, frame: Frame, region: shapely.Polygon, step: float
) -> tuple[ByteArray, tuple[float, float, float, float]]:
    """A piece's texture in a region of the paper: (rows, columns, 3) uint8, first row at the top, and its box in mm.

    ``step`` is the size of a pixel in mm (`riot.draw.texture.sample.painted`).
    """
    pose = design.transform.pose(0.0 if side == "p" else 1.0)

    def colours(points: FloatArray) -> ByteArray:
        return texture.colours(index, pose.place(index, frame.piece(points) / design.scale), step / design.scale)

    return raster(region, step, colours)


def _words(page: Page, design: Design, side: Side, number: int, count: int) -> None:
    p, q = design.transform.p.name or "P", design.transform.q.name or "Q"
    names = [textwrap.shorten(name, NAME, placeholder="…") for name in (p, q)]
    what = f"front: {names[0]}" if side == "p" else f"back: {names[1]}, mirrored"
    x, y = MARGIN_MM, 7.0
    page.text(x, y + 4.4, f"{what} · sheet {number + 1} of {count}", 3.2, weight="bold")
    page.text(x, y, "Print at 100 %, cut along the thin lines, glue on the pieces of the same number.", 2.8, "muted")
    right = page.width - MARGIN_MM
    page.line(np.array([[right - RULER_MM, y + 3.0], [right, y + 3.0]]), LIGHT["ink"], 0.3)
    for at in (right - RULER_MM, right):
        page.line(np.array([[at, y + 1.8], [at, y + 4.2]]), LIGHT["ink"], 0.3)
    page.text(right - 0.5 * RULER_MM, y - 1.0, f"this line is {RULER_MM:.0f} mm long", 2.8, "muted", "center")
