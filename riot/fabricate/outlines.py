"""Flat regions in millimetres: discs, the outline of a piece, how narrow it is. Ours."""

from __future__ import annotations

import math

import numpy as np
import shapely

from riot.errors import FabricationError
from riot.fabricate.model import PieceDesign, polygons
from riot.fabricate.tuning import (
    CRUMB_SHARE,
    DISC_SIDES,
    GRID_MM,
    KNUCKLES_PER_NECK,
    NECK_HALVINGS,
    NECK_STEPS,
    OUTLINE_SPARE_MM,
    QUARTER_SEGMENTS,
    SIZE_FACTOR,
    SMOOTHING_MM,
    VANISHED_SIZE_FACTOR,
)
from riot.parameters import FabricationParameters
from riot.types import FloatArray


def disc(x: float, y: float, radius: float, *, outside: bool = False, sides: int = DISC_SIDES) -> shapely.Polygon:
    """A regular polygon in a circle, or around it if ``outside``, with upright sides; mm."""
    around = 2.0 * math.pi * (np.arange(sides) + 0.5) / sides
    reach = radius / math.cos(math.pi / sides) if outside else radius
    points = np.array([x, y]) + reach * np.stack([np.cos(around), np.sin(around)], axis=1)
    return shapely.Polygon(np.round(points / GRID_MM) * GRID_MM)


def subtract(region: shapely.Geometry, other: shapely.Geometry) -> shapely.Geometry:
    """What of a region is not in another; on the grid."""
    return shapely.difference(region, other, grid_size=GRID_MM)


def polygons_by_area(region: shapely.Geometry) -> list[shapely.Polygon]:
    """The polygons of a region, the largest first."""
    return sorted(polygons(region), key=lambda polygon: -polygon.area)


def make_outline(points: FloatArray, piece: int, parameters: FabricationParameters) -> shapely.Polygon:
    """A piece (m, 2) in mm, less half the outline gap all round, without holes.

    Raises `riot.errors.FabricationError` if it vanishes or falls apart.
    """
    whole = shapely.Polygon(points)
    shrunk = shapely.simplify(
        whole.buffer(-0.5 * parameters.gap_mm - OUTLINE_SPARE_MM, quad_segs=QUARTER_SEGMENTS), SMOOTHING_MM
    )
    remaining = polygons_by_area(shapely.set_precision(shrunk, GRID_MM))
    if (
        not remaining
        or whole.area - remaining[0].area - 0.5 * parameters.gap_mm * whole.length > CRUMB_SHARE * whole.area
    ):
        if len(remaining) < 2:
            problem, size = "is nowhere wider than the outline gap", VANISHED_SIZE_FACTOR * parameters.size_mm
        else:
            problem, size = f"falls into {len(remaining)} parts where it is narrower than the outline gap", math.nan
        raise FabricationError(
            "falls-apart",
            f"piece-{piece + 1} {problem}: enlarge size_mm ({parameters.size_mm:g}) or lessen gap_mm "
            f"({parameters.gap_mm:g})",
            "size_mm",
            SIZE_FACTOR * parameters.size_mm if math.isnan(size) else size,
        )
    return shapely.Polygon(remaining[0].exterior)


def corner_angle(points: FloatArray, x: float, radius: float) -> float:
    """How wide a piece (m, 2) is around (x, 0), radians, measured on a circle of this radius."""
    circle = shapely.LinearRing(shapely.get_coordinates(disc(x, 0.0, radius).exterior)[:-1])
    return float(shapely.intersection(circle, shapely.Polygon(points)).length) / radius


def narrowest(piece: PieceDesign) -> float:
    """Least width in mm of a piece's layers, pin holes filled, where more than a third of a knuckle hangs on it."""
    knuckle = max(piece.start.radius, piece.end.radius)
    least = math.pi * knuckle * knuckle / KNUCKLES_PER_NECK
    # Layers that differ in their pin holes only are the same here.
    regions = {region.wkb: region for slab in piece.slabs for region in _large(slab.section, least)}
    return min(_neck(region, least, knuckle) for region in regions.values())


def widening_parameter(piece: PieceDesign, width: float) -> str:
    """Which parameter widens a piece that is narrower than ``width`` mm: the size if its flat body is, or the wall of
    its knuckles if only the joint with a knuckle is."""
    knuckle = max(piece.start.radius, piece.end.radius)
    return (
        "size_mm" if _neck(piece.body, math.pi * knuckle * knuckle / KNUCKLES_PER_NECK, knuckle) < width else "wall_mm"
    )


def _large(section: shapely.Geometry, least: float) -> list[shapely.Polygon]:
    return [shapely.Polygon(polygon.exterior) for polygon in polygons_by_area(section) if polygon.area > least]


def _neck(region: shapely.Polygon, least: float, widest: float) -> float:
    """Twice the depth from which on a region that shrinks is no longer one region, crumbs left out."""

    def whole(depth: float) -> bool:
        kept = polygons_by_area(region.buffer(-depth, quad_segs=QUARTER_SEGMENTS))
        return sum(bool(polygon.buffer(depth, quad_segs=QUARTER_SEGMENTS).area > least) for polygon in kept) < 2

    # A knuckle that hangs on little is a part by itself only until it vanishes, too: the first split counts.
    steps = np.linspace(0.0, widest, NECK_STEPS + 1)[1:-1].tolist()
    split = next((k for k, depth in enumerate(steps) if not whole(depth)), None)
    if split is None:
        return 2.0 * widest
    low, high = steps[split - 1] if split else 0.0, steps[split]
    for _ in range(NECK_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if whole(middle) else (low, middle)
    return 2.0 * low
