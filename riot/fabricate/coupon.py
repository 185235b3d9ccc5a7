"""Test piece of a printer: one hinge in five clearances and five interferences, with numbers on it. Ours.

A bar has five lower knuckles, each with its interference engraved in hundredths of a millimetre; five arms have an
upper knuckle each, with its clearance. Of hinges that are printed in place there are five joints of two arms, each with
its clearance. What turns freely, and what holds, is what to ask for.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import shapely
from shapely import affinity

from riot.errors import needs_extra
from riot.fabricate.export.engraving import letters
from riot.fabricate.joint_end import joint_end
from riot.fabricate.layers import make_slabs, rings_slabs
from riot.fabricate.model import HingeEnd, Slab
from riot.fabricate.outlines import disc
from riot.fabricate.pivot import make_pivot, upper_rings
from riot.fabricate.rings import whole_layers
from riot.fabricate.solid import Part, extruded, round_part
from riot.fabricate.tuning import GRID_MM
from riot.parameters import FabricationParameters

with needs_extra("print"):
    import manifold3d

CLEARANCES_MM = (0.15, 0.25, 0.35, 0.45, 0.55)
"""mm, in radius, arm by arm."""

INTERFERENCES_MM = (0.0, 0.05, 0.1, 0.15, 0.2)
"""mm, in diameter, knuckle by knuckle of the bar."""

ARM_MM = 14.0
"""mm: length of an arm, and width of the bar, from the hinge's axis."""

_NECK_SHARE, _HANDLE_MM = 0.65, 8.0
"""Width of an arm that is printed in place, where it meets the joint, over that of the joint: eaves there stay steep;
and from 1 mm beyond the joint on, in mm: room for the number."""

_LETTER_MM, _DEEP_MM, _SPACE_MM = 3.0, 0.4, 4.0


def coupon(parameters: FabricationParameters) -> tuple[Part, ...]:
    """The bar, five arms, and five pins (or caps) of the test piece; or five joints that are printed in place.

    Raises `riot.errors.FabricationError` as `make_pivot`.

    >>> [(part.name, part.count) for part in coupon(FabricationParameters())][:2]
    [('bar', 1), ('arm-15', 1)]
    """
    if parameters.pivot == "in-place":
        return tuple(_joint(replace(parameters, clearance_mm=clearance)) for clearance in CLEARANCES_MM)
    pivot = make_pivot(replace(parameters, clearance_mm=CLEARANCES_MM[-1]))
    radius, pitch = pivot.radius, 2.0 * pivot.radius + _SPACE_MM
    bars = []
    for k, interference in enumerate(INTERFERENCES_MM):
        knuckle = make_pivot(replace(parameters, clearance_mm=CLEARANCES_MM[-1], press_mm=interference)).lower
        slabs = rings_slabs(knuckle)
        body = shapely.box(-0.5 * pitch - GRID_MM, -ARM_MM, 0.5 * pitch + GRID_MM, -0.5 * radius)
        number = shapely.Point() if pivot.interference is None else _number(interference, -0.5 * (ARM_MM + radius))
        bars.append([_moved(slab, k * pitch) for slab in _with_body(slabs, body, number, parameters)])
    layers = zip(*bars, strict=True)
    bar = tuple(Slab(same[0].low, same[0].high, shapely.union_all([slab.section for slab in same])) for same in layers)
    parts = [Part("bar", "piece", 1, bar, extruded(bar))]
    for clearance in CLEARANCES_MM:
        rings = upper_rings(replace(parameters, clearance_mm=clearance))
        arm = shapely.box(-radius, 0.5 * radius, radius, ARM_MM)
        # Seen from below, where the bar does not cover it.
        number = affinity.scale(_number(clearance, 0.5 * (ARM_MM + radius)), -1.0, 1.0, origin=(0.0, 0.0))
        rings = tuple(replace(ring, radius=radius) for ring in rings)
        slabs = _with_body(rings_slabs(rings), arm, number, parameters, below=True)
        foot = slabs[0].low
        slabs = tuple(Slab(round(slab.low - foot, 9), round(slab.high - foot, 9), slab.section) for slab in slabs)
        parts.append(Part(f"arm-{_hundredths(clearance)}", "piece", 1, slabs, extruded(slabs), upside_down=True))
    if parameters.pivot == "printed":
        parts.append(round_part("pin", len(CLEARANCES_MM), pivot.profile, upside_down=True))
    elif parameters.pivot == "rod":
        parts.append(round_part("cap", len(CLEARANCES_MM), pivot.cap, upside_down=True))
    return tuple(parts)


