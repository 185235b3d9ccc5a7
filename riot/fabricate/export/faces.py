"""The faces of the pieces, and the colours that a texture has there. Ours."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import shapely

from riot.draw.texture.sample import sample_region
from riot.fabricate.model import polygons

if TYPE_CHECKING:
    from riot.draw.texture.names import Side
    from riot.draw.texture.paint import Texture
    from riot.draw.texture.source import ByteArray
    from riot.fabricate.export.paper import Frame
    from riot.fabricate.model import Design
    from riot.types import FloatArray


def face(design: Design, index: int, side: Side) -> shapely.Polygon:
    """The upper face of a piece (side "p") or the lower one ("q") within its outline, in its own frame, mm.

    What it gives up for its neighbours' knuckles is left out, and so is what of its own knuckles stands off.
    """
    piece = design.pieces[index]
    slab = piece.slabs[-1 if side == "p" else 0]
    within = polygons(shapely.intersection(slab.section, shapely.Polygon(piece.outline)))
    return max(within, key=lambda polygon: float(polygon.area))


def face_pixels(
    design: Design, texture: Texture, side: Side, index: int, frame: Frame, region: shapely.Polygon, step: float
) -> tuple[ByteArray, tuple[float, float, float, float]]:
    """A piece's texture in a region of the paper: (rows, columns, 3) uint8, first row at the top, and its box in mm.

    ``step`` is the size of a pixel in mm (`riot.draw.texture.sample.sample_region`).
    """
    return sample_region(region, step, face_colours(design, texture, side, index, frame, step))


def face_colours(
    design: Design, texture: Texture, side: Side, index: int, frame: Frame, step: float
) -> Callable[[FloatArray], ByteArray]:
    """A function from (k, 2) points of the paper, mm, to the (k, 3) colours a piece's texture has there."""
    pose = design.transform.pose(0.0 if side == "p" else 1.0)

    def colours(points: FloatArray) -> ByteArray:
        return texture.colours(index, pose.place(index, frame.piece(points) / design.scale), step / design.scale)

    return colours
