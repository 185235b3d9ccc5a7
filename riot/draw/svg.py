"""Scenes as SVG, written by hand: whole files, and fragments for a page that holds the style sheet once. Ours.

The text is deterministic: coordinates are whole numbers, a thousand to a unit, and names of pieces come from their
geometry. y points down in SVG, so it is turned over here and nowhere else.
"""

from __future__ import annotations

import hashlib
import html
import math
from collections.abc import Callable, Iterable, Mapping

import numpy as np

from riot.draw.palette import LIGHT, PENS, PIECES, Pen, colour, hue
from riot.draw.scene import Dot, Label, Mark, Part, Path, Scene
from riot.shape import FloatArray
from riot.transform import Piece

UNITS = 1000
"""SVG units per unit of the scene: a thousandth of a unit-area shape is the finest detail in a picture."""

FONT = "ui-sans-serif, system-ui, 'Segoe UI', 'Helvetica Neue', Arial, sans-serif"

_FORBIDDEN = dict.fromkeys(
    (*range(9), 11, 12, *range(14, 32), 127, *range(0xD800, 0xE000), 0xFFFE, 0xFFFF), "\N{REPLACEMENT CHARACTER}"
)
"""What XML must not hold, even escaped; file names may."""


def escape(text: str) -> str:
    """Text for XML and HTML, between tags or within quotes; characters that XML forbids become U+FFFD."""
    return html.escape(text.translate(_FORBIDDEN), quote=True)


def document(scene: Scene, width: int = 960, scheme: Mapping[str, str] = LIGHT) -> str:
    """The scene as a whole SVG file, ``width`` pixels wide at its natural size."""
    return whole(scene, painted(scene, prefix := naming(scene.pieces)), prefix, width, scheme)


def whole(
    scene: Scene, body: str, prefix: str, width: int = 960, scheme: Mapping[str, str] = LIGHT, style: str = ""
) -> str:
    """An SVG file of a scene's frame, style and pieces around a body that is already SVG."""
    x0, y0, x1, y1 = scene.box
    height = round(width * (y1 - y0) / (x1 - x0))
    left, top, wide, high = _view(scene)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{left} {top} {wide} {high}" width="{width}" '
        f'height="{height}" role="img"><title>{escape(scene.title)}</title>'
        f"<style>{_file_style(scene.pen, scheme)}{style}</style>"
        f'<rect x="{left}" y="{top}" width="{wide}" height="{high}" fill="{scheme["paper"]}"/>'
        f"{definitions(scene.pieces, prefix)}{body}</svg>\n"
    )


def fragment(scene: Scene, prefix: str, body: str | None = None, kind: str = "") -> str:
    """The scene as an ``<svg>`` element for a page with `page_style` and, under ``prefix``, `definitions`.

    ``body`` replaces the scene's marks by SVG text; ``kind`` is a further class.
    """
    left, top, wide, high = _view(scene)
    inner = painted(scene, prefix) if body is None else body
    named = f"riot {kind}".strip()
    return (
        f'<svg class="{named}" viewBox="{left} {top} {wide} {high}" role="img">'
        f"<title>{escape(scene.title)}</title>{inner}</svg>"
    )


def naming(pieces: Iterable[Piece]) -> str:
    """A prefix for the pieces' ids that depends on their drawn geometry alone."""
    text = "|".join(path_data(piece.polygon) for piece in pieces)
    return f"r{hashlib.sha256(text.encode()).hexdigest()[:8]}-"


def definitions(pieces: tuple[Piece, ...], prefix: str) -> str:
    """The ``<defs>`` of the pieces, ids ``prefix0`` …: each drawn once, with the seam along its trunk edge."""
    groups = [
        f'<g id="{prefix}{i}"><path class="r-piece{hue(i, len(pieces))}" d="{path_data(piece.polygon)}"/>'
        f'<path class="r-seam" d="M0 0H{_whole(piece.length)}"/></g>'
        for i, piece in enumerate(pieces)
    ]
    return f"<defs>{''.join(groups)}</defs>" if groups else ""


def painted(scene: Scene, prefix: str) -> str:
    """The scene's marks as SVG text."""
    return "".join(_mark(mark, prefix, scene.pen) for mark in scene.marks)


