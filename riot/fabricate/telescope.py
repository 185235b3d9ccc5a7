"""Telescopic hinge: a barrel, a sleeve in it, and a slit rod with a knob, nested (paper §4.4, Fig. 11).

The lower piece carries the barrel. The upper piece carries the rod, hanging from a cap over the barrel. The sleeve is a
part by itself: pushed into the barrel from below, past a lip, its flange stops under the barrel's ledge; the rod's
knob, pushed in from above, stops under the sleeve's ledge. So the upper piece lifts by more than its own thickness and
does not come off. Ledges, flange and knob slope: barrel and sleeve print as they stand, the rod upside down.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from riot.errors import FabricationError
from riot.fabricate.rings import Ring, steps, taper, whole_layers
from riot.fabricate.tuning import (
    CAP_SHARE_DIVISOR,
    LEAST_CAP_MM,
    LEAST_ROD_MM,
    LEDGE_OVER_GAP_MM,
    LEDGE_RIM_MM,
    LIP_HEIGHT_MM,
    SLIT_SHARE,
    SNAP_MM,
    SPARE_TRAVEL_MM,
)
from riot.parameters import FabricationParameters


@dataclass(frozen=True)
class Telescope:
    """The three nested cylinders, pushed together; all heights over the pieces' lower face.

    ``barrel`` belongs to the lower piece, ``rod`` (knob first, cap last) to the upper, ``sleeve`` to none;
    ``sleeve_travel`` and ``rod_travel`` are how far the sleeve rises in the barrel, and the rod in the sleeve, mm.
    """

    barrel: tuple[Ring, ...]
    sleeve: tuple[Ring, ...]
    rod: tuple[Ring, ...]
    sleeve_travel: float
    rod_travel: float

    @property
    def radius(self) -> float:
        """Of the barrel and the cap, mm."""
        return self.barrel[0].radius

    @property
    def barrel_height(self) -> float:
        """Height of the barrel's top, mm."""
        return self.barrel[-1].high

    @property
    def cap_height(self) -> float:
        """Height of the cap's lower face, mm."""
        return self.rod[-1].low

    @property
    def travel(self) -> float:
        """By how much the upper piece rises, mm."""
        return round(self.sleeve_travel + self.rod_travel, 9)


@dataclass(frozen=True)
class _Heights:
    """Heights over the pieces' lower face when pushed together, and thicknesses, in whole layers; mm.

    ``rim`` is how thick ledges, flange and knob are before they slope, ``lip`` the barrel's lip, ``seat`` where the
    sleeve stands, ``top`` where barrel and sleeve end, ``slope`` the height of a ledge's slope without its last layer,
    ``nested`` how far the slopes go into each other, ``eaves`` where the cap begins, ``split`` where the slit ends.
    """

    rim: float
    lip: float
    seat: float
    top: float
    slope: float
    nested: float
    eaves: float
    split: float

    @property
    def ledge(self) -> float:
        """Where a ledge begins to slope."""
        return round(self.top - self.rim - self.slope, 9)

    @property
    def sleeve_travel(self) -> float:
        """How far the sleeve rises in the barrel."""
        return round(self.ledge - self.rim - self.seat + self.nested, 9)

    @property
    def rod_travel(self) -> float:
        """How far the rod rises in the sleeve."""
        return round(self.ledge - self.rim + self.nested, 9)


