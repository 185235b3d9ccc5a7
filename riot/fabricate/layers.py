"""The layers of a piece's solid: its body, less the room for neighbours' knuckles, with its own knuckles. Ours."""

from __future__ import annotations

from itertools import pairwise

import shapely

from riot.errors import FabricationError
from riot.fabricate.model import HingeEnd, Slab
from riot.fabricate.outlines import disc, polygons_by_area, subtract
from riot.fabricate.pocket import Pocket
from riot.fabricate.rings import Ring
from riot.fabricate.tuning import CRUMB_SHARE, DISC_SIDES, GRID_MM, HEIGHT_DIGITS, SIZE_FACTOR, SLIT_REACH_MM
from riot.parameters import FabricationParameters

Cuts = list[tuple[float, float, shapely.Polygon]]
"""What is empty, besides, from height to height."""


def make_slabs(
    index: int,
    body: shapely.Polygon,
    ends: tuple[HingeEnd, HingeEnd],
    pockets: tuple[Pocket, ...],
    parameters: FabricationParameters,
) -> tuple[Slab, ...]:
    """The layers of one piece from the lowest up, crumbs left out.

    Raises `riot.errors.FabricationError` if they are not one solid.
    """
    heights = {0.0, parameters.height}
    for end in ends:
        heights |= {z for ring in (*end.rings, *end.relief) for z in (ring.low, ring.high)}
    cuts = [(level.low, level.high, pocket.room(level)) for pocket in pockets for level in pocket.levels]
    heights |= {z for low, high, _ in cuts for z in (low, high)}
    levels = sorted({round(z, HEIGHT_DIGITS) for z in heights})
    cells = _cells(body, ends, cuts)
    slabs = tuple(
        Slab(low, high, _section(cells, body, ends, cuts, 0.5 * (low + high))) for low, high in pairwise(levels)
    )
    return _connected(index, slabs, ends, parameters)


def _cells(body: shapely.Polygon, ends: tuple[HingeEnd, HingeEnd], cuts: Cuts) -> list[shapely.Polygon]:
    """The regions between all lines of all levels: so levels share points wherever they share a line."""
    regions: list[shapely.Polygon] = [body, *(room for _, _, room in cuts)]
    for end in ends:
        regions += [_relief_of(end, ring) for ring in end.relief]
        regions += [_disc_of(end, ring) for ring in end.rings]
        regions += [_hole_of(end, ring) for ring in end.rings if ring.hole > 0.0]
        regions += [_slit_of(end, ring) for ring in end.rings if ring.slit > 0.0]
    lines = shapely.union_all([region.boundary for region in regions], grid_size=GRID_MM)
    return polygons_by_area(shapely.polygonize(shapely.get_parts(lines)))


def _section(
    cells: list[shapely.Polygon], body: shapely.Polygon, ends: tuple[HingeEnd, HingeEnd], cuts: Cuts, height: float
) -> shapely.Geometry:
    """A level cut of a piece."""
    reliefs = [_relief_of(end, ring) for end in ends for ring in end.relief if ring.low < height < ring.high]
    rings = [(end, ring) for end in ends for ring in end.rings if ring.low < height < ring.high]
    discs = [_disc_of(end, ring) for end, ring in rings]
    empty = [_hole_of(end, ring) for end, ring in rings if ring.hole > 0.0]
    empty += [_slit_of(end, ring) for end, ring in rings if ring.slit > 0.0]
    empty += [room for low, high, room in cuts if low < height < high]
    solid = []
    for cell in cells:
        point = cell.point_on_surface()
        filled = any(disc.contains(point) for disc in discs)
        filled = filled or (body.contains(point) and not any(relief.contains(point) for relief in reliefs))
        if filled and not any(hole.contains(point) for hole in empty):
            solid.append(cell)
    return shapely.union_all(solid)


def _relief_of(end: HingeEnd, ring: Ring) -> shapely.Polygon:
    return disc(end.x, end.y, ring.radius, outside=True)


def _disc_of(end: HingeEnd, ring: Ring) -> shapely.Polygon:
    return disc(end.x, end.y, ring.radius)


