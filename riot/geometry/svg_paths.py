"""The data of SVG paths → rings with curves flattened (SVG 1.1, section 8.3, and appendix F.6 for arcs)."""

from __future__ import annotations

import cmath
import itertools
import math
import re
from collections.abc import Iterator

import numpy as np

from riot.types import ComplexArray, FloatArray

_COMMAND = re.compile(r"([MmZzLlHhVvCcSsQqTtAa])([^MmZzLlHhVvCcSsQqTtAa]*)")
_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_NUMBERS = re.compile(rf"\s*,?\s*({_NUMBER})")
_ARC = re.compile(r"\s*,?\s*".join(["", *[f"({_NUMBER})"] * 3, "([01])", "([01])", *[f"({_NUMBER})"] * 2]))
_ARGUMENTS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}

_MAX_CHORDS = 1000
"""Greatest number of chords of a curve. Ours: enough for a full turn at the flatness of an outline."""


class PathError(ValueError):
    """The data of a path is broken, or of a kind that is not read."""


def rings(data: str, flatness: float) -> Iterator[ComplexArray]:
    """Yield each subpath of a path's data as (m,) complex points, x + iy, the last joined to the first by filling.

    Chords stay within ``flatness`` of their curves. Raises `PathError` for what a viewer would draw only in part.

    >>> [ring.tolist() for ring in rings("m1 1h2v2z", 0.1)]
    [[(1+1j), (3+1j), (3+3j)]]
    """
    start = here = 0j
    control: complex | None = None  # of the curve before, which smooth ones go on
    before = ""
    pieces: list[ComplexArray] = []
    for letter, values in _commands(data):
        kind, base = letter.upper(), here if letter.islower() else 0j
        if not before and kind != "M":
            raise PathError("a path begins with a move")
        if kind == "M":
            yield from _ring(pieces)
            start = here = base + complex(*values)
            pieces = [np.array([here])]
        elif kind == "Z":
            here = start
            yield from _ring(pieces)
            pieces = [np.array([here])]
        elif kind in "LHV":
            x = values[0] if kind != "V" else here.real - base.real
            y = values[-1] if kind != "H" else here.imag - base.imag
            here = base + complex(x, y)
            pieces.append(np.array([here]))
        elif kind == "A":
            end = base + complex(*values[5:])
            pieces.append(_arc(here, end, values, flatness))
            here = end
        else:
            points = [base + complex(x, y) for x, y in zip(values[::2], values[1::2], strict=True)]
            if kind in "ST":
                smooth = control is not None and before in ("CS" if kind == "S" else "QT")
                points.insert(0, 2.0 * here - control if smooth and control is not None else here)
            pieces.append(_curve(np.array([here, *points]), flatness))
            control, here = points[-2], points[-1]
        before = kind
    yield from _ring(pieces)


def _ring(pieces: list[ComplexArray]) -> Iterator[ComplexArray]:
    points = np.concatenate(pieces) if pieces else np.empty(0, dtype=np.complex128)
    points = points[points != np.roll(points, 1)]
    if not np.isfinite(points).all():
        raise PathError("a coordinate is not finite")
    if len(points) >= 3:
        yield points


def _commands(data: str) -> Iterator[tuple[str, list[float]]]:
    """Each command with as many values as it takes; those that follow a move draw lines."""
    data = " ".join(data.split())  # expressions take long for blanks in a row
    if _COMMAND.sub("", data).strip():
        raise PathError("a path begins with a command")
    for letter, text in _COMMAND.findall(data):
        count = _ARGUMENTS[letter.upper()]
        pattern = _ARC if count == 7 else _NUMBERS
        if pattern.sub("", text).strip():
            raise PathError("broken numbers in a path")
        found = pattern.findall(text)
        values = [float(value) for value in (itertools.chain(*found) if count == 7 else found)]
        if (count == 0) != (not values) or (count and len(values) % count):
            raise PathError(f"the command {letter} takes {count} numbers")
        if count == 0:
            yield letter, []
        for first in range(0, len(values), count or 1):
            yield letter, values[first : first + count]
            letter = {"M": "L", "m": "l"}.get(letter, letter)


def _curve(controls: ComplexArray, flatness: float) -> ComplexArray:
    """Points, without the first, on a quadratic or cubic Bézier curve."""
    degree = len(controls) - 1
    bend = float(np.abs(np.diff(controls, n=2)).max()) * degree * (degree - 1)
    t = _steps(math.sqrt(bend / (8.0 * flatness)))
    level = [np.broadcast_to(control, t.shape) for control in controls]
    while len(level) > 1:  # de Casteljau
        level = [(1.0 - t) * a + t * b for a, b in itertools.pairwise(level)]
    return np.asarray(level[0])


def _arc(start: complex, end: complex, values: list[float], flatness: float) -> ComplexArray:
    """Points, without the first, on an elliptical arc: on the unit circle, then turned and stretched back."""
    rx, ry, turn, large, sweep = abs(values[0]), abs(values[1]), math.radians(values[2]), values[3], values[4]
    if start == end:
        return np.empty(0, dtype=np.complex128)
    if rx == 0.0 or ry == 0.0:
        return np.array([end])
    axis = cmath.exp(1j * turn)
    half = (start - end) / 2.0 / axis
    half = complex(half.real / rx, half.imag / ry)
    stretch = max(1.0, abs(half))  # radii that do not reach are enlarged
    half /= stretch
    height = math.sqrt(max(0.0, 1.0 / abs(half) ** 2 - 1.0)) * (1.0 if large != sweep else -1.0)
    centre = -1j * half * height
    first, last = cmath.phase(half - centre), cmath.phase(-half - centre)
    angle = (last - first) % math.tau
    angle = angle if sweep else angle - math.tau
    t = first + angle * _steps(abs(angle) / math.sqrt(8.0 * flatness / (stretch * max(rx, ry))))
    circle = centre + np.exp(1j * t)
    points = axis * stretch * (rx * circle.real + 1j * ry * circle.imag) + (start + end) / 2.0
    points[-1] = end
    return np.asarray(points)


def _steps(wanted: float) -> FloatArray:
    count = min(_MAX_CHORDS, max(1, math.ceil(wanted)))
    return np.arange(1, count + 1) / count
