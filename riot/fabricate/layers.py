"""The layers of a piece's solid: its body, less the room for neighbours' knuckles, with its own knuckles. Ours."""

from __future__ import annotations

from itertools import pairwise

import shapely

from riot.fabricate.errors import FabricationError
from riot.fabricate.model import HingeEnd, Slab
from riot.fabricate.outlines import CRUMB, GRID, disc, join, parts, subtract
from riot.fabricate.parameters import FabricationParameters
from riot.fabricate.telescope import Ring

_HEIGHT_DIGITS = 6


def make_slabs(
    index: int, body: shapely.Polygon, ends: tuple[HingeEnd, HingeEnd], parameters: FabricationParameters
) -> tuple[Slab, ...]:
    """The layers of one piece from the lowest up, crumbs left out.

    Raises `riot.fabricate.errors.FabricationError` if they are not one solid.
    """
    heights = {0.0, parameters.height}
    for end in ends:
        heights |= {z for ring in end.rings for z in (ring.low, ring.high)}
        heights |= {z for room in end.relief for z in room}
    levels = sorted({round(z, _HEIGHT_DIGITS) for z in heights})
    slabs = tuple(Slab(low, high, section(body, ends, 0.5 * (low + high))) for low, high in pairwise(levels))
    return _one(index, slabs, ends, parameters)


def section(body: shapely.Polygon, ends: tuple[HingeEnd, HingeEnd], height: float) -> shapely.Geometry:
    """A level cut of a piece."""
    cut: shapely.Geometry = body
    for end in ends:
        if any(low < height < high for low, high in end.relief):
            cut = subtract(cut, disc(end.x, end.y, end.relief_radius, outside=True))
    rings = [(end, ring) for end in ends for ring in end.rings if ring.low < height < ring.high]
    cut = join([cut, *(disc(end.x, end.y, ring.radius) for end, ring in rings)])
    for end, ring in rings:
        if ring.hole > 0.0:
            cut = subtract(cut, disc(end.x, end.y, ring.hole, outside=True))
        if ring.slit > 0.0:
            cut = subtract(cut, slit(end.x, end.y, ring))
    return cut


def rings_slabs(rings: tuple[Ring, ...]) -> tuple[Slab, ...]:
    """The layers of a part made of rings around the origin."""
    found = []
    for ring in rings:
        cut: shapely.Geometry = disc(0.0, 0.0, ring.radius)
        if ring.hole > 0.0:
            cut = subtract(cut, disc(0.0, 0.0, ring.hole, outside=True))
        found.append(Slab(round(ring.low, _HEIGHT_DIGITS), round(ring.high, _HEIGHT_DIGITS), cut))
    return tuple(found)


def slit(x: float, y: float, ring: Ring) -> shapely.Polygon:
    """The slit of a ring, across all of it."""
    half = 0.5 * ring.slit
    return shapely.box(x - half, y - ring.radius - 1.0, x + half, y + ring.radius + 1.0)


def _one(
    index: int, slabs: tuple[Slab, ...], ends: tuple[HingeEnd, HingeEnd], parameters: FabricationParameters
) -> tuple[Slab, ...]:
    """The slabs without what hangs on nothing; an error if that is more than crumbs."""
    flat = [(k, part) for k, slab in enumerate(slabs) for part in parts(slab.section)]
    owner = list(range(len(flat)))

    def root(i: int) -> int:
        while owner[i] != i:
            i = owner[i]
        return i

    for i, (k, part) in enumerate(flat):
        for j in range(i + 1, len(flat)):
            if flat[j][0] == k + 1 and part.intersection(flat[j][1]).area > GRID:
                owner[root(j)] = root(i)
    volumes: dict[int, float] = {}
    for i, (k, part) in enumerate(flat):
        volumes[root(i)] = volumes.get(root(i), 0.0) + part.area * (slabs[k].high - slabs[k].low)
    if not volumes:
        raise _broken(index, "has nothing left at this size", ends, parameters)
    main = max(volumes, key=lambda key: volumes[key])
    if sum(volumes.values()) - volumes[main] > CRUMB * volumes[main]:
        raise _broken(index, f"falls into {len(volumes)} parts", ends, parameters)
    for end in ends:
        held = [root(i) == main for i, (k, part) in enumerate(flat) if _of(end, slabs[k], part)]
        if not all(held):
            raise _broken(index, f"does not reach its knuckle at hinge {end.hinge}", ends, parameters)
    kept = []
    for k, slab in enumerate(slabs):
        left = [part for i, (layer, part) in enumerate(flat) if layer == k and root(i) == main]
        kept.append(Slab(slab.low, slab.high, left[0] if len(left) == 1 else shapely.MultiPolygon(left)))
    return tuple(kept)


def _of(end: HingeEnd, slab: Slab, part: shapely.Polygon) -> bool:
    """Whether a part of a slab holds one of an end's knuckles."""
    height = 0.5 * (slab.low + slab.high)
    return any(
        ring.low < height < ring.high and shapely.Polygon(part.exterior).contains(shapely.Point(end.x, end.y))
        for ring in end.rings
    )


def _broken(
    index: int, said: str, ends: tuple[HingeEnd, HingeEnd], parameters: FabricationParameters
) -> FabricationError:
    hinges = " and ".join(str(end.hinge) for end in ends)
    return FabricationError(
        "falls-apart",
        f"piece-{index + 1} (hinges {hinges}) {said}: enlarge size_mm ({parameters.size_mm:g}) or thin pin_mm "
        f"({parameters.pin_mm:g})",
        "size_mm",
        1.25 * parameters.size_mm,
    )
