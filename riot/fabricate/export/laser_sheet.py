"""Sheets for a laser: parts nested into the bed, as SVG and DXF at true size in millimetres. Ours.

Three layers, in the order in which a laser does them: *engrave* (regions to be filled), *score* (lines on the surface),
*cut* (holes before outlines). Their colours are the first three of LightBurn's palette, which takes a colour for a
layer (https://docs.lightburnsoftware.com/2.0/GetStarted/ColorsAndLayers); black, blue and red are what workshops use
for these tasks (https://www.purdue.edu/bidc/start/laser-engraving-and-cutting/lineweights-and-colors/). Groups are
layers of Inkscape by its attributes ``groupmode`` and ``label`` (The Inkscape manual, "Groups of objects").
"""

from __future__ import annotations

import importlib
import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import shapely

from riot.draw.palette import LASER_COLOURS
from riot.draw.svg_text import escape
from riot.errors import FabricationError, needs_extra
from riot.fabricate.export.flat_parts import FlatPart, compensated
from riot.fabricate.export.nesting import Nested, nest
from riot.fabricate.model import polygons
from riot.parameters import FabricationParameters
from riot.types import FloatArray

LASER_SPACE_MM = 3.0
"""Between parts on a sheet, and around them; the nominal kerf is a twentieth of it."""

STROKE_MM = 0.15
"""Width of lines in SVG: thinner ones are invisible in some viewers, and wider ones than half a point (0.18 mm) are no
cuts to drivers that print (the page of a workshop that the module names)."""

FLAT_DIGITS = 6
"""Decimals of a coordinate in mm."""

_DXF_COLOURS = {"engrave": 7, "score": 5, "cut": 1}
_PLACED = ("region", "engraved", "scored", "through")
_INKSCAPE = "http://www.inkscape.org/namespaces/inkscape"


@dataclass(frozen=True, eq=False)
class LaserSheet:
    """One sheet, in mm: its size, and parts in its frame, y up."""

    width: float
    height: float
    parts: tuple[FlatPart, ...]


def laser_sheets(
    parts: Sequence[FlatPart], parameters: FabricationParameters, *, kerf: bool = False
) -> list[LaserSheet]:
    """`sheets_by_kerf` with compensation of the kerf, or without."""
    return sheets_by_kerf(parts, parameters)[kerf]


def sheets_by_kerf(
    parts: Sequence[FlatPart], parameters: FabricationParameters
) -> tuple[list[LaserSheet], list[LaserSheet]]:
    """Nest parts, as often as each is needed, into sheets of the bed's size: at nominal size, and for the kerf.

    The places are the same. For the kerf outlines are half a kerf outside the parts, and inside their holes. Raises
    `riot.errors.FabricationError` ``bed`` if a part is larger than the bed.
    """
    copies = [part for part in parts for _ in range(part.copies)]
    widened = [compensated(part, parameters.kerf_mm) for part in copies]
    width, height = parameters.bed_width_mm, parameters.bed_depth_mm
    try:
        spots = nest([part.region for part in widened], width, height, LASER_SPACE_MM)
    except ValueError as error:
        raise FabricationError(
            "bed",
            f"{copies[error.args[1]].name} does not fit on the bed of {width:g} × {height:g} mm: lessen size_mm "
            f"({parameters.size_mm:g}), or tell of a larger bed (bed_width_mm, bed_depth_mm)",
            "bed_width_mm",
        ) from None
    count = 1 + max(spot.sheet for spot in spots)
    nominal, for_kerf = (
        [
            LaserSheet(width, height, tuple(part for part, spot in placed if spot.sheet == number))
            for number in range(count)
        ]
        for placed in (
            [(_placed(part, spot), spot) for part, spot in zip(kind, spots, strict=True)] for kind in (copies, widened)
        )
    )
    return nominal, for_kerf


def _placed(part: FlatPart, spot: Nested) -> FlatPart:
    return replace(part, **{name: spot.place(getattr(part, name)) for name in _PLACED}, copies=1)


