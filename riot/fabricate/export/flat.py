"""Flat files: what a laser cuts, as SVG and DXF at true size in millimetres. Ours.

Two kinds: the bare outlines of the pieces, cut from one sheet; and the three layers of every piece with knuckles and
pin holes, to be stacked and glued from sheets a third of the thickness.
"""

from __future__ import annotations

import importlib
import io
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import shapely

from riot.draw.svg import escape
from riot.errors import FabricationError, RiotError, needs_extra
from riot.fabricate.model import Design, polygons
from riot.fabricate.shelves import shelves
from riot.types import FloatArray

Kind = Literal["outlines", "layers"]
KINDS: tuple[Kind, ...] = get_args(Kind)
LAYERS = ("bottom", "middle", "top")

LASER_FORMATS = (".svg", ".dxf")

LASER_SPACE_MM = 5.0
"""Between parts on a sheet, and around them."""

SHEET_MM = 600.0
"""Width of a sheet, unless a part is wider; it is as long as it must be."""

HAIRLINE_MM = 0.01

FLAT_DIGITS = 6
"""Decimals of a coordinate in mm."""

_MITRE = 10.0
_COLOURS = {"holes": "#0000ff", "outlines": "#ff0000"}
_DXF_COLOURS = {"holes": 5, "outlines": 1}


class FlatFormatError(RiotError, ValueError):
    """A file name whose suffix is no format for lasers."""


@dataclass(frozen=True, eq=False)
class FlatPart:
    """One part to be cut out: ``region`` in mm, on the sheet; ``name`` as in ``piece-1`` or ``piece-1-top``."""

    name: str
    region: shapely.Polygon


def write_flat(design: Design, path: str | os.PathLike[str], kind: Kind = "outlines", *, kerf: bool = False) -> None:
    """Write the pieces for a laser, apart on one sheet; the suffix (svg, dxf) chooses the format.

    With ``kerf`` the laser's path is half the kerf outside the parts (inside the holes), so that they come out at
    nominal size. Every part is one closed path, and so is every hole; holes are before outlines. The same design gives
    the same bytes.

    Raises
    ------
    FlatFormatError
        For another suffix.
    riot.errors.MissingExtraError
        If a DXF file is asked for and ezdxf is not installed.
    riot.errors.FabricationError
        ``telescopic``: layers of a design with telescopic hinges, which cannot be stacked from sheets.
    """
    target = Path(path)
    if target.suffix.lower() not in LASER_FORMATS:
        raise FlatFormatError(f"cannot write {target.name!r} for a laser: use a file name that ends in .svg or .dxf")
    parts = parts_of(design, kind, design.parameters.kerf_mm if kerf else 0.0)
    title = f"{design.transform.p.name or 'P'} and {design.transform.q.name or 'Q'}, {kind}"
    data = svg_bytes(parts, title) if target.suffix.lower() == ".svg" else dxf_bytes(parts)
    target.write_bytes(data)


def write_flat_files(design: Design, folder: Path, *, dxf: bool = True) -> list[Path]:
    """Write all flat files into a folder that exists: ``laser-outlines.svg``, ``laser-outlines-kerf.svg`` and so on.

    Layers are left out if the design has telescopic hinges. Errors as `write_flat`.
    """
    written = []
    for kind in KINDS if design.telescope is None else KINDS[:1]:
        for suffix in LASER_FORMATS if dxf else LASER_FORMATS[:1]:
            for kerf in (False, True):
                written.append(folder / f"laser-{kind}{'-kerf' if kerf else ''}{suffix}")
                write_flat(design, written[-1], kind, kerf=kerf)
    return written


def parts_of(design: Design, kind: Kind, kerf: float = 0.0) -> list[FlatPart]:
    """The parts of one kind, apart on a sheet, widened all round by half a kerf in mm; errors as `write_flat`."""
    parts = _outlines(design) if kind == "outlines" else _layers(design)
    if kerf > 0.0:
        parts = [_compensated(flat_part, kerf) for flat_part in parts]
    return _apart(parts)


def _outlines(design: Design) -> list[FlatPart]:
    return [FlatPart(piece.name, shapely.Polygon(piece.outline)) for piece in design.pieces]


def _layers(design: Design) -> list[FlatPart]:
    """Every piece at the heights of the lower female, the male and the upper female knuckles."""
    if design.telescope is not None:
        raise FabricationError(
            "telescopic",
            "this puzzle has telescopic hinges, which cannot be stacked from sheets: print it, or cut its outlines",
            "",
        )
    height, levels = design.parameters.height, design.parameters.levels
    middles = (0.5 * levels[0], 0.5 * height, 0.5 * (levels[3] + height))
    parts = []
    for piece in design.pieces:
        for name, middle in zip(LAYERS, middles, strict=True):
            sections = [slab.section for slab in piece.slabs if slab.low <= middle < slab.high]
            regions = polygons(shapely.union_all(sections))
            for k, region in enumerate(regions):
                more = f"-{k + 1}" if len(regions) > 1 else ""
                parts.append(FlatPart(f"{piece.name}-{name}{more}", region))
    return parts


