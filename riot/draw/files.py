"""Scenes as files: the suffix chooses SVG, PNG or PDF. Ours."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from riot import draw
from riot.draw.scene import Scene
from riot.errors import RiotError

FORMATS = ("svg", "png", "pdf")
"""Suffixes that `write_scene` knows."""


class PictureFormatError(RiotError, ValueError):
    """A file name whose suffix is no picture format that can be written."""


def write_scene(target: Path, make: Callable[[], Scene]) -> None:
    """Write the scene that ``make`` returns, in the format of the suffix (svg, png, pdf); the same bytes every time.

    Raises `PictureFormatError` (a ValueError) for another suffix, before ``make`` is called, and OSError if the file
    cannot be written.
    """
    kind = target.suffix.lower().lstrip(".")
    if kind not in FORMATS:
        raise PictureFormatError(
            f"cannot draw {target.name!r}: the suffix {target.suffix!r} is no picture format known here; "
            f"use one of {', '.join('.' + name for name in FORMATS)}"
        )
    scene = make()
    # Through the face: who writes SVG alone does not wait for what writes PNG and PDF to load.
    if kind == "svg":
        target.write_text(draw.svg.document(scene), encoding="utf-8", newline="\n")
    else:
        target.write_bytes(draw.raster.png_bytes(scene) if kind == "png" else draw.pdf.pdf_bytes([scene]))
