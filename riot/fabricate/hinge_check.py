"""The check of the hinges: the clearances that the layers and the solids leave at every hinge. Ours.

The check measures layers and solids; it does not trust how the design made them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import combinations

import shapely

from riot.errors import needs_extra
from riot.fabricate.model import Design, HingeEnd, PieceDesign, Slab
from riot.fabricate.outlines import disc
from riot.fabricate.solid import Part, common_volume
from riot.fabricate.tuning import (
    DISC_SIDES,
    GAP_SEARCH_MM,
    KNUCKLE_SHARE,
    LENGTH_TOLERANCE_MM,
    OVERLAP_TOLERANCE_MM3,
    PAST_STOP_LAYERS,
    PAST_STOP_MM,
    PULL_SHARES,
    STOP_SLACK_MM,
)

with needs_extra("print"):
    import manifold3d


@dataclass(frozen=True)
class HingeCheck:
    """One hinge: gaps between its knuckles along the axis, and between pin and holes in radius; mm.

    Of a telescopic hinge ``axial_gap`` is that between cap and barrel, ``male_gap`` that of rod and sleeve, and
    ``female_gap`` that of sleeve and barrel.
    """

    hinge: int
    kind: str
    axial_gap: float
    male_gap: float
    female_gap: float
    failures: tuple[str, ...] = field(default=())


def check_hinges(design: Design, parts: tuple[Part, ...]) -> tuple[HingeCheck, ...]:
    """Verify every hinge that joins two pieces."""
    n = len(design.pieces)
    return tuple(
        _check_pin(design, design.pieces[hinge - 1], design.pieces[hinge])
        if design.pieces[hinge].start.kind == "pin"
        else _check_telescope(design, hinge, parts)
        for hinge in range(n)
        if design.pieces[hinge].start.kind != "open"
    )


def _check_pin(design: Design, before: PieceDesign, after: PieceDesign) -> HingeCheck:
    """The male knuckle is the end of ``one``, the female ones the start of ``two``."""
    parameters, hinge = design.parameters, after.start.hinge
    radius = 0.5 * parameters.pin_mm
    male, female = _knuckle_slabs(before.slabs, before.end), _knuckle_slabs(after.slabs, after.start)
    axial = min((max(b.low - a.high, a.low - b.high) for a in male for b in female), default=math.inf)
    gaps = [
        min((slab.section.distance(shapely.Point(end.x, end.y)) for slab in slabs), default=0.0) - radius
        for slabs, end in ((male, before.end), (female, after.start))
    ]
    failures = []
    if axial < parameters.axial_gap_mm - LENGTH_TOLERANCE_MM:
        failures.append(
            f"hinge {hinge}: knuckles of {before.name} and {after.name} are {axial:.2f} mm apart along the axis: "
            f"axial_gap_mm asks for {parameters.axial_gap_mm:g}"
        )
    for role, gap, parameter in (("male", gaps[0], "clearance_mm"), ("female", gaps[1], "play_mm")):
        if gap < getattr(parameters, parameter) - LENGTH_TOLERANCE_MM:
            failures.append(
                f"hinge {hinge}: the pin has {gap:.2f} mm around it in the {role} knuckle: {parameter} asks for "
                f"{getattr(parameters, parameter):g}"
            )
    return HingeCheck(hinge, "pin", float(axial), float(gaps[0]), float(gaps[1]), tuple(failures))


def _knuckle_slabs(slabs: tuple[Slab, ...], end: HingeEnd) -> list[Slab]:
    """The layers that have something of a knuckle around the axis of a hinge."""
    knuckle = disc(end.x, end.y, end.radius)
    return [slab for slab in slabs if slab.section.intersection(knuckle).area > KNUCKLE_SHARE * knuckle.area]


def _check_telescope(design: Design, hinge: int, parts: tuple[Part, ...]) -> HingeCheck:
    """The three cylinders pushed together, lifted as the motion does, and pulled as far as they go."""
    telescope, parameters = design.telescope, design.parameters
    assert telescope is not None
    lower, upper = design.pieces[hinge - 1], design.pieces[hinge]
    named = {part.name: part.solid for part in parts}
    sleeve = named["sleeve"]
    seat = telescope.sleeve[0].low
    barrel = named[lower.name].translate((-lower.end.x, -lower.end.y, 0.0))
    rod = named[upper.name].translate((-upper.start.x, -upper.start.y, 0.0))
    # Only what is around the axis: the rest of the two pieces is the motion's.
    around = manifold3d.Manifold.cylinder(3.0 * parameters.height, telescope.radius, -1.0, DISC_SIDES)
    barrel, rod = barrel ^ around, rod ^ around
    axial = telescope.cap_height - telescope.barrel_height
    inner = float(sleeve.translate((0.0, 0.0, seat)).min_gap(rod, GAP_SEARCH_MM))
    outer = float(sleeve.translate((0.0, 0.0, seat)).min_gap(barrel, GAP_SEARCH_MM))
    failures = []
    for share in PULL_SHARES:
        raised = share * parameters.travel
        risen = raised * telescope.sleeve_travel / telescope.travel
        parts_at = (barrel, sleeve.translate((0.0, 0.0, seat + risen)), rod.translate((0.0, 0.0, raised)))
        common = max(common_volume(a, b) for a, b in combinations(parts_at, 2))
        if common > OVERLAP_TOLERANCE_MM3:
            failures.append(
                f"hinge {hinge}: its cylinders overlap by {common:.3g} mm³ when lifted by {raised:.1f} mm: enlarge "
                "telescope_gap_mm"
            )
    beyond = telescope.travel + PAST_STOP_LAYERS * parameters.layer_mm
    sleeve_up = sleeve.translate((0.0, 0.0, seat + telescope.sleeve_travel - STOP_SLACK_MM))
    rod_caught = common_volume(rod.translate((0.0, 0.0, beyond)), sleeve_up) > OVERLAP_TOLERANCE_MM3
    sleeve_caught = (
        common_volume(sleeve.translate((0.0, 0.0, seat + telescope.sleeve_travel + PAST_STOP_MM)), barrel)
        > OVERLAP_TOLERANCE_MM3
    )
    if not (rod_caught and sleeve_caught):
        failures.append(f"hinge {hinge}: its cylinders come apart: enlarge telescope_ledge_mm")
    if min(inner, outer) < min(parameters.telescope_gap_mm, parameters.layer_mm) - LENGTH_TOLERANCE_MM:
        failures.append(f"hinge {hinge}: its cylinders are {min(inner, outer):.2f} mm apart: enlarge telescope_gap_mm")
    return HingeCheck(hinge, "telescopic", axial, inner, outer, tuple(failures))