def _compensated(flat_part: FlatPart, kerf: float) -> FlatPart:
    """The path of the beam's middle: mitred, so that the parts' corners stay as they are."""
    grown = polygons(shapely.buffer(flat_part.region, 0.5 * kerf, join_style="mitre", mitre_limit=_MITRE))
    return replace(flat_part, region=grown[0])


def _apart(parts: Sequence[FlatPart]) -> list[FlatPart]:
    bounds = np.array([flat_part.region.bounds for flat_part in parts])
    sizes = bounds[:, 2:] - bounds[:, :2]
    width = max(SHEET_MM, float(sizes[:, 0].max()) + 2 * LASER_SPACE_MM)
    spots = shelves(sizes, width - 2 * LASER_SPACE_MM, np.inf, LASER_SPACE_MM)
    return [
        replace(
            flat_part,
            region=_moved(flat_part.region, spot.x + LASER_SPACE_MM - low[0], spot.y + LASER_SPACE_MM - low[1]),
        )
        for flat_part, spot, low in zip(parts, spots, bounds, strict=True)
    ]


def _moved(region: shapely.Polygon, x: float, y: float) -> shapely.Polygon:
    return shapely.transform(region, lambda points: points + np.array([x, y]))


def _rings(parts: Iterable[FlatPart]) -> tuple[list[tuple[str, FloatArray]], list[tuple[str, FloatArray]]]:
    """Holes and outlines by name, each point once."""
    holes, outlines = [], []
    for flat_part in parts:
        outlines.append((flat_part.name, shapely.get_coordinates(flat_part.region.exterior)[:-1]))
        for k, ring in enumerate(flat_part.region.interiors):
            holes.append((f"{flat_part.name}-hole-{k + 1}", shapely.get_coordinates(ring)[:-1]))
    return holes, outlines


def _extent(parts: Sequence[FlatPart]) -> tuple[float, float]:
    high = np.max([flat_part.region.bounds[2:] for flat_part in parts], axis=0) + LASER_SPACE_MM
    return float(high[0]), float(high[1])


def svg_bytes(parts: Sequence[FlatPart], title: str) -> bytes:
    """The parts as an SVG file whose user unit is the millimetre, y turned over."""
    width, height = _extent(parts)
    wide, high = _number(width), _number(height)
    text = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide}mm" height="{high}mm" viewBox="0 0 {wide} {high}">',
        f"<title>{escape(title)}</title>",
    ]
    for name, rings in zip(("holes", "outlines"), _rings(parts), strict=True):
        if rings:
            text.append(f'<g id="{name}" fill="none" stroke="{_COLOURS[name]}" stroke-width="{HAIRLINE_MM}">')
            text += [f'<path id="{ring}" d="{_path(points, height)}"/>' for ring, points in rings]
            text.append("</g>")
    return ("\n".join([*text, "</svg>"]) + "\n").encode()


def _path(points: FloatArray, height: float) -> str:
    flipped = points * [1.0, -1.0] + [0.0, height]
    return "M" + "L".join(f"{_number(x)} {_number(y)}" for x, y in flipped.tolist()) + "Z"


def _number(value: float) -> str:
    return f"{value:.{FLAT_DIGITS}f}".rstrip("0").rstrip(".")


def dxf_module() -> Any:
    """The module that writes DXF; raises `riot.errors.MissingExtraError` if it is not installed."""
    with needs_extra("print"):
        return importlib.import_module("ezdxf")


def dxf_bytes(parts: Sequence[FlatPart]) -> bytes:
    """The parts as a DXF file in millimetres, holes and outlines on a layer each; raises as `dxf_module`."""
    ezdxf = dxf_module()
    fixed = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True  # no dates: the same parts give the same bytes
    try:
        drawing = ezdxf.new("R2000", units=ezdxf.units.MM)
        space = drawing.modelspace()
        for name, rings in zip(("holes", "outlines"), _rings(parts), strict=True):
            drawing.layers.add(name.upper(), color=_DXF_COLOURS[name], lineweight=0)
            for _, points in rings:
                corners = np.round(points, FLAT_DIGITS).tolist()
                space.add_lwpolyline(corners, close=True, dxfattribs={"layer": name.upper()})
        # The drawing's extent; its lower corner must not be the origin, which ezdxf takes for none.
        space.reset_extents((LASER_SPACE_MM, LASER_SPACE_MM, 0.0), (*_extent(parts), 0.0))
        stream = io.StringIO()
        drawing.write(stream)
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = fixed
    return stream.getvalue().encode()
