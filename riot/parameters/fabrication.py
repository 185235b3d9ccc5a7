"""Parameters of fabrication: sizes and clearances in millimetres. Ours, from makers' literature, not our own prints."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from riot.errors import FabricationError

ALLOWED: dict[str, tuple[float, float]] = {
    "size_mm": (30.0, 1000.0),
    "thickness_mm": (6.0, 30.0),
    "pin_mm": (1.75, 8.0),
    "clearance_mm": (0.15, 0.6),
    "play_mm": (0.05, 0.5),
    "axial_gap_mm": (0.2, 0.6),
    "wall_mm": (0.8, 10.0),
    "gap_mm": (0.1, 0.8),
    "telescope_wall_mm": (0.8, 4.0),
    "telescope_gap_mm": (0.15, 0.6),
    "telescope_ledge_mm": (0.5, 3.0),
    "layer_mm": (0.1, 0.4),
    "kerf_mm": (0.0, 0.5),
    "bed_width_mm": (80.0, 1000.0),
    "bed_depth_mm": (80.0, 1000.0),
}
"""Least and greatest value of every parameter."""

LIFT_MM = 1.0
"""A telescopic hinge lifts its piece by the thickness and so much more."""

_ROUNDING = 1e-9
"""Shares of a layer that count as none when heights are counted in layers."""


@dataclass(frozen=True)
class FabricationParameters:
    """Sizes of the puzzle and its hinges, all in mm; `ALLOWED` has their ranges.

    Raises `riot.errors.FabricationError`, naming the parameter, for a value out of its range.
    """

    size_mm: float = 120.0
    """Long side of the larger of the two shapes."""
    thickness_mm: float = 9.0
    """Of all pieces: three layers of knuckles. Rounded to whole layers of the printer (`height`)."""
    pin_mm: float = 3.0
    """Diameter of the pivot pins; 1.75 is a piece of filament."""
    clearance_mm: float = 0.35
    """Between the pin and the hole of a male knuckle, in radius: it turns."""
    play_mm: float = 0.20
    """Between the pin and the hole of a female knuckle, in radius: the pin is pushed in."""
    axial_gap_mm: float = 0.30
    """Between the faces of two knuckles of one hinge; rounded up to whole layers (`axial_gap`)."""
    wall_mm: float = 1.6
    """Of a knuckle around the wider hole."""
    gap_mm: float = 0.35
    """Between the outlines of neighbouring pieces: half of it is taken off all round every piece."""
    telescope_wall_mm: float = 1.2
    """Of the two tubes of a telescopic hinge."""
    telescope_gap_mm: float = 0.3
    """Between two nested cylinders of it, in radius."""
    telescope_ledge_mm: float = 1.0
    """How far the ledge of a tube stands inwards."""
    layer_mm: float = 0.2
    """Layer height of the printer: all heights are multiples of it."""
    kerf_mm: float = 0.15
    """Width of the laser's cut; of no account for printing."""
    bed_width_mm: float = 220.0
    bed_depth_mm: float = 220.0
    """Of the printer's bed."""

    def __post_init__(self) -> None:
        for name, (least, greatest) in ALLOWED.items():
            value = getattr(self, name)
            if not (isinstance(value, int | float) and math.isfinite(value) and least <= value <= greatest):
                raise FabricationError(
                    "out-of-range", f"{name}: {value!r} is out of the allowed range, {least:g} to {greatest:g} mm", name
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
    def levels(self) -> tuple[float, float, float, float]:
        """Heights where knuckles of a pin hinge end and begin: female below, male, male, female above; mm."""
        outer = _layers(self.height / 3.0 - 0.5 * self.axial_gap, self.layer_mm, math.floor)
        inner = round(outer + self.axial_gap, 9)
        return outer, inner, round(self.height - inner, 9), round(self.height - outer, 9)

    @property
    def knuckle_radius(self) -> float:
        """Of a pin hinge: pin, clearance and wall, mm."""
        return 0.5 * self.pin_mm + max(self.clearance_mm, self.play_mm) + self.wall_mm

    @property
    def relief_radius(self) -> float:
        """Of the room a neighbour leaves for such a knuckle, mm."""
        return self.knuckle_radius + self.gap_mm

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
