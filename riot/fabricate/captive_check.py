"""The check of a hinge that is printed in place: its gap at every turn, and that nothing pulls it apart. Ours.

The check measures the solids; it does not trust how the design made them.
"""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from shapely.affinity import translate

from riot.errors import needs_extra
from riot.fabricate.hinge_record import HingeCheck
from riot.fabricate.model import Slab
from riot.fabricate.outlines import disc
from riot.fabricate.solid import common_volume
from riot.fabricate.tuning import (
    CONE_SEARCH_MM,
    CONE_TURNS,
    DISC_SIDES,
    LENGTH_TOLERANCE_MM,
    OVERLAP_TOLERANCE_MM3,
    PULL_DIRECTIONS,
    PULL_HALVINGS,
    PULL_LAYERS,
    SLIVER_MM2,
    SLOPE,
)

if TYPE_CHECKING:
    from riot.fabricate.model import Design, HingeEnd, PieceDesign
    from riot.fabricate.solid import Part

with needs_extra("print"):
    import manifold3d

_OUTSIDE_MM = 1.0
"""mm: what is around an axis is taken from so far below the pieces to so far above them."""


def check_captive(parts: tuple[Part, ...], design: Design, before: PieceDesign, after: PieceDesign) -> HingeCheck:
    """Verify the hinge of two pieces, one of which has the pin, the other the socket."""
    hinge, named = after.start.hinge, {part.name: part.solid for part in parts}
    sides = sorted(((before, before.end), (after, after.start)), key=lambda side: side[1].captive > 0.0)
    socket, pin = (_around(design, named[piece.name], end) for piece, end in sides)
    gaps, play = captive_gaps(design, socket, pin), captive_play(design, socket, pin)
    below, above = (_layers(design, piece, end) for piece, end in sides)
    axial = min(
        higher.low - lower.high
        for lower, higher in product(below, above)
        if higher.low >= lower.high and higher.section.intersection(lower.section).area > SLIVER_MM2
    )
    failures = tuple(captive_failures(design, hinge, gaps, play))
    return HingeCheck(hinge, "in place", axial, gaps[0], None, max(play[:2]), failures, gaps[1], play[2])


def captive_gaps(design: Design, socket: manifold3d.Manifold, pin: manifold3d.Manifold) -> tuple[float, float]:
    """Least and greatest gap in space between a pin and its socket over a whole turn, mm."""
    # The sides of the polygons pass each other within a 64th of a turn.
    turns = [360.0 * (k + k / (CONE_TURNS * DISC_SIDES)) / CONE_TURNS for k in range(CONE_TURNS)]
    search = design.parameters.clearance_mm + CONE_SEARCH_MM
    gaps = [float(socket.min_gap(pin.rotate((0.0, 0.0, turn)), search)) for turn in turns]
    return min(gaps), max(gaps)


def captive_play(design: Design, socket: manifold3d.Manifold, pin: manifold3d.Manifold) -> tuple[float, float, float]:
    """How far a pin goes up, down and sideways in its socket until they meet, mm; infinite where it comes out.

    A pin that is pulled up or down as far as it may be must meet the socket wherever it goes sideways besides.
    """
    parameters = design.parameters
    far = parameters.clearance_mm / SLOPE + PULL_LAYERS * parameters.layer_mm
    aside = parameters.clearance_mm + PULL_LAYERS * SLOPE * parameters.layer_mm

    def meets(x: float, y: float, z: float) -> bool:
        return common_volume(socket, pin.translate((x, y, z))) > OVERLAP_TOLERANCE_MM3

    def play(direction: tuple[float, float, float], limit: float) -> float:
        free, met = 0.0, limit
        if not meets(*(limit * part for part in direction)):
            return math.inf
        for _ in range(PULL_HALVINGS):
            middle = 0.5 * (free + met)
            free, met = (free, middle) if meets(*(middle * part for part in direction)) else (middle, met)
        return met

    angles = 2.0 * math.pi * np.arange(PULL_DIRECTIONS) / PULL_DIRECTIONS
    compass = [(math.cos(angle), math.sin(angle)) for angle in angles.tolist()]
    sideways = max(play((x, y, 0.0), aside) for x, y in compass)
    ways = []
    for sign in (1.0, -1.0):
        held = all(meets(0.7 * aside * x, 0.7 * aside * y, sign * far) for x, y in compass)
        ways.append(play((0.0, 0.0, sign), far) if held else math.inf)
    return ways[0], ways[1], sideways


def captive_failures(
    design: Design, hinge: int, gaps: tuple[float, float], play: tuple[float, float, float]
) -> list[str]:
    """What is wrong with a hinge of these gaps and plays."""
    asked, failures = design.parameters.clearance_mm, []
    if gaps[0] < asked - LENGTH_TOLERANCE_MM:
        failures.append(f"hinge {hinge}: its pin is {gaps[0]:.2f} mm from its socket: clearance_mm asks for {asked:g}")
    for words, way in zip(("up", "down", "sideways"), play, strict=True):
        if math.isinf(way):
            failures.append(f"hinge {hinge}: its pin comes {words} out of its socket: lessen clearance_mm")
    return failures


def _layers(design: Design, piece: PieceDesign, end: HingeEnd) -> list[Slab]:
    """The layers of a piece within the socket's radius, about the axis."""
    assert design.pivot is not None
    around = disc(0.0, 0.0, design.pivot.radius)
    return [
        Slab(slab.low, slab.high, translate(slab.section, -end.x, -end.y).intersection(around)) for slab in piece.slabs
    ]


def _around(design: Design, solid: manifold3d.Manifold, end: HingeEnd) -> manifold3d.Manifold:
    """What of a piece is within the socket's radius, about the axis."""
    assert design.pivot is not None
    height = design.parameters.height + 2.0 * _OUTSIDE_MM
    cylinder = manifold3d.Manifold.cylinder(height, design.pivot.radius, -1.0, DISC_SIDES)
    return solid.translate((-end.x, -end.y, 0.0)) ^ cylinder.translate((0.0, 0.0, -_OUTSIDE_MM))