def _hole_of(end: HingeEnd, ring: Ring) -> shapely.Polygon:
    return disc(end.x, end.y, ring.hole, outside=True, sides=ring.sides or DISC_SIDES)


def _slit_of(end: HingeEnd, ring: Ring) -> shapely.Polygon:
    """Across all of the ring."""
    half, reach = 0.5 * ring.slit, ring.radius + SLIT_REACH_MM
    return shapely.set_precision(shapely.box(end.x - half, end.y - reach, end.x + half, end.y + reach), GRID_MM)


def rings_slabs(rings: tuple[Ring, ...]) -> tuple[Slab, ...]:
    """The layers of a part made of rings around the origin."""
    slabs = []
    for ring in rings:
        section: shapely.Geometry = disc(0.0, 0.0, ring.radius)
        if ring.hole > 0.0:
            section = subtract(section, disc(0.0, 0.0, ring.hole, outside=True))
        slabs.append(Slab(round(ring.low, HEIGHT_DIGITS), round(ring.high, HEIGHT_DIGITS), section))
    return tuple(slabs)


def _connected(
    index: int, slabs: tuple[Slab, ...], ends: tuple[HingeEnd, HingeEnd], parameters: FabricationParameters
) -> tuple[Slab, ...]:
    """The slabs without what hangs on nothing; an error if that is more than crumbs."""
    flat = [(k, polygon) for k, slab in enumerate(slabs) for polygon in polygons_by_area(slab.section)]
    owner = list(range(len(flat)))

    def root(i: int) -> int:
        while owner[i] != i:
            i = owner[i]
        return i

    for i, (k, polygon) in enumerate(flat):
        for j in range(i + 1, len(flat)):
            if flat[j][0] == k + 1 and polygon.intersection(flat[j][1]).area > GRID_MM:
                owner[root(j)] = root(i)
    volumes: dict[int, float] = {}
    for i, (k, polygon) in enumerate(flat):
        volumes[root(i)] = volumes.get(root(i), 0.0) + polygon.area * (slabs[k].high - slabs[k].low)
    if not volumes:
        raise _broken(index, "has nothing left at this size", ends, parameters)
    main = max(volumes, key=lambda key: volumes[key])
    if sum(volumes.values()) - volumes[main] > CRUMB_SHARE * volumes[main]:
        raise _broken(index, f"falls into {len(volumes)} parts", ends, parameters)
    for end in ends:
        connected = [root(i) == main for i, (k, polygon) in enumerate(flat) if _has_knuckle(end, slabs[k], polygon)]
        if not all(connected):
            raise FabricationError(
                "falls-apart",
                f"piece-{index + 1} does not reach its knuckle at hinge {end.hinge}: enlarge wall_mm "
                f"({parameters.wall_mm:g})",
                "wall_mm",
            )
    kept = []
    for k, slab in enumerate(slabs):
        left = [polygon for i, (layer, polygon) in enumerate(flat) if layer == k and root(i) == main]
        kept.append(Slab(slab.low, slab.high, left[0] if len(left) == 1 else shapely.MultiPolygon(left)))
    return tuple(kept)


def _has_knuckle(end: HingeEnd, slab: Slab, polygon: shapely.Polygon) -> bool:
    """Whether a part of a slab holds one of an end's knuckles."""
    height = 0.5 * (slab.low + slab.high)
    return any(
        ring.low < height < ring.high and shapely.Polygon(polygon.exterior).contains(shapely.Point(end.x, end.y))
        for ring in end.rings
    )


def _broken(
    index: int, problem: str, ends: tuple[HingeEnd, HingeEnd], parameters: FabricationParameters
) -> FabricationError:
    hinges = " and ".join(str(end.hinge) for end in ends)
    return FabricationError(
        "falls-apart",
        f"piece-{index + 1} (hinges {hinges}) {problem}: enlarge size_mm ({parameters.size_mm:g}) or thin pin_mm "
        f"({parameters.pin_mm:g})",
        "size_mm",
        SIZE_FACTOR * parameters.size_mm,
    )
