"""Pins: sections of an outline that a user keeps as they are, or draws anew (theory §8: rows of the detail step). Ours.

P's outline lives in the tree inside T̄, Q's in the tree inside T, so each shape's pins act on its own tree; the section
that faces a pinned one across the same cut gives way. Pins come from Python or from a JSON file::

    {"format": "riot-pins", "version": 1, "frame": "source",
     "p": [{"keep": [[120, 40]]}, {"keep": [[10, 80], [60, 95]]}],
     "q": [{"draw": [[200, 30], [215, 10], [230, 33]]}]}

``frame`` says what the coordinates are: ``source``, the picture's pixels or the polygon's own, or ``shape``, unit area
and centroid at the origin. ``keep`` holds points on or near the outline: one, the boundary around it; several, the
section through them in order, of two points the shorter way round. ``draw`` is a line from one point of the outline to
another, which replaces the section between them, the shorter way round; it lies on one piece.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from riot.construction.side_file import SideFile, read_points
from riot.errors import FormatError
from riot.geometry.shape import Shape
from riot.types import FloatArray

_FILE = SideFile("riot-pins", 1, "pins", '{"keep": [[x, y]]}')


@dataclass(frozen=True, eq=False)
class Pin:
    """One pin: ``points`` (k, 2) float64 in the shape's frame; ``drawn``: they replace the boundary, else they name it.

    ValueError if the points are not finite (k, 2), k ≥ 1, or of a drawn line not k ≥ 2.
    """

    points: FloatArray
    drawn: bool = False

    def __post_init__(self) -> None:
        """Refuse points that name no section of the boundary."""
        points = self.points
        fits = isinstance(points, np.ndarray) and points.ndim == 2 and points.shape[1:] == (2,)
        if not fits or points.dtype != np.float64 or len(points) < 1 + self.drawn or not np.isfinite(points).all():
            raise ValueError(f"a pin's points are (k, 2) finite float64, k ≥ {1 + self.drawn}; use keep() or draw()")


@dataclass(frozen=True, eq=False)
class Pins:
    """Pins of P and of Q."""

    p: tuple[Pin, ...] = ()
    q: tuple[Pin, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.p or self.q)


def keep(points: npt.ArrayLike) -> Pin:
    """Keep the boundary at (2,) or through (k, 2) points of the shape's frame; see `Pin`.

    >>> keep([0.5, 0.0]).points.shape
    (1, 2)
    """
    return Pin(np.atleast_2d(np.asarray(points, dtype=np.float64)))


def draw(points: npt.ArrayLike) -> Pin:
    """Replace the boundary between the ends of the line (k, 2) by that line, in the shape's frame; see `Pin`.

    >>> draw([[0.5, 0.0], [0.6, 0.1], [0.7, 0.0]]).drawn
    True
    """
    return Pin(np.atleast_2d(np.asarray(points, dtype=np.float64)), drawn=True)


def load_pins(path: str | os.PathLike[str], p: Shape, q: Shape) -> Pins:
    """Read a pins file; ``p`` and ``q`` convert from their sources' coordinates. `FormatError` says what to change.

    >>> from riot import Shape
    >>> house = Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)])
    >>> kite = Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)])
    >>> text = '{"format": "riot-pins", "version": 1, "frame": "source", "p": [{"keep": [[2, 5]]}]}'
    >>> from pathlib import Path
    >>> _ = Path("pins.json").write_text(text)
    >>> pins = load_pins("pins.json", house, kite)  # keep the ridge of the roof
    >>> len(pins.p), len(pins.q)
    (1, 0)
    """
    return pins_from_json(_FILE.read(path), p, q, str(path))


def pins_from_json(text: str, p: Shape, q: Shape, where: str = "text") -> Pins:
    """As `load_pins`, from text; ``where`` names it in errors.

    >>> from riot import Shape
    >>> house = Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)])
    >>> kite = Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)])
    >>> text = '{"format": "riot-pins", "version": 1, "frame": "source", "p": [{"keep": [[2, 5]]}]}'
    >>> len(pins_from_json(text, house, kite).p)
    1
    """
    frame, *sides = _FILE.rows(text, where)
    pins = [
        tuple(_pin(row, shape, frame, f"{where}: pin {k} of {name}") for k, row in enumerate(rows))
        for name, rows, shape in zip("pq", sides, (p, q), strict=True)
    ]
    return Pins(*pins)


def _pin(row: Any, shape: Shape, frame: str, where: str) -> Pin:
    if not isinstance(row, dict) or len(row) != 1 or next(iter(row)) not in ("keep", "draw"):
        raise FormatError(f'{where} is neither {{"keep": …}} nor {{"draw": …}}')
    kind, value = next(iter(row.items()))
    return Pin(read_points(value, 2 if kind == "draw" else 1, shape, frame, where), kind == "draw")