def svg_bytes(sheet: LaserSheet, title: str) -> bytes:
    """The sheet as an SVG file whose user unit is the millimetre, y turned over."""
    wide, high = _number(sheet.width), _number(sheet.height)
    text = [
        f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="{_INKSCAPE}" '
        f'width="{wide}mm" height="{high}mm" viewBox="0 0 {wide} {high}">',
        f"<title>{escape(title)}</title>",
    ]
    for name, paths in _layers(sheet.parts).items():
        colour = LASER_COLOURS[name]
        look = f'fill="{colour}" fill-rule="evenodd" stroke="none"'
        if name != "engrave":
            look = f'fill="none" stroke="{colour}" stroke-width="{STROKE_MM}"'
        text.append(f'<g id="{name}" inkscape:groupmode="layer" inkscape:label="{name}" {look}>')
        text += [
            f'<path id="{path.name}" d="{"".join(_path(line, sheet.height, path.closed) for line in path.lines)}"/>'
            for path in _named_once(paths)
        ]
        text.append("</g>")
    return ("\n".join([*text, "</svg>"]) + "\n").encode()


@dataclass(frozen=True, eq=False)
class _Path:
    """Lines (k, 2) of one name, each point once."""

    name: str
    lines: tuple[FloatArray, ...]
    closed: bool = True


def _layers(parts: Sequence[FlatPart]) -> dict[str, list[_Path]]:
    """Paths by layer, in the order of work: of what is cut, holes and inner lines come before outlines."""
    layers: dict[str, list[_Path]] = {"engrave": [], "score": [], "cut": []}
    for part in parts:
        rings = [ring for polygon in polygons(part.engraved) for ring in (polygon.exterior, *polygon.interiors)]
        if rings:
            layers["engrave"].append(_Path(f"{part.name}-number", tuple(map(_open, rings))))
        layers["score"] += _lines(f"{part.name}-mark", part.scored)
        layers["cut"] += [_Path(f"{part.name}-hole", (_open(ring),)) for ring in part.region.interiors]
        layers["cut"] += _lines(f"{part.name}-line", part.through)
    layers["cut"] += [_Path(part.name, (_open(part.region.exterior),)) for part in parts]
    return layers


def _lines(name: str, lines: shapely.Geometry) -> list[_Path]:
    return [_Path(name, (shapely.get_coordinates(line),), False) for line in shapely.get_parts(lines) if line.length]


def _open(ring: shapely.LinearRing) -> FloatArray:
    points: FloatArray = shapely.get_coordinates(ring)[:-1]
    return points


def _named_once(paths: Iterable[_Path]) -> Iterator[_Path]:
    """The paths, with a number at the end of a name that was there before: ids of a file differ."""
    count: dict[str, int] = {}
    for path in paths:
        count[path.name] = count.get(path.name, 0) + 1
        yield path if count[path.name] == 1 else replace(path, name=f"{path.name}-{count[path.name]}")


def _path(points: FloatArray, height: float, closed: bool) -> str:
    flipped = points * [1.0, -1.0] + [0.0, height]
    return "M" + "L".join(f"{_number(x)} {_number(y)}" for x, y in flipped.tolist()) + ("Z" if closed else "")


def _number(value: float) -> str:
    return f"{value:.{FLAT_DIGITS}f}".rstrip("0").rstrip(".")


def dxf_module() -> Any:
    """The module that writes DXF; raises `riot.errors.MissingExtraError` if it is not installed."""
    with needs_extra("print"):
        return importlib.import_module("ezdxf")


def dxf_bytes(sheet: LaserSheet) -> bytes:
    """The sheet as a DXF file in millimetres, with the layers ENGRAVE, SCORE and CUT; raises as `dxf_module`."""
    ezdxf = dxf_module()
    fixed = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True  # no dates: the same parts give the same bytes
    try:
        drawing = ezdxf.new("R2000", units=ezdxf.units.MM)
        space = drawing.modelspace()
        for name, paths in _layers(sheet.parts).items():
            layer = name.upper()
            drawing.layers.add(layer, color=_DXF_COLOURS[name], lineweight=0)
            for path in paths:
                for line in path.lines:
                    corners = np.round(line, FLAT_DIGITS).tolist()
                    space.add_lwpolyline(corners, close=path.closed, dxfattribs={"layer": layer})
        # The drawing's extent; its lower corner must not be the origin, which ezdxf takes for none.
        space.reset_extents((LASER_SPACE_MM, LASER_SPACE_MM, 0.0), (sheet.width, sheet.height, 0.0))
        stream = io.StringIO()
        drawing.write(stream)
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = fixed
    return stream.getvalue().encode()
