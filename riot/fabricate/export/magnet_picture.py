"""Picture of the two free ends with their magnets: which way the marked face of each looks. Ours."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import shapely

from riot.draw.palette import hue
from riot.draw.scene import Line, Mark, moved
from riot.fabricate.export.paper import Frame, number_marks, region_mark
from riot.transform.pose import rotate

if TYPE_CHECKING:
    from riot.fabricate.model import Design
    from riot.fabricate.pocket import Pocket

_APART_MM, _ARROW_MM, _BARB_MM = 12.0, 5.0, 1.6
"""mm: between the ends; length of an arrow from a magnet's face; of its barbs, to either side."""


def magnet_marks(design: Design, room: tuple[float, float]) -> list[Mark]:
    """The pieces at the open hinge about the origin, within a width and a height in mm.

    An arrow at each magnet points to where its marked face looks.
    """
    after = design.pieces[design.motion.open_hinge]
    before = design.pieces[after.index - 1]
    shown = {before: Frame(0.0, -before.length - 0.5 * _APART_MM, 0.0), after: Frame(0.0, 0.5 * _APART_MM, 0.0)}
    regions = {piece: frame.region(shapely.Polygon(piece.outline)) for piece, frame in shown.items()}
    x0, y0, x1, y1 = shapely.union_all(list(regions.values())).bounds
    scale = min(1.0, room[0] / (x1 - x0), room[1] / (y1 - y0))
    shift = -0.5 * scale * np.array([x0 + x1, y0 + y1])
    marks: list[Mark] = []
    for piece, frame in shown.items():
        marks.append(region_mark(regions[piece], f"piece{hue(piece.index, len(design.pieces))}"))
        for pocket in piece.pockets:
            marks += _magnet(design, pocket, frame)
    marks = moved(marks, float(shift[0]), float(shift[1]), scale)
    for piece, region in regions.items():
        middle = np.array(shapely.maximum_inscribed_circle(region).coords[0])
        x, y = (scale * middle + shift).tolist()
        marks += number_marks(x, y, piece.index + 1, 2.8)
    return marks


def _magnet(design: Design, pocket: Pocket, frame: Frame) -> list[Mark]:
    box = pocket.box(0.0, design.parameters.magnet_height_mm, design.parameters.magnet_mm)
    tail, tip = (-0.5, -_ARROW_MM) if pocket.pole == "north" else (-_ARROW_MM, -0.5)
    back = tip + math.copysign(_BARB_MM, tail - tip)
    strokes = [[tail, 0.0], [tip, 0.0]], [[back, _BARB_MM], [tip, 0.0], [back, -_BARB_MM]]
    place = np.array([pocket.x, pocket.y])
    lines = [frame.paper(rotate(np.array(stroke), pocket.heading) + place) for stroke in strokes]
    return [region_mark(frame.region(box), "hinge"), *(Line(line, "outline") for line in lines)]
