"""Flat regions in millimetres: discs, the outline of a piece, how narrow it is. Ours."""

from __future__ import annotations

import math

import numpy as np
import shapely

from riot.errors import FabricationError
from riot.fabricate.model import PieceDesign, polygons
from riot.parameters import FabricationParameters
from riot.types import FloatArray

GRID = 0.001
"""All points of flat regions lie on a grid of this step, mm: far below what a printer can do."""

SIDES = 64
"""Of a disc."""

SMOOTH = 0.005
"""Points of an outline nearer to the line through the others are left out, mm."""

SPARE = SMOOTH + 2.0 * GRID
"""So much more than half the gap is taken off an outline, mm: neither smoothing nor the grid narrows the gap."""

CRUMB = 0.01
"""Share of a piece that may break off where it is narrower than the outline gap."""

_STEPS, _HALVINGS = 12, 5
_QUARTER = 8


def disc(x: float, y: float, radius: float, *, outside: bool = False) -> shapely.Polygon:
    """A regular polygon in a circle, or around it if ``outside``; mm."""
    around = 2.0 * math.pi * (np.arange(SIDES) + 0.5) / SIDES
    reach = radius / math.cos(math.pi / SIDES) if outside else radius
    points = np.array([x, y]) + reach * np.stack([np.cos(around), np.sin(around)], axis=1)
    return shapely.Polygon(np.round(points / GRID) * GRID)


def subtract(region: shapely.Geometry, other: shapely.Geometry) -> shapely.Geometry:
    """What of a region is not in another; on the grid."""
    return shapely.difference(region, other, grid_size=GRID)


def parts(region: shapely.Geometry) -> list[shapely.Polygon]:
    """The polygons of a region, the largest first."""
    return sorted(polygons(region), key=lambda part: -part.area)


def make_outline(points: FloatArray, piece: int, parameters: FabricationParameters) -> shapely.Polygon:
    """A piece (m, 2) in mm, less half the outline gap all round, without holes.

    Raises `riot.errors.FabricationError` if it vanishes or falls apart.
    """
    whole = shapely.Polygon(points)
    shrunk = shapely.simplify(whole.buffer(-0.5 * parameters.gap_mm - SPARE, quad_segs=_QUARTER), SMOOTH)
    found = parts(shapely.set_precision(shrunk, GRID))
    if not found or whole.area - found[0].area - 0.5 * parameters.gap_mm * whole.length > CRUMB * whole.area:
        if len(found) < 2:
            said, size = "is nowhere wider than the outline gap", 2.0 * parameters.size_mm
        else:
            said, size = f"falls into {len(found)} parts where it is narrower than the outline gap", math.nan
        raise FabricationError(
            "falls-apart",
            f"piece-{piece + 1} {said}: enlarge size_mm ({parameters.size_mm:g}) or lessen gap_mm "
            f"({parameters.gap_mm:g})",
            "size_mm",
            1.25 * parameters.size_mm if math.isnan(size) else size,
        )
    return shapely.Polygon(found[0].exterior)


def corner(points: FloatArray, x: float, radius: float) -> float:
    """How wide a piece (m, 2) is around (x, 0), radians, measured on a circle of this radius."""
    circle = shapely.LinearRing(shapely.get_coordinates(disc(x, 0.0, radius).exterior)[:-1])
    return float(shapely.intersection(circle, shapely.Polygon(points)).length) / radius


def narrowest(piece: PieceDesign) -> float:
    """Least width in mm of a piece's layers, pin holes filled, where more than a third of a knuckle hangs on it."""
    knuckle = max(piece.start.radius, piece.end.radius)
    least = math.pi * knuckle * knuckle / 3.0
    return min(_neck(region, least, knuckle) for slab in piece.slabs for region in _large(slab.section, least))


def mends(piece: PieceDesign, width: float) -> str:
    """Which parameter widens a piece that is narrower than ``width`` mm: the size if its flat body is, or the wall of
    its knuckles if only the joint with a knuckle is."""
    knuckle = max(piece.start.radius, piece.end.radius)
    return "size_mm" if _neck(piece.body, math.pi * knuckle * knuckle / 3.0, knuckle) < width else "wall_mm"


def _large(section: shapely.Geometry, least: float) -> list[shapely.Polygon]:
    return [shapely.Polygon(part.exterior) for part in parts(section) if part.area > least]


def _neck(region: shapely.Polygon, least: float, widest: float) -> float:
    """Twice the depth from which on a region that shrinks is no longer one region, crumbs left out."""

    def whole(depth: float) -> bool:
        kept = parts(region.buffer(-depth, quad_segs=_QUARTER))
        return sum(bool(part.buffer(depth, quad_segs=_QUARTER).area > least) for part in kept) < 2

    # A knuckle that hangs on little is a part by itself only until it vanishes, too: the first split counts.
    steps = np.linspace(0.0, widest, _STEPS + 1)[1:-1].tolist()
    split = next((k for k, depth in enumerate(steps) if not whole(depth)), None)
    if split is None:
        return 2.0 * widest
    low, high = steps[split - 1] if split else 0.0, steps[split]
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if whole(middle) else (low, middle)
    return 2.0 * low
