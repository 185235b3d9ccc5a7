"""Scenes as pixels: the SVG text is what is painted, so that a PNG never differs from the SVG. Ours.

Only textures, which an SVG file has as JPEG, are given without loss: what JPEG adds would make films twice as large.

resvg paints without a window and with fonts that come with matplotlib, so that every machine gives the same bytes.
"""

from __future__ import annotations

import importlib.util
import io
from pathlib import Path

import numpy as np
import numpy.typing as npt
import resvg_py
from PIL import Image

from riot.draw.scene import Scene
from riot.draw.svg import document
from riot.draw.tuning import PNG_WIDTH

_FAMILY = "DejaVu Sans"


def font_files() -> list[str]:
    """The regular and the bold letters, from matplotlib's folder; importing matplotlib takes longer than a picture."""
    package = importlib.util.find_spec("matplotlib")
    assert package is not None and package.origin is not None
    folder = Path(package.origin).parent / "mpl-data" / "fonts" / "ttf"
    return [str(folder / name) for name in ("DejaVuSans.ttf", "DejaVuSans-Bold.ttf")]


_FONT_FILES = font_files()


def png_bytes(scene: Scene, width: int = PNG_WIDTH) -> bytes:
    """The scene as a PNG file, ``width`` pixels wide.

    Examples
    --------
    >>> from riot.draw.figure import (figure_scene)
    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> png_bytes(figure_scene(exact_transform(dudeney())), 320)[:4]
    b'\\x89PNG'
    """
    return png_of_svg(document(scene, codec="PNG"), width)


def png_of_svg(text: str, width: int) -> bytes:
    """An SVG file as a PNG file, ``width`` pixels wide.

    >>> png_of_svg('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 2 1"/>', 8)[1:4]
    b'PNG'
    """
    fonts = _FONT_FILES if "<text" in text else []  # reading them takes a third of a film's time
    return resvg_py.svg_to_bytes(
        svg_string=text, width=width, skip_system_fonts=True, font_files=fonts,
        font_family=_FAMILY, sans_serif_family=_FAMILY,
    )  # fmt: skip


def pixels_of_png(data: bytes) -> npt.NDArray[np.uint8]:
    """A PNG file as pixels, (rows, columns, 3) uint8, first row on top.

    >>> pixels_of_png(png_of_svg('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 2 1"/>', 8)).shape
    (4, 8, 3)
    """
    with Image.open(io.BytesIO(data)) as picture:
        return np.asarray(picture.convert("RGB"))
