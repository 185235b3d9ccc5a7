"""From a transform to the flat pieces of a puzzle with hinges, in millimetres (paper §4.4, theory §9). Ours.

The piece after a hinge is its female side: the outer two knuckles; the piece before it the male: the middle one. A
piece makes room for its neighbour's knuckles at their heights, and at all heights for those of other pieces, wherever
the planned motion takes them.
"""

from __future__ import annotations

import math

import shapely

from riot.errors import FabricationError as FabricationError
from riot.fabricate.clearance import shaved
from riot.fabricate.layers import make_slabs
from riot.fabricate.model import Design, HingeEnd, HingePin, Kind, PieceDesign
from riot.fabricate.outlines import corner_angle, make_outline, narrowest, widening_parameter
from riot.fabricate.sub_chains import sub_chains
from riot.fabricate.sweep import cleared, keep_hinges_apart
from riot.fabricate.telescope import Ring, Telescope, make_telescope
from riot.fabricate.tuning import (
    LARGE_HINGE_SHARE,
    LARGE_LOSS_SHARE,
    NARROW_CORNER,
    OUTLINE_SPARE_MM,
    SAME_CLEARANCE_RATIO,
    STRONG_WALL_MM,
)
from riot.geometry.polyline import extent, signed_area
from riot.motion.planner import motion_of, plan_motion
from riot.parameters import FabricationParameters as FabricationParameters
from riot.parameters import MotionParameters
from riot.transform.certificate import certify
from riot.transform.motion import Motion
from riot.transform.transform import Transform
from riot.types import FloatArray


def design(transform: Transform, parameters: FabricationParameters | None = None) -> Design:
    """Design the puzzle of a transform; deterministic.

    The transform's motion is kept if it allows for the gap and the hinges' relief at this size, or planned again.

    Raises `riot.errors.FabricationError` if the transform's certificate fails, or for what cannot exist at
    this size, naming the parameter that would mend it.
    """
    parameters = parameters or FabricationParameters()
    certificate = certify(transform)
    if not certificate.passed:
        raise FabricationError(
            "uncertified", f"the transform is not exact ({certificate.failure}): construct it again with riot make"
        )
    side = max(extent(transform.outline_p()), extent(transform.outline_q()))
    scale = parameters.size_mm / side
    motion = _motion(transform, parameters, scale)
    telescope = make_telescope(parameters) if motion.lifted else None
    ends = _ends(motion, parameters, telescope, scale)
    chains = sub_chains(motion, scale)
    keep_hinges_apart(ends, chains, transform, parameters, scale)

    raw = [scale * piece.polygon for piece in transform.pieces]
    outlines = [make_outline(points, i, parameters) for i, points in enumerate(raw)]
    bodies = cleared(outlines, ends, chains, transform, parameters.gap_mm, scale)
    lengths = [scale * piece.length for piece in transform.pieces]
    bodies = shaved(bodies, ends, lengths, motion, chains, parameters.gap_mm, scale)
    pieces, warnings = [], []
    for i in range(len(transform)):
        piece_design = _piece(i, lengths[i], outlines[i], bodies[i], ends[i], parameters)
        pieces.append(piece_design)
        warnings += _weaknesses(piece_design, raw[i], parameters)
    count = sum(end.kind == "pin" for _, end in ends)
    pins = (HingePin(parameters.pin_mm, parameters.height, count),) if count else ()
    return Design(transform, parameters, scale, motion, tuple(pieces), pins, telescope, tuple(warnings))


def _motion(transform: Transform, parameters: FabricationParameters, scale: float) -> Motion:
    """The transform's plan if the pieces of this design are within the bodies that it was planned for."""
    gap, relief = parameters.gap_mm / scale, parameters.relief_radius / scale
    motion = motion_of(transform)
    if motion.gap <= gap * SAME_CLEARANCE_RATIO and motion.relief <= relief * SAME_CLEARANCE_RATIO:
        return motion
    side = parameters.size_mm / scale
    return plan_motion(transform, MotionParameters(gap=gap / side, relief=relief / side))


def _ends(
    motion: Motion, parameters: FabricationParameters, telescope: Telescope | None, scale: float
) -> list[tuple[HingeEnd, HingeEnd]]:
    """Start and end of every piece."""
    n = len(motion.chain.lengths)
    return [
        (
            _female(i, motion, parameters, telescope),
            _male((i + 1) % n, scale * float(motion.chain.lengths[i]), motion, parameters, telescope),
        )
        for i in range(n)
    ]


