"""Parameters of fabrication: sizes and clearances in millimetres. Ours, from makers' literature, not our own prints."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from riot.parameters.field import ParameterGroup, parameter

MAKERS = "ours, from makers' literature"

LIFT_MM = 1.0
"""A telescopic hinge lifts its piece by the thickness and so much more."""

PIVOTS: Mapping[str, Mapping[str, float | str]] = {
    "printed": {"pivot": "printed"},
    "filament": {"pivot": "rod", "pin_mm": 1.75},
    "rod": {"pivot": "rod", "pin_mm": 3.0},
    "screw": {"pivot": "screw", "pin_mm": 3.0, "thickness_mm": 10.0},
    "in-place": {"pivot": "in-place", "axial_gap_mm": 0.4},
}
"""What pins can be, by name: printed, a length of 1.75 mm filament, a steel rod of 3 mm, an M3 screw of 10 mm with its
nut, or cones that are printed in place; and the parameters that go with it."""

_ROUNDING = 1e-9
"""Shares of a layer that count as none when heights are counted in layers."""


@dataclass(frozen=True)
class FabricationParameters(ParameterGroup):
    """Sizes of the puzzle and its hinges, all in mm."""

    size_mm: float = parameter(
        120.0, at_least=30, at_most=1000, unit="mm", source=MAKERS, meaning="Long side of the larger of the two shapes."
    )
    thickness_mm: float = parameter(
        9.0,
        at_least=6,
        at_most=30,
        unit="mm",
        source=MAKERS,
        meaning="Thickness of all pieces: a knuckle on a knuckle. Rounded to whole layers of the printer.",
    )
    pin_mm: float = parameter(
        3.0,
        at_least=1.75,
        at_most=8,
        unit="mm",
        source=MAKERS,
        meaning="Diameter of the pivot pins, or of their waist in place; 1.75 is a piece of filament.",
    )
    clearance_mm: float = parameter(
        0.35,
        at_least=0.15,
        at_most=0.6,
        unit="mm",
        source=MAKERS,
        meaning="Gap in radius between the pin and the hole of the upper knuckle, which turns on it.",
    )
    pivot: Literal["printed", "rod", "screw", "in-place"] = parameter(
        "printed",
        source=MAKERS,
        meaning="What a pin hinge turns on: a printed pin with a head, a rod with a printed cap, a screw and nut, or a "
        "pin with a waist that is printed in place, in its socket.",
    )
    press_mm: float = parameter(
        0.1,
        at_least=0,
        at_most=0.4,
        unit="mm",
        source=MAKERS,
        meaning="Interference in diameter: how much thicker a pin is than the holes that hold it.",
    )
    axial_gap_mm: float = parameter(
        0.3,
        at_least=0.2,
        at_most=0.6,
        unit="mm",
        source=MAKERS,
        meaning="Gap between the faces of two knuckles of one hinge; rounded up to whole layers.",
    )
    wall_mm: float = parameter(
        1.6, at_least=0.8, at_most=10, unit="mm", source=MAKERS, meaning="Wall of a knuckle around the wider hole."
    )
    gap_mm: float = parameter(
        0.35,
        at_least=0.1,
        at_most=0.8,
        unit="mm",
        source=MAKERS,
        meaning="Gap between the outlines of neighbouring pieces: half of it is taken off all round every piece.",
    )
    telescope_wall_mm: float = parameter(
        1.2, at_least=0.8, at_most=4, unit="mm", source=MAKERS, meaning="Wall of the two tubes of a telescopic hinge."
    )
    telescope_gap_mm: float = parameter(
        0.3,
        at_least=0.15,
        at_most=0.6,
        unit="mm",
        source=MAKERS,
        meaning="Gap in radius between two nested cylinders of a telescopic hinge.",
    )
    telescope_ledge_mm: float = parameter(
        1.0,
        at_least=0.5,
        at_most=3,
        unit="mm",
        source=MAKERS,
        meaning="How far the ledge of a telescopic hinge's tube stands inwards.",
    )
    inlay_mm: float = parameter(
        0.0,
        at_least=0,
        at_most=2,
        unit="mm",
        source="ours; three layers of 0.2 mm cover a filament of another colour",
        meaning="Depth of pictures that are sunk into front and back as bodies of other filaments, 0.6 for "
        "example; 0: none. Rounded to whole layers.",
    )
    magnet_mm: float = parameter(
        0.0,
        at_least=0,
        at_most=12,
        unit="mm",
        source="ours; 3 to 6 are usual",
        meaning="Diameter of disc magnets, on edge in the walls of the chain's two free ends, that hold either shape "
        "shut; 0: none.",
    )
    magnet_height_mm: float = parameter(
        2.0, at_least=0.5, at_most=5, unit="mm", source="ours, usual", meaning="Height of these disc magnets."
    )
    layer_mm: float = parameter(
        0.2,
        at_least=0.1,
        at_most=0.4,
        unit="mm",
        source=MAKERS,
        meaning="Layer height of the printer: all heights are multiples of it.",
    )
    kerf_mm: float = parameter(
        0.15,
        at_least=0,
        at_most=0.5,
        unit="mm",
        source=MAKERS,
        meaning="Width of the laser's cut; it does not matter for printing.",
    )
    sheet_mm: float = parameter(
        3.0,
        at_least=0.5,
        at_most=20,
        unit="mm",
        source="ours, the usual plywood and acrylic of laser cutting",
        meaning="Thickness of the laser's material; layers are stacked from it up to about the thickness.",
    )
    bed_width_mm: float = parameter(
        220.0, at_least=80, at_most=1000, unit="mm", source=MAKERS, meaning="Width of the bed of the printer or laser."
    )
    bed_depth_mm: float = parameter(
        220.0, at_least=80, at_most=1000, unit="mm", source=MAKERS, meaning="Depth of the bed of the printer or laser."
    )

    @property
    def height(self) -> float:
        """The thickness in whole layers, mm."""
        return _layers(self.thickness_mm, self.layer_mm, round)

    @property
    def axial_gap(self) -> float:
        """The axial gap in whole layers, not less than asked for, mm."""
        return _layers(self.axial_gap_mm, self.layer_mm, math.ceil)

    @property
    def levels(self) -> tuple[float, float]:
        """Heights where the lower knuckle of a pin hinge ends and the upper one begins, mm."""
        lower = _layers(0.5 * (self.height - self.axial_gap), self.layer_mm, math.floor)
        return lower, round(lower + self.axial_gap, 9)

    @property
    def inlay(self) -> float:
        """Depth of the inlays in whole layers, at least one; 0 without inlays, mm."""
        return max(self.layer_mm, _layers(self.inlay_mm, self.layer_mm, round)) if self.inlay_mm else 0.0

    @property
    def travel(self) -> float:
        """By how much a telescopic hinge must lift, mm."""
        return self.height + LIFT_MM


def _layers(length: float, layer: float, rounding: Callable[[float], int]) -> float:
    """A length in whole layers; free of the rounding errors of division."""
    count = length / layer
    near = round(count)
    if abs(count - near) < _ROUNDING * max(1.0, count):
        return round(near * layer, 9)
    return round(rounding(count) * layer, 9)
