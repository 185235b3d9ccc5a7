"""The check of magnets: that they go into their pockets, have walls around them, meet face to face, and attract. Ours.

The check measures solids and layers; it does not trust how the design made them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import shapely

from riot.errors import needs_extra
from riot.fabricate.model import Design, PieceDesign
from riot.fabricate.pocket import Pocket, Pole, Side
from riot.fabricate.solid import Part, common_volume
from riot.fabricate.tuning import (
    DISC_SIDES,
    GRID_MM,
    HEIGHT_TOLERANCE_MM,
    LEAST_WALL_MM,
    LENGTH_TOLERANCE_MM,
    MAGNET_FIT_MM,
    MAGNET_RECESS_MM,
    OUTLINE_SPARE_MM,
    OVERLAP_TOLERANCE_MM3,
)
from riot.transform.pose import direction

with needs_extra("print"):
    import manifold3d


@dataclass(frozen=True)
class MagnetCheck:
    """Two magnets that meet in one closed shape: mm.

    ``poles`` has for either piece, by its name, the pole that looks out; ``room`` is the least distance of a magnet
    from its pocket, ``apart`` that of the two faces, ``aside`` how far one is beside the other.
    """

    side: Side
    shape: str
    poles: Mapping[str, Pole]
    room: float
    apart: float
    aside: float
    failures: tuple[str, ...] = field(default=())

    @property
    def words(self) -> str:
        """In one line."""
        poles = " and ".join(f"{pole} in {piece}" for piece, pole in self.poles.items())
        return (
            f"magnets of {self.shape}: {poles}, faces {self.apart:.2f} mm apart and "
            f"{self.aside:.3f} mm aside; {self.room:.2f} mm around each, walls of {LEAST_WALL_MM:g} mm or more"
        )


def check_magnets(design: Design, parts: tuple[Part, ...]) -> tuple[MagnetCheck, ...]:
    """Verify the magnets of both closed shapes; nothing if there are none."""
    transform = design.transform
    shapes: dict[Side, str] = {"p": transform.p.name or "P", "q": transform.q.name or "Q"}
    return tuple(_check(design, parts, side, name) for side, name in shapes.items() if design.parameters.magnet_mm)


def magnet(design: Design, pocket: Pocket, reach: float = 0.0) -> manifold3d.Manifold:
    """A magnet in its pocket, in the piece's frame, and ``reach`` mm of the way that it comes in."""
    radius, height = 0.5 * design.parameters.magnet_mm, design.parameters.magnet_height_mm
    lying = manifold3d.Manifold.cylinder(height + reach, radius, -1.0, DISC_SIDES).translate((0.0, 0.0, -reach))
    turned = lying.rotate((0.0, 90.0, 0.0)).rotate((0.0, 0.0, math.degrees(pocket.heading)))
    return turned.translate((pocket.x, pocket.y, pocket.z))


def _check(design: Design, parts: tuple[Part, ...], side: Side, shape: str) -> MagnetCheck:
    pose, failures = design.transform.pose(0.0 if side == "p" else 1.0), list[str]()
    found = [(piece, pocket) for piece in design.pieces for pocket in piece.pockets if pocket.side == side]
    if sorted(pocket.pole for _, pocket in found) != ["north", "south"]:
        failures.append(f"magnets of {shape} do not attract each other")
    level = abs(found[0][1].z - found[1][1].z)
    faces = [design.place(pose, piece.index, np.array([[pocket.x, pocket.y]]))[0] for piece, pocket in found]
    headings = [pocket.heading + float(pose.headings[piece.index]) for piece, pocket in found]
    inwards = direction(headings[0])
    apart = float((faces[0] - faces[1]) @ inwards)
    aside = math.hypot(level, float((faces[0] - faces[1]) @ direction(headings[0] + 0.5 * math.pi)))
    slanted = abs(math.remainder(headings[0] - headings[1] - math.pi, 2.0 * math.pi))
    most = design.parameters.gap_mm + 2.0 * (OUTLINE_SPARE_MM + MAGNET_RECESS_MM)
    if not 0.0 < apart <= most + LENGTH_TOLERANCE_MM or aside > LENGTH_TOLERANCE_MM or slanted > LENGTH_TOLERANCE_MM:
        failures.append(f"magnets of {shape} do not meet face to face: {apart:.2f} mm apart, {aside:.2f} mm aside")
    rooms = []
    for piece, pocket in found:
        solid = next(part.solid for part in parts if part.name == piece.name)
        rooms.append(float(solid.min_gap(magnet(design, pocket), 2.0 * MAGNET_FIT_MM)))
        way_in = magnet(design, pocket, reach=design.parameters.magnet_height_mm + most)
        if rooms[-1] < MAGNET_FIT_MM - LENGTH_TOLERANCE_MM or common_volume(solid, way_in) > OVERLAP_TOLERANCE_MM3:
            failures.append(f"{piece.name}: the magnet of {shape} does not go into its pocket: enlarge size_mm")
        if not _walled(design, piece, pocket):
            failures.append(f"{piece.name}: walls around the magnet of {shape} are thinner than {LEAST_WALL_MM:g} mm")
    poles = {piece.name: pocket.pole for piece, pocket in found}
    return MagnetCheck(side, shape, poles, min(rooms), apart, aside, tuple(failures))


def _walled(design: Design, piece: PieceDesign, pocket: Pocket) -> bool:
    """Whether everything around a pocket but its mouth is solid as far as the least wall, at all heights."""
    low, high = pocket.levels[0].low - LEAST_WALL_MM, pocket.levels[-1].high + LEAST_WALL_MM
    if low < -HEIGHT_TOLERANCE_MM or high > design.parameters.height + HEIGHT_TOLERANCE_MM:
        return False
    width = max(level.width for level in pocket.levels) + 2.0 * (LEAST_WALL_MM - LENGTH_TOLERANCE_MM)
    around = pocket.box(LENGTH_TOLERANCE_MM, pocket.depth + LEAST_WALL_MM - LENGTH_TOLERANCE_MM, width)
    for slab in piece.slabs:
        middle = 0.5 * (slab.low + slab.high)
        empty = [pocket.room(level) for level in pocket.levels if level.low < middle < level.high]
        if low < middle < high and not shapely.union_all([slab.section, *empty]).buffer(GRID_MM).covers(around):
            return False
    return True