def path_data(points: FloatArray, closed: bool = True) -> str:
    """Path data of (k, 2) points, y up: whole numbers, relative after the first, repeated points left out."""
    grid = np.rint(points * [UNITS, -UNITS]).astype(np.int64)
    steps = np.diff(grid, axis=0)
    steps = steps[(steps != 0).any(axis=1)]
    text = f"M{grid[0, 0]} {grid[0, 1]}"
    if len(steps):
        text += "l" + "".join(f"{_joined(dx)}{_joined(dy)}" for dx, dy in steps.tolist()).lstrip()
    return text + ("z" if closed else "")


def turn(heading: float) -> str:
    """Degrees, clockwise as SVG has them, of a heading in radians; within a full turn either way."""
    degrees = round(-math.degrees(math.remainder(heading, 2.0 * math.pi)), 2)
    return f"{degrees + 0.0:.6g}"


def place(x: float, y: float) -> str:
    """A point, y up, as the two numbers of a translation."""
    return f"{_whole(x)} {_whole(-y)}"


def page_style() -> str:
    """Rules for all fragments of a page: colours are variables ``--r-…``, widths are pixels whatever the scale."""
    # One rule a pen, without ancestors: selectors do not see beyond the shadow tree in which <use> shows a piece.
    rules = (_rule(name, pen, 1.0, lambda token: f"var(--r-{token})") for name, pen in PENS.items())
    return "".join(rule.replace("}", ";vector-effect:non-scaling-stroke}") for rule in rules)


def page_colours(scheme: Mapping[str, str]) -> str:
    """The values of the variables that `page_style` uses."""
    tokens = dict(scheme) | {f"piece{k}": value for k, value in enumerate(PIECES)}
    return "".join(f"--r-{token}:{value};" for token, value in tokens.items())


def _file_style(pen: float, scheme: Mapping[str, str]) -> str:
    rules = [f"text{{font-family:{FONT}}}"]
    rules += [_rule(name, value, pen * UNITS, lambda token: colour(token, scheme)) for name, value in PENS.items()]
    return "".join(rules)


def _rule(name: str, pen: Pen, unit: float, paint: Callable[[str], str]) -> str:
    parts = [f"fill:{paint(pen.fill) if pen.fill else 'none'}"]
    if pen.stroke:
        parts += [f"stroke:{paint(pen.stroke)}", f"stroke-width:{_number(pen.width * unit)}"]
        parts += ["stroke-linejoin:round", "stroke-linecap:round"]
    if pen.dash:
        parts.append(f"stroke-dasharray:{' '.join(_number(step * unit) for step in pen.dash)}")
    if pen.opacity < 1.0:
        parts.append(f"opacity:{_number(pen.opacity)}")
    return f".r-{name}{{{';'.join(parts)}}}"


def _mark(mark: Mark, prefix: str, pen: float) -> str:
    if isinstance(mark, Path):
        return f'<path class="r-{mark.pen}" d="{path_data(mark.points, mark.closed)}"/>'
    if isinstance(mark, Part):
        scaled = "" if mark.scale == 1.0 else f"scale({_number(mark.scale)})"
        moves = f"translate({place(mark.x, mark.y)})rotate({turn(mark.heading)}){scaled}"
        return f'<use href="#{prefix}{mark.piece}" transform="{moves}"/>'
    if isinstance(mark, Dot):
        return dot(mark, pen)
    return _label(mark, pen)


def dot(mark: Dot, pen: float) -> str:
    """A dot as a ``<circle>``."""
    centre = f'cx="{_whole(mark.x)}" cy="{_whole(-mark.y)}"'
    return f'<circle class="r-{mark.pen}" {centre} r="{_whole(mark.radius * pen)}"/>'


def _label(mark: Label, pen: float) -> str:
    anchor = "" if mark.anchor == "start" else f' text-anchor="{mark.anchor}"'
    weight = "" if mark.weight == "normal" else f' font-weight="{mark.weight}"'
    where = f'x="{_whole(mark.x)}" y="{_whole(-mark.y)}" font-size="{_whole(mark.size * pen)}"'
    return f'<text class="r-{mark.pen}" {where}{anchor}{weight}>{escape(mark.text)}</text>'


def _view(scene: Scene) -> tuple[int, int, int, int]:
    x0, y0, x1, y1 = scene.box
    left, top = math.floor(x0 * UNITS), math.floor(-y1 * UNITS)
    return left, top, math.ceil(x1 * UNITS) - left, math.ceil(-y0 * UNITS) - top


def _whole(value: float) -> int:
    return round(value * UNITS)


def _number(value: float) -> str:
    return f"{value:.4g}"


def _joined(value: int) -> str:
    return str(value) if value < 0 else f" {value}"
