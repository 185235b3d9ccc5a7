"""The parts that a laser cuts from sheets, each in its own frame: outlines, layers of knuckles, strips of cloth. Ours.

Outlines are joined by strips of cloth or tape, layers by pins. A living hinge, a lattice of cuts, is not among the
kinds: it bends out of the sheet's plane, and the hinges of these puzzles turn within it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
import shapely

from riot.errors import FabricationError
from riot.fabricate.export.engraving import letters, marks
from riot.fabricate.model import Design, PieceDesign, polygons

Kind = Literal["outlines", "layers", "strips"]
KINDS: tuple[Kind, ...] = get_args(Kind)
LAYERS = ("bottom", "top")

STRIP_REACH_MM = 12.0
"""mm: a strip goes so far from the hinge along the wall of either piece, if the walls are long enough."""

TICK_MM = 3.0
"""mm: length of the scored line where a strip ends."""

_MITRE = 10.0
_EMPTY = shapely.MultiPolygon()


@dataclass(frozen=True, eq=False)
class FlatPart:
    """A part to be cut out, in mm: its ``region``, what is engraved on it, lines that are scored, how many there are.

    ``through`` are lines that are cut within the region. ``name`` is as in ``piece-1`` or ``piece-1-top``.
    """

    name: str
    region: shapely.Polygon
    engraved: shapely.Geometry = _EMPTY
    scored: shapely.Geometry = _EMPTY
    through: shapely.Geometry = _EMPTY
    copies: int = 1


def sheets_of_a_layer(design: Design, kind: Kind) -> int:
    """How many sheets of the material make up a part's thickness: half of the puzzle's for layers."""
    thickness = design.parameters.height / (len(LAYERS) if kind == "layers" else 1)
    return max(1, math.ceil(thickness / design.parameters.sheet_mm - 0.5))  # of two as good the fewer


def stack_mm(design: Design, kind: Kind) -> float:
    """Thickness of the puzzle that is made from sheets."""
    return sheets_of_a_layer(design, kind) * design.parameters.sheet_mm * (len(LAYERS) if kind == "layers" else 1)


def flat_parts(design: Design, kind: Kind) -> list[FlatPart]:
    """The parts of one kind at nominal size.

    Raises `riot.errors.FabricationError` ``telescopic`` or ``in-place`` for layers of a design with such hinges, which
    cannot be stacked from sheets.
    """
    if kind == "strips":
        return _strips(design)
    return _outlines(design) if kind == "outlines" else _layers(design)


def compensated(part: FlatPart, kerf: float) -> FlatPart:
    """The path of the beam's middle: mitred, so that the part's corners stay as they are."""
    if kerf == 0.0:
        return part
    grown = polygons(shapely.buffer(part.region, 0.5 * kerf, join_style="mitre", mitre_limit=_MITRE))
    return replace(part, region=max(grown, key=lambda polygon: float(polygon.area)))


def _up(design: Design, index: int) -> float:
    """Where the top of the first shape is, in a piece's frame; radians."""
    return 0.5 * math.pi - float(design.transform.pose(0.0).headings[index])


def _outlines(design: Design) -> list[FlatPart]:
    copies = sheets_of_a_layer(design, "outlines")
    parts = []
    for piece in design.pieces:
        region = shapely.Polygon(piece.outline)
        engraved = marks(str(piece.index + 1), region, _up(design, piece.index))
        parts.append(FlatPart(piece.name, region, engraved, _ticks(design, piece, region), copies=copies))
    return parts


def _layers(design: Design) -> list[FlatPart]:
    """Every piece at the heights of the lower and of the upper knuckles, below the heads of pins."""
    if not design.stackable:
        kind = "telescopic" if design.telescope is not None else "in-place"
        raise FabricationError(
            kind,
            f"this puzzle has {kind} hinges, which cannot be stacked from sheets: print it, or cut its outlines",
            "",
        )
    (lower, upper), layer = design.parameters.levels, design.parameters.layer_mm
    middles = (lower - 0.5 * layer, upper + 0.5 * layer)
    parts = []
    for piece in design.pieces:
        slots = shapely.union_all([pocket.room(level) for pocket in piece.pockets for level in pocket.levels])
        for name, middle in zip(LAYERS, middles, strict=True):
            sections = [slab.section for slab in piece.slabs if slab.low <= middle < slab.high]
            regions = polygons(shapely.difference(shapely.union_all(sections), slots))
            for k, region in enumerate(regions):
                more = f"-{k + 1}" if len(regions) > 1 else ""
                engraved = marks(f"{piece.index + 1}{name[0].upper()}", region, _up(design, piece.index))
                copies = sheets_of_a_layer(design, "layers")
                parts.append(FlatPart(f"{piece.name}-{name}{more}", region, engraved, copies=copies))
    return parts


def _reach(design: Design, piece: PieceDesign) -> float:
    """How far a strip goes along the upper arc of a piece from either hinge, mm."""
    arc = shapely.LineString(design.scale * design.transform.pieces[piece.index].upper)
    return min(STRIP_REACH_MM, 0.45 * float(arc.length))


def _ticks(design: Design, piece: PieceDesign, region: shapely.Polygon) -> shapely.Geometry:
    """Lines across the wall, on the side of the second shape's outline, where the strips of both hinges end."""
    arc = shapely.LineString(design.scale * design.transform.pieces[piece.index].upper)
    reach = _reach(design, piece)
    lines = []
    for end, at in ((piece.start, reach), (piece.end, float(arc.length) - reach)):
        if end.kind != "pin":
            continue
        point, ahead = (shapely.get_coordinates(arc.interpolate(at + step))[0] for step in (0.0, 0.1))
        along = (ahead - point) / np.hypot(*(ahead - point))
        across = TICK_MM * np.array([-along[1], along[0]])
        lines.append(shapely.LineString([point - across, point + across]))
    return shapely.intersection(shapely.MultiLineString(lines), shapely.buffer(region, -0.2))


def _strips(design: Design) -> list[FlatPart]:
    """A strip for every pin hinge, folded along its middle, as wide as the puzzle of glued outlines is thick."""
    parts = []
    width = stack_mm(design, "outlines")
    for i, piece in enumerate(design.pieces):
        if piece.start.kind != "pin":
            continue
        before, after = _reach(design, design.pieces[i - 1]), _reach(design, piece)
        middle = shapely.LineString([(0.0, 0.0), (0.0, width)])
        words = letters(f"{(i - 1) % len(design.pieces) + 1}-{i + 1}", min(3.0, 0.5 * width))
        engraved = shapely.transform(words, lambda points: points + np.array([1.0, 0.25 * width]))
        engraved = engraved if engraved.bounds[2] < after else _EMPTY
        region = shapely.box(-before, 0.0, after, width)
        parts.append(FlatPart(f"strip-{i + 1}", region, engraved, middle))
    return parts
