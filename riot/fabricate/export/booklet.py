"""The booklet of a puzzle, ``assembly.pdf``: front page, steps, pages for reference, a page for the laser. Ours."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from riot.draw.pdf import pdf_bytes
from riot.draw.texture.names import SIDES
from riot.fabricate.export.flat import FlatFormatError
from riot.fabricate.export.laser_page import laser_page
from riot.fabricate.export.page import page_scenes
from riot.fabricate.export.picture import puzzle_view
from riot.fabricate.export.steps import cover, step_pages

if TYPE_CHECKING:
    from riot.draw.scene import Scene
    from riot.draw.solid import View
    from riot.draw.texture.names import Side
    from riot.fabricate.model import Design
    from riot.fabricate.solid import Part


def write_booklet(
    design: Design,
    path: str | os.PathLike[str],
    views: Mapping[Side, View] | None = None,
    trays: tuple[Part, ...] = (),
) -> None:
    """Write the booklet as a PDF; the front page shows ``views`` of the puzzle. The same design gives the same bytes.

    Raises `riot.fabricate.export.flat.FlatFormatError` for a suffix other than .pdf.
    """
    target = Path(path)
    if target.suffix.lower() != ".pdf":
        raise FlatFormatError(f"cannot write the booklet {target.name!r}: use a file name that ends in .pdf")
    target.write_bytes(pdf_bytes(booklet(design, views, trays), unit_mm=1.0))


def booklet(design: Design, views: Mapping[Side, View] | None = None, trays: tuple[Part, ...] = ()) -> list[Scene]:
    """The pages of `write_booklet`, in mm."""
    views = views or {side: puzzle_view(design, side) for side in SIDES}
    return [cover(design, views), *step_pages(design, trays), *page_scenes(design), laser_page(design)]