def _kind(hinge: int, motion: Motion) -> Kind:
    if hinge == motion.open_hinge:
        return "open"
    return "telescopic" if hinge in motion.lifted else "pin"


def _female(hinge: int, motion: Motion, parameters: FabricationParameters, telescope: Telescope | None) -> HingeEnd:
    """The start of the piece after a hinge; of a telescopic one the upper side, with the rod."""
    kind, height = _kind(hinge, motion), parameters.height
    if kind == "open":
        return HingeEnd(hinge, kind, "none", 0.0, 0.0, (), (), 0.0)
    if kind == "telescopic":
        assert telescope is not None
        relief_radius = telescope.radius + parameters.gap_mm + OUTLINE_SPARE_MM
        return HingeEnd(hinge, kind, "male", 0.0, 0.0, telescope.rod, ((0.0, telescope.cap_height),), relief_radius)
    lower, _, _, upper = parameters.levels
    radius, hole = parameters.knuckle_radius, 0.5 * parameters.pin_mm + parameters.play_mm
    rings = Ring(0.0, lower, radius, hole), Ring(upper, height, radius, hole)
    return HingeEnd(
        hinge, kind, "female", 0.0, 0.0, rings, ((lower, upper),), parameters.relief_radius + OUTLINE_SPARE_MM
    )


def _male(
    hinge: int, x: float, motion: Motion, parameters: FabricationParameters, telescope: Telescope | None
) -> HingeEnd:
    """The end of the piece before a hinge; of a telescopic one the lower side, with the barrel."""
    kind, height = _kind(hinge, motion), parameters.height
    if kind == "open":
        return HingeEnd(hinge, kind, "none", x, 0.0, (), (), 0.0)
    if kind == "telescopic":
        assert telescope is not None
        relief_radius = telescope.radius + parameters.gap_mm + OUTLINE_SPARE_MM
        return HingeEnd(
            hinge, kind, "female", x, 0.0, telescope.barrel, ((telescope.barrel_height, height),), relief_radius
        )
    _, low, high, _ = parameters.levels
    radius, hole = parameters.knuckle_radius, 0.5 * parameters.pin_mm + parameters.clearance_mm
    rings = (Ring(low, high, radius, hole),)
    return HingeEnd(
        hinge, kind, "male", x, 0.0, rings, ((0.0, low), (high, height)), parameters.relief_radius + OUTLINE_SPARE_MM
    )


def _piece(
    index: int,
    length: float,
    outline: shapely.Polygon,
    body: shapely.Polygon,
    ends: tuple[HingeEnd, HingeEnd],
    parameters: FabricationParameters,
) -> PieceDesign:
    return PieceDesign(
        index,
        length,
        shapely.get_coordinates(shapely.orient_polygons(outline).exterior)[:-1],
        body,
        *ends,
        make_slabs(index, body, ends, parameters),
        1.0 - float(body.area) / float(outline.area),
    )


def _weaknesses(piece: PieceDesign, raw: FloatArray, parameters: FabricationParameters) -> list[str]:
    """What is weak in a piece, or lost."""
    warnings = []
    for end in (piece.start, piece.end):
        angle = corner_angle(raw, end.x, end.relief_radius) if end.kind != "open" else math.pi
        if angle < NARROW_CORNER:
            warnings.append(
                f"{piece.name}: its corner at hinge {end.hinge} is only {math.degrees(angle):.0f}° wide: a thicker "
                "knuckle (wall_mm, pin_mm) holds better"
            )
    wall, wanted = narrowest(piece), 2.0 * min(parameters.wall_mm, STRONG_WALL_MM)
    if wall < wanted:
        warnings.append(
            f"{piece.name}: only {wall:.1f} mm wide at its narrowest, where {wanted:g} mm would be strong: "
            f"a larger {widening_parameter(piece, wanted)} makes that place wider"
        )
    hinged = sum(math.pi * end.relief_radius**2 for end in (piece.start, piece.end)) / signed_area(piece.outline)
    if hinged > LARGE_HINGE_SHARE:
        warnings.append(f"{piece.name}: its hinges are {hinged:.0%} as large as it: a larger size_mm helps")
    if piece.lost > LARGE_LOSS_SHARE:
        warnings.append(f"{piece.name}: other pieces' hinges take {piece.lost:.1%} of it; a smaller pin_mm takes less")
    return warnings
