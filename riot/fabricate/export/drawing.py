"""What inlays show: lines along the outlines of both shapes, or a painting. Ours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import shapely

from riot.draw.palette import LIGHT
from riot.draw.texture.names import SIDES
from riot.fabricate import export  # lazy: what samples pictures takes a while to import
from riot.fabricate.export.poses import frames_of
from riot.fabricate.model import polygons
from riot.fabricate.tuning import GRID_MM, SMOOTHING_MM

if TYPE_CHECKING:
    from riot.draw.texture.names import Side
    from riot.draw.texture.paint import Texture
    from riot.fabricate.model import Design, PieceDesign

LINE_MM, INSET_MM = 1.2, 1.6
"""mm: width of the line along an outline, three lines of a nozzle of 0.4 mm, and its distance from the outline."""

LEAST_LINE_MM = 0.4
"""mm: nothing of an inlay is narrower; a line of a nozzle of 0.4 mm."""

LEAST_AREA_MM2 = 1.0
"""mm²: no part of an inlay is smaller; it must stick to the bed by itself."""

OVERCUT_MM = 0.01
"""mm: an inlay reaches so far beyond its region, so that no film of the piece is left where it ends at a wall."""


@dataclass(frozen=True, eq=False)
class Drawing:
    """Colours of inlays, and which regions of a piece have them.

    Parameters
    ----------
    base : "#rrggbb" or None
        Colour of the pieces' own filament, the first; None: every piece keeps its own.
    colours : tuple of "#rrggbb"
        Of the filaments from the second on.
    regions : for each side, for each piece, for each colour, a region
        In the piece's frame, mm: where the piece is solid as deep as inlays are, and where nothing is too narrow. A
        region that ends at a wall reaches `OVERCUT_MM` beyond it. Regions of a side share no area.
    """

    base: str | None
    colours: tuple[str, ...]
    regions: Mapping[Side, tuple[tuple[shapely.Geometry, ...], ...]]


def drawing_of(design: Design, textures: Mapping[Side, Texture] | None = None) -> Drawing | None:
    """What is sunk into the pieces: ``textures`` in few colours, or lines along the outlines; None without inlays."""
    if not design.parameters.inlay:
        return None
    return export.painting.painted_drawing(design, textures) if textures else outline_drawing(design)


def depths(design: Design, side: Side) -> tuple[float, float]:
    """Heights between which the inlays of a side are, mm."""
    height, depth = design.parameters.height, design.parameters.inlay
    return (height - depth, height) if side == "p" else (0.0, depth)


def outline_drawing(design: Design) -> Drawing:
    """A line within P's outline on the front, one within Q's on the back, both of the second filament."""
    transform = design.transform
    regions: dict[Side, tuple[tuple[shapely.Geometry, ...], ...]] = {}
    for side, time, outline in zip(SIDES, (0.0, 1.0), (transform.outline_p(), transform.outline_q()), strict=True):
        whole = shapely.Polygon(design.scale * outline)
        line = whole.buffer(-INSET_MM).difference(whole.buffer(-INSET_MM - LINE_MM))
        frames = frames_of(design, transform.pose(time))
        regions[side] = tuple(
            sunk(design, piece, side, [shapely.transform(line, frame.piece)])
            for piece, frame in zip(design.pieces, frames, strict=True)
        )
    return Drawing(None, (LIGHT["ink"],), regions)


def sunk(
    design: Design, piece: PieceDesign, side: Side, drawn: Sequence[shapely.Geometry]
) -> tuple[shapely.Geometry, ...]:
    """What of some regions a piece takes; those that share a line share its points, and no area."""
    low, high = depths(design, side)
    sections = [slab.section for slab in piece.slabs if slab.low < high and low < slab.high]
    solid, taken = shapely.intersection_all(sections), []
    for region in drawn:
        wide = shapely.intersection(region, solid).buffer(-0.5 * LEAST_LINE_MM).buffer(0.5 * LEAST_LINE_MM)
        kept = [polygon for polygon in polygons(wide) if polygon.area >= LEAST_AREA_MM2]
        taken.append(shapely.union_all(kept).buffer(OVERCUT_MM).simplify(SMOOTHING_MM))
    lines = shapely.union_all([region.boundary for region in taken], grid_size=GRID_MM)
    cells = polygons(shapely.polygonize(shapely.get_parts(lines)))
    owned: list[list[shapely.Polygon]] = [[] for _ in drawn]
    for cell in cells:
        owner = next((k for k, region in enumerate(taken) if region.contains(cell.point_on_surface())), None)
        if owner is not None:
            owned[owner].append(cell)
    return tuple(shapely.coverage_union_all(own) if own else shapely.Polygon() for own in owned)
