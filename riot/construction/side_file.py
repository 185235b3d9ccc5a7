"""JSON files in which a user says something about places on both shapes: what pins and stiff regions share. Ours."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from riot.errors import FormatError
from riot.geometry.limits import JSON_BYTES, TooManyBytes, read_text
from riot.geometry.shape import Shape
from riot.types import FloatArray

FRAMES = ("source", "shape")


@dataclass(frozen=True)
class SideFile:
    """A kind of file: its ``format`` and version, what it lists, in the plural, and an example of an item."""

    format: str
    version: int
    noun: str
    example: str

    def read(self, path: str | os.PathLike[str]) -> str:
        """The text of a file of this kind; FormatError if it is too long, OSError if it cannot be read."""
        try:
            return read_text(Path(path), JSON_BYTES)
        except TooManyBytes as error:
            raise FormatError(f"{path} is no {self.noun} file: {error}; keep few {self.noun}") from error

    def rows(self, text: str, where: str) -> tuple[str, list[Any], list[Any]]:
        """The frame of all points, and the items of P and of Q; FormatError names ``where`` and says what to change."""
        try:
            document = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise FormatError(f"{where} is not a {self.noun} file: it is not JSON ({error})") from None
        if not isinstance(document, dict) or document.get("format") != self.format:
            raise FormatError(f'{where} is not a {self.noun} file: write "format": "{self.format}" into it')
        if document.get("version") != self.version:
            raise FormatError(f'{where} has version {document.get("version")!r}: write "version": {self.version}')
        frame = document.get("frame")
        if frame not in FRAMES:
            raise FormatError(f'{where}: "frame" is {frame!r}: write "source" (pixels) or "shape" (unit area)')
        unknown = sorted(set(document) - {"format", "version", "frame", "p", "q"})
        if unknown:
            raise FormatError(f'{where}: "{unknown[0]}" means nothing here: {self.noun} stand under "p" and "q"')
        sides = []
        for name in "pq":
            rows = document.get(name, [])
            if not isinstance(rows, list):
                raise FormatError(f'{where}: "{name}" is not a list: write [{self.example}, …]')
            sides.append(rows)
        return frame, sides[0], sides[1]


def read_points(value: Any, least: int, shape: Shape, frame: str, where: str) -> FloatArray:
    """(k, 2) points in the shape's frame, k ≥ ``least``; FormatError if they are none.

    >>> read_points([[0, 1]], 1, house, "shape", "text").tolist()
    [[0.0, 1.0]]
    """
    try:
        points = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        points = np.empty(0)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < least or not np.isfinite(points).all():
        raise FormatError(f"{where}: give a list of at least {least} [x, y], all of them numbers")
    return shape.from_source(points) if frame == "source" else points
