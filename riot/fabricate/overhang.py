"""The check that a part prints without supports: every layer against the one below. Ours.

A layer may lean out over the one below by its own height, which is 45°. What reaches further must be a bridge: straight
lines of one direction that lie on the layer below at both ends. A layer that ends in the air is not; nor is one that
starts there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import shapely
from shapely import affinity

from riot.fabricate.model import Slab, polygons
from riot.fabricate.solid import Part
from riot.fabricate.tuning import (
    HEIGHT_TOLERANCE_MM,
    LENGTH_TOLERANCE_MM,
    LONGEST_BRIDGE_MM,
    QUARTER_SEGMENTS,
    STEEPEST,
)


@dataclass(frozen=True)
class SupportCheck:
    """One part as it is printed: the greatest lean of a layer over the one below in degrees, bridges aside; the longest
    bridge in mm, 0 if there is none; and the area that neither holds, mm²."""

    name: str
    overhang: float
    bridge: float
    unsupported: float
    failures: tuple[str, ...] = field(default=())


def check_supports(part: Part, layer: float) -> SupportCheck:
    """Verify one part for a layer height in mm.

    >>> import shapely
    >>> from riot.fabricate.solid import extruded
    >>> slabs = Slab(0.0, 2.0, shapely.box(0, 0, 4, 4)), Slab(2.0, 3.0, shapely.box(0, 0, 9, 4))
    >>> check_supports(Part("shelf", "piece", 1, slabs, extruded(slabs)), 0.2).failures
    ('shelf needs supports: 19.2 mm² of its layer at 2.0 mm have nothing below',)
    """
    worst, longest, unsupported, failures = 0.0, 0.0, 0.0, []
    for below, above in pairwise(_as_printed(part)):
        lean, bridge, hanging = _compare(below.section, above.section, layer)
        worst, longest, unsupported = max(worst, lean), max(longest, bridge), unsupported + hanging
        if hanging > 0.0:
            failures.append(
                f"{part.name} needs supports: {hanging:.3g} mm² of its layer at {above.low:.1f} mm have nothing below"
            )
    return SupportCheck(part.name, worst, longest, unsupported, tuple(failures))


def _as_printed(part: Part) -> list[Slab]:
    """The layers from the bed up; within one of them every printed layer lies on its like."""
    slabs = list(part.slabs)
    if part.upside_down:
        top = slabs[-1].high
        slabs = [Slab(top - slab.high, top - slab.low, slab.section) for slab in reversed(slabs)]
    gaps = [above.low - below.high for below, above in pairwise(slabs)]
    assert not slabs[0].low > HEIGHT_TOLERANCE_MM and max(gaps, default=0.0) <= HEIGHT_TOLERANCE_MM
    return slabs


def _compare(below: shapely.Geometry, above: shapely.Geometry, layer: float) -> tuple[float, float, float]:
    """Lean in degrees, longest bridge in mm and area in mm² that hangs in the air, of one layer over another."""
    reach = layer * math.tan(STEEPEST) + LENGTH_TOLERANCE_MM
    new = above.difference(below)
    held = below.buffer(reach, quad_segs=QUARTER_SEGMENTS)
    hanging = polygons(new.difference(held))
    bridges = [_bridge(region, held, reach) for region in hanging]
    leaning = shapely.get_coordinates(new.intersection(held))
    sideways = float(shapely.distance(below, shapely.points(leaning)).max(initial=0.0))
    in_air = sum(
        float(region.area) for region, length in zip(hanging, bridges, strict=True) if length > LONGEST_BRIDGE_MM
    )
    spanned = (length for length in bridges if length <= LONGEST_BRIDGE_MM)
    return math.degrees(math.atan2(sideways - LENGTH_TOLERANCE_MM, layer)), max(spanned, default=0.0), in_air


def _bridge(region: shapely.Polygon, held: shapely.Geometry, reach: float) -> float:
    """The length of the lines that span a region between two sides that hold it, infinite if none do.

    The edges of the layer that end in the air must run along the lines: no line ends at them.
    """
    around = region.boundary
    free = around.difference(held.buffer(LENGTH_TOLERANCE_MM))
    edges = [np.diff(shapely.get_coordinates(line), axis=0) for line in shapely.get_parts(free)]
    steps = np.concatenate(edges) if edges else np.empty((0, 2))
    lengths = np.hypot(*steps.T)
    steps = steps[lengths > LENGTH_TOLERANCE_MM]
    if len(steps):
        directions = [math.atan2(*steps[np.hypot(*steps.T).argmax()][::-1])]
    else:
        hull = np.diff(shapely.get_coordinates(region.convex_hull.exterior), axis=0)
        directions = [math.atan2(-x, y) for x, y in hull.tolist()]
    best = math.inf
    for direction in directions:
        across = np.abs(steps @ np.array([-math.sin(direction), math.cos(direction)]))
        if across.max(initial=0.0) <= 2.0 * LENGTH_TOLERANCE_MM:
            box = affinity.rotate(region, -direction, origin=(0.0, 0.0), use_radians=True).bounds
            best = min(best, box[2] - box[0])
    return best + 2.0 * reach