def _joint(parameters: FabricationParameters) -> Part:
    """Two arms that are printed in place, one with the socket and one with the pin, which has the number."""
    name = f"joint-{_hundredths(parameters.clearance_mm)}"
    members = [extruded(slabs) for slabs in joint_arms(parameters)]
    return Part(name, "chain", 1, (), manifold3d.Manifold.batch_boolean(members, manifold3d.OpType.Add))


def joint_arms(parameters: FabricationParameters) -> tuple[tuple[Slab, ...], tuple[Slab, ...]]:
    """The layers of the arm with the socket and of that with the pin, around the hinge's axis."""
    parameters = replace(parameters, gap_mm=max(parameters.gap_mm, parameters.clearance_mm))
    pivot, free = make_pivot(parameters), HingeEnd(1, "open", "none", ARM_MM, 0.0, (), (), 0.0)
    below = joint_end("pin", "lower", pivot.lower, parameters.levels, pivot.radius, parameters)
    above = joint_end("pin", "upper", pivot.upper, parameters.levels, pivot.radius, parameters)
    neck, handle, start = _NECK_SHARE * pivot.radius, 0.5 * _HANDLE_MM, pivot.radius + 1.0
    arm = shapely.union(shapely.box(-neck, 0.0, neck, ARM_MM), shapely.box(-handle, start, handle, ARM_MM))
    socket = make_slabs(0, affinity.scale(arm, 1.0, -1.0, origin=(0.0, 0.0)), (below, free), (), parameters)
    pin = make_slabs(1, arm, (above, free), (), parameters)
    number = _number(parameters.clearance_mm, 0.5 * (ARM_MM + pivot.radius))
    return socket, _engraved(pin, number, parameters)


def _engraved(slabs: tuple[Slab, ...], number: shapely.Geometry, parameters: FabricationParameters) -> tuple[Slab, ...]:
    """The same layers, with a number in the upper face."""
    cut = round(slabs[-1].high - whole_layers(_DEEP_MM, parameters.layer_mm), 9)
    return tuple(
        Slab(low, high, slab.section.difference(number) if low >= cut else slab.section)
        for slab in slabs
        for low, high in pairwise(sorted({slab.low, slab.high, max(slab.low, min(cut, slab.high))}))
    )


def _with_body(
    slabs: tuple[Slab, ...],
    body: shapely.Polygon,
    number: shapely.Geometry,
    parameters: FabricationParameters,
    *,
    below: bool = False,
) -> tuple[Slab, ...]:
    """A knuckle's layers with a flat body, into whose upper (or lower) face a number is engraved."""
    low, high = slabs[0].low, slabs[-1].high
    deep = whole_layers(_DEEP_MM, parameters.layer_mm)
    cut = (low, round(low + deep, 9)) if below else (round(high - deep, 9), high)
    axis = disc(0.0, 0.0, max(_hole(slab) for slab in slabs), outside=True)
    solid = body.difference(axis)
    joined = []
    for slab in slabs:
        levels = sorted({slab.low, slab.high, *(z for z in cut if slab.low < z < slab.high)})
        for bottom, top in pairwise(levels):
            engraved = cut[0] <= bottom and top <= cut[1]
            flat = solid.difference(number) if engraved else solid
            joined.append(Slab(bottom, top, shapely.union_all([slab.section, flat], grid_size=GRID_MM)))
    return tuple(joined)


def _hole(slab: Slab) -> float:
    return float(slab.section.distance(shapely.Point(0.0, 0.0)))


def _moved(slab: Slab, x: float) -> Slab:
    return Slab(slab.low, slab.high, affinity.translate(slab.section, x, 0.0))


def _hundredths(length: float) -> str:
    return f"{round(100.0 * length):02d}"


def _number(length: float, y: float) -> shapely.Geometry:
    """Hundredths of a millimetre, in the middle of (0, y)."""
    words = letters(_hundredths(length), _LETTER_MM)
    x0, y0, x1, y1 = words.bounds
    return affinity.translate(words, -0.5 * (x0 + x1), y - 0.5 * (y0 + y1))
