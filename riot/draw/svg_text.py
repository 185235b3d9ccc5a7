"""Numbers, points and words as SVG text. Ours.

Coordinates are whole numbers, a thousand to a unit; y points down in SVG, so it is turned over here and nowhere else.
"""

from __future__ import annotations

import html
import math
from collections.abc import Iterable

import numpy as np

from riot.types import FloatArray

UNITS = 1000
"""SVG units per unit of the scene: a thousandth of a unit-area shape is the finest detail in a picture."""

_FORBIDDEN = dict.fromkeys(
    (*range(9), 11, 12, *range(14, 32), 127, *range(0xD800, 0xE000), 0xFFFE, 0xFFFF), "\N{REPLACEMENT CHARACTER}"
)
"""What XML must not hold, even escaped; file names may."""


def escape(text: str) -> str:
    """Text for XML and HTML, between tags or within quotes; characters that XML forbids become U+FFFD.

    >>> escape("P & Q")
    'P &amp; Q'
    """
    return html.escape(text.translate(_FORBIDDEN), quote=True)


def path_data(points: FloatArray, closed: bool = True) -> str:
    """Path data of (k, 2) points, y up: whole numbers, relative after the first, repeated points left out.

    >>> path_data(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
    'M0 0l1000 0-1000-1000z'
    """
    grid = np.rint(points * [UNITS, -UNITS]).astype(np.int64)
    steps = np.diff(grid, axis=0)
    steps = steps[(steps != 0).any(axis=1)]
    text = f"M{grid[0, 0]} {grid[0, 1]}"
    if len(steps):
        text += "l" + " ".join(map(str, steps.ravel().tolist())).replace(" -", "-")  # a sign parts numbers too
    return text + ("z" if closed else "")


def turn(heading: float) -> str:
    """Degrees, clockwise as SVG has them, of a heading in radians; within a full turn either way.

    >>> turn(math.pi / 2)
    '-90'
    """
    degrees = round(-math.degrees(math.remainder(heading, 2.0 * math.pi)), 2)
    return f"{degrees + 0.0:.6g}"


def translation(x: float, y: float) -> str:
    """A point, y up, as the two numbers of a translation.

    >>> translation(0.5, 1.0)
    '500 -1000'
    """
    return f"{whole_number(x)} {whole_number(-y)}"


def rings_data(rings: Iterable[FloatArray]) -> str:
    """Path data of closed rings."""
    return "".join(map(path_data, rings))


def whole_number(value: float) -> int:
    """A length in SVG's units."""
    return round(value * UNITS)
