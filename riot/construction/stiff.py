"""Stiff regions: parts of a shape that bend less when it is bent before it is cut (theory §12). Ours.

They come from Python or from a JSON file::

    {"format": "riot-stiff", "version": 1, "frame": "source",
     "p": [{"polygon": [[80, 20], [140, 20], [140, 90], [80, 90]], "factor": 20}]}

``frame`` is as in `riot.construction.pins`. Within ``polygon`` the same strain costs ``factor`` times as much; where
polygons overlap the factors multiply.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

from riot.construction.side_file import SideFile, read_points
from riot.errors import FormatError
from riot.geometry.shape import Shape
from riot.types import FloatArray

MAX_FACTOR = 1000.0
"""Greatest factor of a region, and the inverse of the least: with more, single modes are told apart badly."""

_FILE = SideFile("riot-stiff", 1, "stiff regions", '{"polygon": [[x, y], …], "factor": 20}')

Region = tuple[FloatArray, float]
"""A polygon (k, 2) in the shape's frame, and by which factor the shape is stiffer there."""


@dataclass(frozen=True, eq=False)
class StiffRegions:
    """Stiff regions of P and of Q."""

    p: tuple[Region, ...] = ()
    q: tuple[Region, ...] = ()


def load_stiff(path: str | os.PathLike[str], p: Shape, q: Shape) -> StiffRegions:
    """Read a file of stiff regions; ``p`` and ``q`` convert from their sources' coordinates (ours).

    `FormatError` says what to change.

    >>> from pathlib import Path
    >>> roof = '{"polygon": [[0, 3], [4, 3], [2, 5]], "factor": 20}'
    >>> text = f'{{"format": "riot-stiff", "version": 1, "frame": "source", "p": [{roof}]}}'
    >>> _ = Path("stiff.json").write_text(text)
    >>> stiff = load_stiff("stiff.json", house, kite)
    >>> len(stiff.p), len(stiff.q)
    (1, 0)
    """
    return stiff_from_json(_FILE.read(path), p, q, str(path))


def stiff_from_json(text: str, p: Shape, q: Shape, where: str = "text") -> StiffRegions:
    """As `load_stiff`, from text; ``where`` names it in errors.

    >>> text = '{"format": "riot-stiff", "version": 1, "frame": "shape", "q": []}'
    >>> stiff_from_json(text, house, kite).q
    ()
    """
    frame, *sides = _FILE.rows(text, where)
    regions = [
        tuple(_region(row, shape, frame, f"{where}: region {k} of {name}") for k, row in enumerate(rows))
        for name, rows, shape in zip("pq", sides, (p, q), strict=True)
    ]
    return StiffRegions(*regions)


def _region(row: Any, shape: Shape, frame: str, where: str) -> Region:
    if not isinstance(row, dict) or set(row) != {"polygon", "factor"}:
        raise FormatError(f"{where} is not {_FILE.example}")
    factor = row["factor"]
    if isinstance(factor, bool) or not isinstance(factor, int | float) or not 1 / MAX_FACTOR <= factor <= MAX_FACTOR:
        raise FormatError(f'{where}: "factor" is a number from {1 / MAX_FACTOR:g} to {MAX_FACTOR:g}')
    return read_points(row["polygon"], 3, shape, frame, where), float(factor)
