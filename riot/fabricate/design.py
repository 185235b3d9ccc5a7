"""From a transform to the flat pieces of a puzzle with hinges, in millimetres (paper §4.4, theory §9). Ours.

At a hinge the knuckle of one piece lies on that of the other; pieces take turns along the chain (`upper_pieces`). A
piece makes room for its neighbour's knuckle at its heights, and at all heights for those of other pieces, wherever the
planned motion takes them.
"""

from __future__ import annotations

import math

import shapely

from riot.errors import FabricationError as FabricationError
from riot.fabricate.clearance import shaved
from riot.fabricate.joint_end import joint_end
from riot.fabricate.layers import make_slabs
from riot.fabricate.magnets import magnet_pockets
from riot.fabricate.model import Design, HingeEnd, HingePin, Kind, PieceDesign, Role, printed_upside_down
from riot.fabricate.outlines import corner_angle, make_outline, narrowest
from riot.fabricate.pivot import Pivot, knuckle_radius, make_pivot
from riot.fabricate.pocket import Pocket
from riot.fabricate.printing_pose import printing_pose, refuse_lifts
from riot.fabricate.sub_chains import sub_chains
from riot.fabricate.sweep import cleared, keep_hinges_apart
from riot.fabricate.telescope import Telescope, make_telescope
from riot.fabricate.tuning import (
    LARGE_LOSS_SHARE,
    NARROW_CORNER,
    SAME_CLEARANCE_RATIO,
    STRONG_WALL_MM,
)
from riot.geometry.polyline import extent
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
    if parameters.pivot == "in-place":
        refuse_lifts(motion)
    telescope = make_telescope(parameters) if motion.lifted else None
    count = len(transform) - 1 - len(motion.lifted)
    pivot = make_pivot(parameters) if count else None
    ends = _ends(motion, parameters, pivot, telescope, scale)
    chains = sub_chains(motion, scale)
    keep_hinges_apart(ends, chains, transform, parameters, scale)

    raw = [scale * piece.polygon for piece in transform.pieces]
    outlines = [make_outline(points, i, parameters) for i, points in enumerate(raw)]
    bodies = cleared(outlines, ends, chains, transform, parameters.gap_mm, scale)
    lengths = [scale * piece.length for piece in transform.pieces]
    bodies = shaved(bodies, ends, lengths, motion, chains, parameters.gap_mm, scale)
    pockets: dict[int, tuple[Pocket, ...]] = {}
    if parameters.magnet_mm:
        pockets = magnet_pockets(bodies, ends, transform, motion.open_hinge, parameters, scale)
    pieces, warnings = [], []
    for i in range(len(transform)):
        piece_design = _piece(i, lengths[i], outlines[i], bodies[i], ends[i], pockets.get(i, ()), parameters)
        pieces.append(piece_design)
        warnings += _weaknesses(piece_design, raw[i], parameters)
    pins: tuple[HingePin, ...] = ()
    if pivot is not None and parameters.pivot != "in-place":
        pins = (HingePin(parameters.pivot, parameters.pin_mm, pivot.length, count),)
    placement = None
    if parameters.pivot == "in-place":
        placement = printing_pose(tuple(pieces), motion, parameters, scale)
    return Design(
        transform, parameters, scale, motion, tuple(pieces), pins, pivot, telescope, tuple(warnings), placement
    )


def _motion(transform: Transform, parameters: FabricationParameters, scale: float) -> Motion:
    """The transform's plan if the pieces of this design are within the bodies that it was planned for."""
    gap, relief = parameters.gap_mm / scale, (knuckle_radius(parameters) + parameters.gap_mm) / scale
    motion = motion_of(transform)
    if motion.gap <= gap * SAME_CLEARANCE_RATIO and motion.relief <= relief * SAME_CLEARANCE_RATIO:
        return motion
    side = parameters.size_mm / scale
    return plan_motion(transform, MotionParameters(gap=gap / side, relief=relief / side))


