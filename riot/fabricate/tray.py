"""Trays to keep the puzzle in, one with the recess of each shape. Ours.

A recess is the closed puzzle, knuckles and all, grown by a gap; it is shallower than the puzzle, which so can be taken
out by its rim. A tray prints as it lies.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import shapely
from shapely import affinity

from riot.errors import FabricationError
from riot.fabricate.model import Design, Slab, filled
from riot.fabricate.rings import whole_layers
from riot.fabricate.solid import Part, extruded
from riot.fabricate.tuning import (
    BED_SPACE_MM,
    GRID_MM,
    LENGTH_TOLERANCE_MM,
    QUARTER_SEGMENTS,
    TRAY_DEPTH_SHARE,
    TRAY_FLOOR_MM,
    TRAY_GAP_MM,
    TRAY_WALL_MM,
)
from riot.parameters import FabricationParameters
from riot.transform.transform import Transform
from riot.types import FloatArray

TRAY_TIMES = {"tray-p": 0.0, "tray-q": 1.0}
"""The trays, and the time of the pose that each is for."""


@dataclass(frozen=True)
class TrayCheck:
    """One tray with the closed puzzle in it: the least gap between them in plan, mm, and what is wrong."""

    name: str
    gap: float
    failures: tuple[str, ...] = field(default=())

    @property
    def words(self) -> str:
        """In one line."""
        return f"{self.name}: the puzzle lies in it with {self.gap:.2f} mm around it"


def tray_parts(design: Design) -> tuple[Part, ...]:
    """The trays of both shapes; the second is for the puzzle turned over if it is read there.

    >>> from riot.fabricate.design import design
    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> [part.name for part in tray_parts(design(exact_transform(dudeney())))]
    ['tray-p', 'tray-q']
    """
    parameters, parts = design.parameters, []
    floor = whole_layers(TRAY_FLOOR_MM, parameters.layer_mm)
    depth = whole_layers(TRAY_DEPTH_SHARE * parameters.height, parameters.layer_mm)
    # Neither chords of a corner's circle, nor an outline that shapely simplifies by 1 % of the reach, are nearer.
    reach = 1.01 * (TRAY_GAP_MM + LENGTH_TOLERANCE_MM) / math.cos(math.pi / (4 * QUARTER_SEGMENTS))
    for name, t in TRAY_TIMES.items():
        around = shapely.union_all(_placed(design, t)).buffer(reach, quad_segs=QUARTER_SEGMENTS)
        recess = shapely.set_precision(filled(around), GRID_MM)
        block = shapely.box(*recess.bounds).buffer(TRAY_WALL_MM, quad_segs=QUARTER_SEGMENTS)
        block = shapely.set_precision(block, GRID_MM)
        slabs = Slab(0.0, floor, block), Slab(floor, round(floor + depth, 9), block.difference(recess))
        parts.append(Part(name, "tray", 1, slabs, extruded(slabs)))
    return tuple(parts)


def check_tray(design: Design, tray: Part) -> TrayCheck:
    """Verify that a tray is one solid and that the closed puzzle goes straight down into it."""
    floor, frame = tray.slabs
    pieces = _placed(design, TRAY_TIMES[tray.name])
    gap = min(float(piece.distance(frame.section)) for piece in pieces)
    failures = []
    if gap < TRAY_GAP_MM - LENGTH_TOLERANCE_MM:
        failures.append(f"{tray.name}: {gap:.2f} mm between puzzle and tray, less than {TRAY_GAP_MM:g}")
    if not all(floor.section.contains(piece) for piece in pieces) or len(tray.solid.decompose()) != 1:
        failures.append(f"{tray.name} does not hold the puzzle in one solid")
    return TrayCheck(tray.name, gap, tuple(failures))


def check_tray_bed(transform: Transform, parameters: FabricationParameters) -> None:
    """Raise `riot.errors.FabricationError` ``bed`` if a tray is larger than the bed, even without room for knuckles."""
    outlines = {"tray-p": transform.outline_p(), "tray-q": transform.outline_q()}
    boxes = {name: np.ptp(points, axis=0) for name, points in outlines.items()}
    scale = parameters.size_mm / max(float(box.max()) for box in boxes.values())
    rim = 2.0 * (TRAY_GAP_MM + TRAY_WALL_MM)
    bed = np.sort([parameters.bed_width_mm, parameters.bed_depth_mm]) - 2.0 * BED_SPACE_MM
    for name, box in boxes.items():
        size = np.sort(box) * scale
        if (size + rim > bed).any():
            largest = math.floor(parameters.size_mm * float(((bed - rim) / size).min()))
            raise FabricationError(
                "bed",
                f"{name} is {size[1] + rim:.0f} × {size[0] + rim:.0f} mm, the bed {parameters.bed_width_mm:g} × "
                f"{parameters.bed_depth_mm:g} mm: lessen size_mm ({parameters.size_mm:g}) to about {largest}, tell of "
                "a larger bed (bed_width_mm, bed_depth_mm), or leave out --tray",
                "bed_width_mm",
            )


def _placed(design: Design, t: float) -> list[shapely.Geometry]:
    """All that is solid of the pieces, flat, closed as P (t = 0) or Q (1), as it lies in the tray; mm."""
    pose = design.transform.pose(t)

    def placed(index: int) -> shapely.Geometry:
        def place(points: FloatArray) -> FloatArray:
            return design.place(pose, index, points)

        return shapely.transform(design.pieces[index].footprint, place)

    pieces = [placed(piece.index) for piece in design.pieces]
    if t == 1.0 and design.transform.mirrored_q:
        return [affinity.scale(piece, -1.0, 1.0, origin=(0.0, 0.0)) for piece in pieces]
    return pieces
