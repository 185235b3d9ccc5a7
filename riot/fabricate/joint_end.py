"""What a piece has at a hinge, and the room that it makes there for its neighbour. Ours."""

from __future__ import annotations

from riot.fabricate.cones import eaves
from riot.fabricate.model import HingeEnd, Kind, Role
from riot.fabricate.rings import Ring
from riot.fabricate.tuning import OUTLINE_SPARE_MM
from riot.parameters import FabricationParameters


def joint_end(
    kind: Kind,
    role: Role,
    rings: tuple[Ring, ...],
    levels: tuple[float, float],
    radius: float,
    parameters: FabricationParameters,
    *,
    hinge: int = 0,
    x: float = 0.0,
) -> HingeEnd:
    """The end with these rings of a joint of this radius, whose lower part ends and upper begins at ``levels``; mm.

    The room is the joint's disc and the outline gap around it: above the lower part, or below the upper, or around a
    pin that is printed in place.
    """
    room = radius + parameters.gap_mm + OUTLINE_SPARE_MM
    if parameters.pivot == "in-place" and role == "upper":
        relief = eaves(parameters, room)
        return HingeEnd(hinge, kind, role, x, 0.0, rings, relief, room, relief[0].high)
    low, high = levels
    relief = (Ring(low, parameters.height, room) if role == "lower" else Ring(0.0, high, room),)
    return HingeEnd(hinge, kind, role, x, 0.0, rings, relief, room)
