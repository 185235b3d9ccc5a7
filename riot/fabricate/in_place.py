"""A chain that is printed in place: its solids in the pose in which they lie on the bed, and the gaps there. Ours."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from itertools import combinations

from riot.errors import needs_extra
from riot.fabricate.model import Design, PieceDesign
from riot.fabricate.solid import Part, common_volume
from riot.fabricate.tuning import (
    HEIGHT_TOLERANCE_MM,
    LENGTH_TOLERANCE_MM,
    OVERLAP_TOLERANCE_MM3,
    PLACED_SEARCH_MM,
)

with needs_extra("print"):
    import manifold3d


@dataclass(frozen=True)
class PlacementCheck:
    """The chain as it is printed: ``solids`` that are apart, the least ``gap`` in space between two of them, mm, the
    greatest volume that two have in ``common``, mm³, and how high the highest lies over the bed, mm."""

    solids: int
    gap: float
    common: float
    raised: float
    failures: tuple[str, ...] = field(default=())


Rows = tuple[tuple[float, float, float, float], ...]
"""A motion in space, row by row, as manifold3d takes it."""


def placing(design: Design, piece: PieceDesign) -> Rows:
    """Where a piece is printed: in the design's printing pose, which is turned to lie straight on the bed."""
    placement = design.placement
    assert placement is not None
    pose = design.motion.pose_at(placement.time)
    x, y = (design.scale * pose.origins[piece.index]).tolist()
    c0, s0 = math.cos(placement.turn), math.sin(placement.turn)
    heading = float(pose.headings[piece.index]) + placement.turn
    c, s = math.cos(heading), math.sin(heading)
    return (c, -s, 0.0, c0 * x - s0 * y), (s, c, 0.0, s0 * x + c0 * y), (0.0, 0.0, 1.0, 0.0)


def placed_on_bed(design: Design, parts: tuple[Part, ...]) -> tuple[Part, ...]:
    """The pieces where they are printed."""
    named = {part.name: part for part in parts}
    return tuple(
        replace(named[piece.name], solid=named[piece.name].solid.transform(placing(design, piece)))
        for piece in design.pieces
    )


def chain_part(design: Design, parts: tuple[Part, ...]) -> Part:
    """All pieces as one part to be printed; it has no layers of its own."""
    solids = [part.solid for part in placed_on_bed(design, parts)]
    return Part("chain", "chain", 1, (), manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add))


def check_placement(design: Design, parts: tuple[Part, ...]) -> PlacementCheck:
    """Verify that no two pieces touch where they are printed, and that all lie on the bed."""
    asked, members = design.parameters.clearance_mm, placed_on_bed(design, parts)
    least, most, failures = math.inf, 0.0, []
    for first, second in combinations(members, 2):
        common = common_volume(first.solid, second.solid)
        gap = float(first.solid.min_gap(second.solid, asked + PLACED_SEARCH_MM))
        least, most = min(least, gap), max(most, common)
        if common > OVERLAP_TOLERANCE_MM3:
            failures.append(f"{first.name} and {second.name} overlap by {common:.3g} mm³ where they are printed")
        elif gap < asked - LENGTH_TOLERANCE_MM:
            failures.append(
                f"{first.name} and {second.name} are {gap:.3f} mm apart where they are printed: clearance_mm asks for "
                f"{asked:g}: enlarge gap_mm ({design.parameters.gap_mm:g}) or size_mm"
            )
    solids = len(manifold3d.Manifold.batch_boolean([part.solid for part in members], manifold3d.OpType.Add).decompose())
    if solids != len(members):
        failures.append(f"{len(members)} pieces are {solids} solids where they are printed")
    raised = max(abs(float(part.solid.bounding_box()[2])) for part in members)
    if raised > HEIGHT_TOLERANCE_MM:
        failures.append(f"a piece lies {raised:.3f} mm over the bed")
    return PlacementCheck(solids, least, most, raised, tuple(failures))