def make_telescope(parameters: FabricationParameters) -> Telescope:
    """The telescopic hinge for these parameters.

    Raises `riot.errors.FabricationError` if the pieces are too thin for it, or its ledges too narrow.
    """
    z = _heights(parameters)
    gap, wall, step = parameters.telescope_gap_mm, parameters.telescope_wall_mm, parameters.telescope_ledge_mm
    if step <= gap + SNAP_MM:
        enough = gap + LEDGE_OVER_GAP_MM
        raise FabricationError(
            "ledge",
            f"telescope_ledge_mm: {step:g} mm holds nothing over a gap of {gap:g} mm; make it {enough:g} mm",
            "telescope_ledge_mm",
            enough,
        )
    rod = max(LEAST_ROD_MM, 0.5 * parameters.pin_mm)
    inner_mouth = rod + gap
    inner_bore = inner_mouth + step
    knob = inner_bore - gap
    sleeve = inner_bore + wall
    mouth = sleeve + gap
    bore = mouth + step
    flange = bore - gap
    radius = bore + wall
    slit = min(rod, 2.0 * (knob - inner_mouth))
    foot = round(z.seat + z.rim, 9)

    def ledge(outside: float, wide: float, narrow: float) -> list[Ring]:
        slope = taper(z.ledge, wide, narrow, parameters.layer_mm)
        rings = [Ring(ring.low, ring.high, outside, ring.radius) for ring in slope]
        return [*rings[:-1], replace(rings[-1], high=z.top)]

    def bulge(low: float, high: float, wide: float, narrow: float) -> list[Ring]:
        slope = taper(low, wide, narrow, parameters.layer_mm)
        return [*slope[:-1], replace(slope[-1], high=high)]

    sleeve_rings = [Ring(z.seat, foot, flange), *bulge(foot, z.ledge, flange, sleeve)]
    rod_rings = [Ring(0.0, z.rim, knob), *bulge(z.rim, z.split, knob, rod)]
    return Telescope(
        barrel=(
            Ring(0.0, z.lip, radius, flange - SNAP_MM),
            Ring(z.lip, z.ledge, radius, bore),
            *ledge(radius, bore, mouth),
        ),
        sleeve=(
            *(replace(ring, hole=inner_bore) for ring in sleeve_rings),
            *ledge(sleeve, inner_bore, inner_mouth),
        ),
        rod=(
            *(replace(ring, slit=slit) for ring in rod_rings),
            Ring(z.split, z.eaves, rod),
            Ring(z.eaves, parameters.height, radius),
        ),
        sleeve_travel=z.sleeve_travel,
        rod_travel=z.rod_travel,
    )


def _heights(parameters: FabricationParameters) -> _Heights:
    """The heights for these parameters; the cap is as thick as the travel that is needed allows."""
    height, layer = parameters.height, parameters.layer_mm

    def layers(length: float) -> float:
        return whole_layers(length, layer)

    count = steps(parameters.telescope_ledge_mm, layer)
    slope = round((count - 1) * layer, 9)
    nested = math.floor(round(parameters.telescope_gap_mm * count / parameters.telescope_ledge_mm, 6)) * layer
    rim, lip, seam = layers(LEDGE_RIM_MM), layers(LIP_HEIGHT_MM), parameters.axial_gap
    seat = round(lip + layer, 9)
    fixed = 4.0 * rim + 2.0 * (slope - nested) + seat + 2.0 * seam
    least_cap = layers(LEAST_CAP_MM)
    cap = max(least_cap, layers(0.5 * (2.0 * height - fixed - parameters.travel - SPARE_TRAVEL_MM)) - layer)
    cap = min(cap, max(least_cap, layers(height / CAP_SHARE_DIVISOR)))
    top = round(height - cap - seam, 9)
    split = max(layers(SLIT_SHARE * top), round(rim + count * layer, 9))
    heights = _Heights(rim, lip, seat, top, slope, nested, round(height - cap, 9), split)
    if heights.sleeve_travel <= 0.0 or round(heights.sleeve_travel + heights.rod_travel - parameters.travel, 9) < 0.0:
        least = round(layers(fixed + 2.0 * least_cap + parameters.travel - height), 6)
        raise FabricationError(
            "thin",
            f"thickness_mm: a telescopic hinge of {height:g} mm cannot lift its piece by {parameters.travel:g} mm; "
            f"make it {least:g} mm",
            "thickness_mm",
            least,
        )
    return heights
