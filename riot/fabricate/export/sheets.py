"""Texture sheets: what is printed, cut out and glued on the pieces, at true size (theory §9). Ours.

The front of the pieces carries P's texture. The back carries Q's; it is seen from the other side, and so the sheets of
the back are mirrored as a whole: printed on the back of the front's sheets, turned over the long side, they match.
"""

from __future__ import annotations

import os
import textwrap
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import shapely

from riot.draw.pdf import pdf_bytes
from riot.draw.scene import Bitmap, Line, Mark, Scene
from riot.fabricate.export.faces import face, face_pixels
from riot.fabricate.export.flat import FlatFormatError
from riot.fabricate.export.paper import MM_PER_INCH, Frame, region_mark, rings, sheet, text
from riot.fabricate.shelves import Spot, shelves
from riot.transform.pose import rotate

if TYPE_CHECKING:
    from riot.draw.texture.names import Side
    from riot.draw.texture.paint import Texture
    from riot.fabricate.model import Design
    from riot.types import FloatArray

PAPERS = ((210.0, 297.0), (297.0, 420.0), (420.0, 594.0), (594.0, 841.0), (841.0, 1189.0))
"""A4 to A0, upright, mm; the first on which every piece fits is used."""

SHEET_MARGIN_MM = 12.0
FOOT_MM = 22.0
"""Free at the sides, and below for the words."""

FACE_SPACE_MM = 8.0
BLEED_MM = 1.0
"""The texture goes so far beyond the cut."""

SHEET_DOTS_PER_INCH = 300.0
RULER_MM = 50.0

LONGEST_NAME = 40
"""Letters of a name that fit."""


def write_sheets(
    design: Design,
    path: str | os.PathLike[str],
    texture: Texture,
    side: Side,
    dots_per_inch: float = SHEET_DOTS_PER_INCH,
) -> None:
    """Write the texture sheets of one side of the pieces as a PDF: P's (side "p") on the front, Q's ("q") on the back.

    Every page has a ruler; it is to be printed at 100 %. The same input gives the same bytes. Raises
    `riot.fabricate.export.flat.FlatFormatError` for a suffix other than .pdf.
    """
    target = Path(path)
    if target.suffix.lower() != ".pdf":
        raise FlatFormatError(f"cannot write the texture sheets {target.name!r}: use a file name that ends in .pdf")
    target.write_bytes(pdf_bytes(sheet_scenes(design, texture, side, dots_per_inch), unit_mm=1.0))


def sheet_scenes(
    design: Design, texture: Texture, side: Side, dots_per_inch: float = SHEET_DOTS_PER_INCH
) -> list[Scene]:
    """The pages of `write_sheets`, in mm."""
    faces = [face(design, i, side) for i in range(len(design.pieces))]
    width, height, spots = _layout([piece.outline for piece in design.pieces])
    count = 1 + max(spot.page for spot in spots)
    pages = [_captions(width, design, side, number, count) for number in range(count)]
    for i, spot in enumerate(spots):
        frame = _frame(design.pieces[i].outline, spot, width, height, side)
        pages[spot.page] += _piece(design, texture, side, i, frame, faces[i], dots_per_inch)
    return [sheet("texture sheet", width, height, marks) for marks in pages]


def _frame(outline: FloatArray, spot: Spot, width: float, height: float, side: Side) -> Frame:
    """How a piece lies on its spot, rows from the top of the page; the back's mirrored."""
    angle = 0.5 * np.pi if spot.turned else 0.0
    turned = rotate(outline, angle)
    left, top = float(turned[:, 0].min()), float(turned[:, 1].max())
    mirror = width if side == "q" else None
    return Frame(angle, SHEET_MARGIN_MM + spot.x - left, height - SHEET_MARGIN_MM - spot.y - top, mirror)


def _layout(outlines: Sequence[FloatArray]) -> tuple[float, float, list[Spot]]:
    """Width and height of the paper, and where the pieces lie."""
    sizes = np.array([np.ptp(outline, axis=0) for outline in outlines])
    for width, height in PAPERS:
        try:
            free = width - 2 * SHEET_MARGIN_MM
            spots = shelves(sizes, free, height - FOOT_MM - SHEET_MARGIN_MM, FACE_SPACE_MM)
            return width, height, _centred(spots, sizes, free)
        except ValueError:
            continue
    # Larger than any paper: the page is made for it.
    side = float(sizes.max())
    return side + 2 * SHEET_MARGIN_MM, side + FOOT_MM + SHEET_MARGIN_MM, shelves(sizes, side, side, FACE_SPACE_MM)


def _centred(spots: Sequence[Spot], sizes: FloatArray, width: float) -> list[Spot]:
    """The spots with the pieces of every page in the middle of its width."""
    ends = [spot.x + float(size[int(spot.turned)]) for spot, size in zip(spots, sizes, strict=True)]
    used = [max(end for end, other in zip(ends, spots, strict=True) if other.page == spot.page) for spot in spots]
    return [replace(spot, x=spot.x + 0.5 * (width - end)) for spot, end in zip(spots, used, strict=True)]


def _piece(
    design: Design,
    texture: Texture,
    side: Side,
    index: int,
    frame: Frame,
    within: shapely.Polygon,
    dots_per_inch: float,
) -> list[Mark]:
    cut = frame.region(within)
    with_bleed = cut.buffer(BLEED_MM)
    pixels, box = face_pixels(design, texture, side, index, frame, with_bleed, MM_PER_INCH / dots_per_inch)
    x0, y0, x1, _ = cut.bounds
    number = text(0.5 * (x0 + x1), y0 - 4.6, str(index + 1), 3.0, "note", "middle")
    return [Bitmap(pixels, box, rings(with_bleed)), region_mark(cut, "cut"), number]


def _captions(width: float, design: Design, side: Side, number: int, count: int) -> list[Mark]:
    p, q = design.transform.p.name or "P", design.transform.q.name or "Q"
    names = [textwrap.shorten(name, LONGEST_NAME, placeholder="…") for name in (p, q)]
    as_seen = "" if design.transform.mirrored_q else ", seen mirrored"
    what = f"front: {names[0]}" if side == "p" else f"back: {names[1]}{as_seen}"
    x, y = SHEET_MARGIN_MM, 7.0
    right = width - SHEET_MARGIN_MM
    left = right - RULER_MM
    hint = "Print at 100 %, cut along the thin lines, glue on the pieces of the same number."
    ruler = (
        [[left, y + 3.0], [right, y + 3.0]],
        [[left, y + 1.8], [left, y + 4.2]],
        [[right, y + 1.8], [right, y + 4.2]],
    )
    return [
        text(x, y + 4.4, f"{what} · sheet {number + 1} of {count}", 3.2, weight="bold"),
        text(x, y, hint, 2.8, "note"),
        *(Line(np.array(points), "outline") for points in ruler),
        text(right - 0.5 * RULER_MM, y - 1.0, f"this line is {RULER_MM:.0f} mm long", 2.8, "note", "middle"),
    ]
