"""What a check of a hinge measures. Ours."""

from __future__ import annotations

import math
from dataclasses import dataclass, field


@dataclass(frozen=True)
class HingeCheck:
    """One hinge: mm.

    ``axial_gap`` is the gap between its knuckles, or between cap and barrel, along the axis; ``turning_gap`` that in
    radius between the pin and the knuckle that turns on it, or the least between the cylinders of a telescopic hinge;
    ``interference`` how much thicker the pin is than the hole that holds it, None where a nut or nothing does;
    ``pull`` how far the two pieces can be pulled apart along the axis until the pin's head, or a ledge, stops them. Of
    a cone hinge that is printed in place ``turning_gap`` is the least gap in space over a whole turn, ``widest_gap``
    the greatest, ``pull`` how far the pin goes up or down, and ``aside`` how far sideways.
    """

    hinge: int
    kind: str
    axial_gap: float
    turning_gap: float
    interference: float | None
    pull: float
    failures: tuple[str, ...] = field(default=())
    widest_gap: float = math.nan
    aside: float = math.nan

    @property
    def words(self) -> str:
        """The hinge in one line."""
        start = f"hinge {self.hinge}: {self.kind}, {self.axial_gap:.2f} mm along the axis, "
        if self.kind == "in place":
            return (
                f"{start}{self.turning_gap:.3f} to {self.widest_gap:.3f} mm in space over the whole turn; held after "
                f"{self.pull:.1f} mm up or down, {self.aside:.1f} mm sideways"
            )
        pressed = "" if self.interference is None else f", pressed in by {self.interference:.2f} mm"
        held = "stops" if self.kind == "telescopic" else "held"
        return f"{start}{self.turning_gap:.2f} mm around it{pressed}; {held} after {self.pull:.1f} mm"
