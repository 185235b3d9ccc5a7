"""The check of the hinges: the clearances that the layers and the solids leave at every hinge. Ours.

The check measures layers and solids; it does not trust how the design made them.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from itertools import combinations

import shapely

from riot.errors import needs_extra
from riot.fabricate.captive_check import check_captive
from riot.fabricate.hinge_record import HingeCheck
from riot.fabricate.model import Design, HingeEnd, PieceDesign, Slab
from riot.fabricate.outlines import disc
from riot.fabricate.rings import Ring
from riot.fabricate.solid import Part, common_volume
from riot.fabricate.tuning import (
    DISC_SIDES,
    GAP_SEARCH_MM,
    HEIGHT_TOLERANCE_MM,
    KNUCKLE_SHARE,
    LENGTH_TOLERANCE_MM,
    OVERLAP_TOLERANCE_MM3,
    PAST_STOP_LAYERS,
    PAST_STOP_MM,
    PULL_LAYERS,
    PULL_SHARES,
    SLOPE,
    STOP_SLACK_MM,
)

with needs_extra("print"):
    import manifold3d


def check_hinges(design: Design, parts: tuple[Part, ...]) -> tuple[HingeCheck, ...]:
    """Verify every hinge that joins two pieces."""
    checks = []
    for before, after in zip((design.pieces[-1], *design.pieces), design.pieces, strict=False):
        if after.start.kind == "telescopic":
            checks.append(_check_telescope(design, after.index, parts))
        elif after.start.kind == "pin":
            check = _check_pin if design.pins else partial(check_captive, parts)
            checks.append(check(design, before, after))
    return tuple(checks)


def _check_pin(design: Design, before: PieceDesign, after: PieceDesign) -> HingeCheck:
    """One of the two pieces has the lower knuckle, the other the upper."""
    parameters, hinge, pivot = design.parameters, after.start.hinge, design.pivot
    assert pivot is not None
    upside_down = before.end.role == "upper"
    (lower, lower_end), (upper, upper_end) = sorted(
        ((before, before.end), (after, after.start)), key=lambda side: (side[0] is before) == upside_down
    )
    holding, turning = _knuckle_slabs(lower.slabs, lower_end), _knuckle_slabs(upper.slabs, upper_end)
    axial = min((b.low - a.high for a in holding for b in turning), default=math.inf)
    gap = _radial_gap(pivot.profile, turning, upper_end)
    pull, lifted = math.inf, 0.0
    while math.isinf(pull) and lifted < parameters.height:
        lifted = round(lifted + parameters.layer_mm, 9)
        raised = [replace(slab, low=slab.low + lifted, high=slab.high + lifted) for slab in turning]
        pull = lifted if _radial_gap(pivot.profile, raised, upper_end) < -LENGTH_TOLERANCE_MM else math.inf
    failures = []
    if axial < parameters.axial_gap_mm - LENGTH_TOLERANCE_MM:
        failures.append(
            f"hinge {hinge}: knuckles of {before.name} and {after.name} are {axial:.2f} mm apart along the axis: "
            f"axial_gap_mm asks for {parameters.axial_gap_mm:g}"
        )
    if gap < parameters.clearance_mm - LENGTH_TOLERANCE_MM:
        failures.append(
            f"hinge {hinge}: the pin has {gap:.2f} mm around it in the knuckle that turns: clearance_mm asks for "
            f"{parameters.clearance_mm:g}"
        )
    most = parameters.clearance_mm / SLOPE + PULL_LAYERS * parameters.layer_mm
    if pull > most + LENGTH_TOLERANCE_MM:
        failures.append(
            f"hinge {hinge}: its knuckle comes off the pin, whose head does not hold it: lessen clearance_mm"
        )
    interference = None
    if pivot.interference is not None:
        interference = -2.0 * _radial_gap(pivot.profile, holding, lower_end)
        if abs(interference - pivot.interference) > 2.0 * LENGTH_TOLERANCE_MM:
            failures.append(
                f"hinge {hinge}: the pin is {interference:.2f} mm thicker than the hole that holds it: press_mm asks "
                f"for {pivot.interference:g}"
            )
    return HingeCheck(hinge, "pin", axial, gap, interference, pull, tuple(failures))


def _radial_gap(profile: tuple[Ring, ...], slabs: list[Slab], end: HingeEnd) -> float:
    """The least gap in radius between a pin and what is around it at the same height; negative if it is too thick."""
    axis = shapely.Point(end.x, end.y)
    return min(
        (
            float(slab.section.distance(axis)) - ring.radius
            for ring in profile
            for slab in slabs
            if min(ring.high, slab.high) - max(ring.low, slab.low) > HEIGHT_TOLERANCE_MM
        ),
        default=math.inf,
    )


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
    return HingeCheck(hinge, "telescopic", axial, min(inner, outer), None, telescope.travel, tuple(failures))
