"""Trays on paper and for a laser: a picture with the puzzle in its tray; a base and frames, to be glued. Ours."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import shapely

from riot.draw.palette import hue
from riot.draw.scene import Mark, moved
from riot.fabricate.export.engraving import marks
from riot.fabricate.export.flat_parts import FlatPart
from riot.fabricate.export.paper import region_mark
from riot.fabricate.export.poses import closed
from riot.fabricate.outlines import polygons_by_area
from riot.fabricate.tray import TRAY_TIMES

if TYPE_CHECKING:
    from riot.fabricate.model import Design
    from riot.fabricate.solid import Part


def tray_flat_parts(design: Design, trays: tuple[Part, ...]) -> list[FlatPart]:
    """A base and the frames of every tray, which together are about as deep as the printed recess."""
    parts = []
    for tray in trays:
        floor, frame = tray.slabs
        frames = max(1, math.ceil((frame.high - frame.low) / design.parameters.sheet_mm - 0.5))
        base, rim = (polygons_by_area(slab.section)[0] for slab in (floor, frame))
        letter = tray.name[-1].upper()
        parts.append(FlatPart(f"{tray.name}-base", base, marks(letter, base, 0.5 * math.pi)))
        parts.append(FlatPart(f"{tray.name}-frame", rim, copies=frames))
    return parts


def tray_marks(design: Design, tray: Part, room: tuple[float, float]) -> list[Mark]:
    """The closed puzzle in a tray about the origin, within a width and a height in mm."""
    floor, frame = tray.slabs
    frames = closed(design, TRAY_TIMES[tray.name])
    shown: list[Mark] = [
        region_mark(floor.section, "open"),
        region_mark(floor.section.difference(frame.section), "silhouette"),
    ]
    for piece, placed in zip(design.pieces, frames, strict=True):
        region = placed.region(shapely.Polygon(piece.outline))
        shown.append(region_mark(region, f"piece{hue(piece.index, len(design.pieces))}"))
    x0, y0, x1, y1 = floor.section.bounds
    scale = min(1.0, room[0] / (x1 - x0), room[1] / (y1 - y0))
    return moved(shown, -0.5 * scale * (x0 + x1), -0.5 * scale * (y0 + y1), scale)
