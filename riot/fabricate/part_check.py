"""The check of a part by itself: one closed solid, as thick as it must be, with the volume of its layers. Ours."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from riot.errors import needs_extra
from riot.fabricate.model import PieceDesign
from riot.fabricate.outlines import narrowest, widening_parameter
from riot.fabricate.solid import Part, genus
from riot.fabricate.tuning import (
    LEAST_WALL_MM,
    VOLUME_TOLERANCE,
)

with needs_extra("print"):
    import manifold3d


@dataclass(frozen=True)
class PartCheck:
    """One part: what manifold3d says of it beside what its flat layers say; mm, mm³.

    ``wall`` is the least width of a layer, pin holes filled; NaN for what is not a piece.
    ``mend`` is the parameter to enlarge if a check fails.
    """

    name: str
    count: int
    status: str
    components: int
    volume: float
    layers_volume: float
    genus: int
    layers_genus: int
    wall: float
    mend: str
    failures: tuple[str, ...] = field(default=())


def check_part(part: Part, piece: PieceDesign | None) -> PartCheck:
    """Verify one part by itself."""
    status = part.solid.status()
    volume, expected = part.volume, sum(slab.volume for slab in part.slabs)
    components = len(part.solid.decompose())
    handles, expected_handles = int(part.solid.genus()), genus(part.slabs)
    wall = math.nan if piece is None else narrowest(piece)
    failures = []
    if status != manifold3d.Error.NoError or part.solid.is_empty():
        failures.append(f"{part.name} is no closed solid ({status.name})")
    if components != 1:
        failures.append(f"{part.name} is in {components} parts: enlarge size_mm")
    if abs(volume - expected) > VOLUME_TOLERANCE * expected:
        failures.append(f"{part.name} has {volume:.3f} mm³ where its layers have {expected:.3f}")
    if handles != expected_handles:
        failures.append(f"{part.name} has {handles} handles where its layers have {expected_handles}")
    mend = "size_mm"
    if piece is not None and wall < LEAST_WALL_MM:
        mend = widening_parameter(piece, LEAST_WALL_MM)
        failures.append(
            f"{part.name} (hinges {piece.start.hinge} and {piece.end.hinge}) is only {wall:.2f} mm wide where a "
            f"knuckle or a good part of it hangs on it, less than {LEAST_WALL_MM:g}: enlarge {mend}"
        )
    return PartCheck(
        part.name,
        part.count,
        status.name,
        components,
        volume,
        expected,
        handles,
        expected_handles,
        wall,
        mend,
        tuple(failures),
    )