def upper_pieces(motion: Motion) -> frozenset[int]:
    """The pieces that have the upper knuckles at both of their hinges: every other one along the chain.

    Such a piece prints upside down, the others as they lie: then no knuckle starts in the air. What lifts at a
    telescopic hinge is upper there.

    Raises `riot.errors.FabricationError` if two lifts contradict each other.
    """
    n = len(motion.chain.lengths)
    position = {(motion.open_hinge + k) % n: k for k in range(n)}
    parities = {position[hinge] % 2 for hinge in motion.lifted}
    if len(parities) > 1:
        hinges = " and ".join(map(str, sorted(motion.lifted)))
        raise FabricationError(
            "supports",
            f"hinges {hinges} lift an odd number of pieces apart, so that a piece between them has knuckles above and "
            "below and does not print without supports: no parameter helps; take another transform (--pieces, --rank)",
        )
    first = min(parities, default=1)
    return frozenset(piece for piece, k in position.items() if k % 2 == first)


def _ends(
    motion: Motion, parameters: FabricationParameters, pivot: Pivot | None, telescope: Telescope | None, scale: float
) -> list[tuple[HingeEnd, HingeEnd]]:
    """Start and end of every piece."""
    n, upper = len(motion.chain.lengths), upper_pieces(motion)

    def end(piece: int, hinge: int, x: float) -> HingeEnd:
        return _end(hinge, x, "upper" if piece in upper else "lower", motion, parameters, pivot, telescope)

    return [(end(i, i, 0.0), end(i, (i + 1) % n, scale * float(motion.chain.lengths[i]))) for i in range(n)]


def _end(
    hinge: int,
    x: float,
    role: Role,
    motion: Motion,
    parameters: FabricationParameters,
    pivot: Pivot | None,
    telescope: Telescope | None,
) -> HingeEnd:
    if hinge == motion.open_hinge:
        return HingeEnd(hinge, "open", "none", x, 0.0, (), (), 0.0)
    kind: Kind = "telescopic" if hinge in motion.lifted else "pin"
    if kind == "telescopic":
        assert telescope is not None
        low, high, radius = telescope.barrel_height, telescope.cap_height, telescope.radius
        rings = telescope.barrel if role == "lower" else telescope.rod
    else:
        assert pivot is not None
        (low, high), radius = parameters.levels, pivot.radius
        rings = pivot.lower if role == "lower" else pivot.upper
    return joint_end(kind, role, rings, (low, high), radius, parameters, hinge=hinge, x=x)


def _piece(
    index: int,
    length: float,
    outline: shapely.Polygon,
    body: shapely.Polygon,
    ends: tuple[HingeEnd, HingeEnd],
    pockets: tuple[Pocket, ...],
    parameters: FabricationParameters,
) -> PieceDesign:
    return PieceDesign(
        index,
        length,
        shapely.get_coordinates(shapely.orient_polygons(outline).exterior)[:-1],
        body,
        *ends,
        make_slabs(index, body, ends, pockets, parameters),
        1.0 - float(body.area) / float(outline.area),
        printed_upside_down(ends),
        pockets,
    )


def strong_width(parameters: FabricationParameters) -> float:
    """Least width of a place that is strong: two walls, mm."""
    return 2.0 * min(parameters.wall_mm, STRONG_WALL_MM)


def is_weak(piece: PieceDesign, parameters: FabricationParameters) -> bool:
    """Whether a place of a piece is narrower than is strong, by a tenth of a millimetre or more."""
    return round(narrowest(piece), 1) < round(strong_width(parameters), 1)


def _weaknesses(piece: PieceDesign, raw: FloatArray, parameters: FabricationParameters) -> list[str]:
    """What is weak in a piece, or lost."""
    warnings = []
    for end in (piece.start, piece.end):
        angle = corner_angle(raw, end.x, end.relief_radius) if end.kind != "open" else math.pi
        if angle < NARROW_CORNER:
            warnings.append(
                f"{piece.name}: its corner at hinge {end.hinge} is only {math.degrees(angle):.0f}° wide, so that "
                "little holds the knuckle"
            )
    if is_weak(piece, parameters):
        warnings.append(
            f"{piece.name}: only {narrowest(piece):.1f} mm wide at its narrowest, where "
            f"{strong_width(parameters):g} mm would be strong"
        )
    if piece.lost > LARGE_LOSS_SHARE:
        warnings.append(f"{piece.name}: other pieces' hinges take {piece.lost:.1%} of it; a smaller pin_mm takes less")
    return warnings
