"""The check of the whole motion from P to Q: the gaps between layers, and the overlaps between solids. Ours."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import combinations, pairwise

import numpy as np
import shapely

from riot.errors import needs_extra
from riot.fabricate.clearance import Proof, least_gaps, make_regions, proven, proven_at_hinge
from riot.fabricate.layers import rings_slabs
from riot.fabricate.model import Design, Slab
from riot.fabricate.solid import Part, common_volume, extruded
from riot.fabricate.sub_chains import SubChain, sub_chains
from riot.fabricate.tuning import (
    HEIGHT_TOLERANCE_MM,
    LENGTH_TOLERANCE_MM,
    OVERLAP_POSES,
    OVERLAP_TOLERANCE_MM3,
)
from riot.transform.motion import LIFT
from riot.types import FloatArray

with needs_extra("print"):
    import manifold3d


@dataclass(frozen=True)
class MotionCheck:
    """The whole way from P to Q; mm, mm³.

    Parameters
    ----------
    floor : float
        What two pieces must keep between them.
    proven : bool
        That they do at every moment of the motion, at every height; ``examined`` poses of two pieces show it.
    gap : float
        The least gap found among samples of the motion; hinged pieces count outside the room of their hinge.
    poses : int
        At how many poses the solids, pins and sleeves among them, were cut with each other.
    overlap : float
        The greatest volume that two of them had in common.
    """

    floor: float
    proven: bool
    examined: int
    gap: float
    poses: int
    overlap: float
    failures: tuple[str, ...] = field(default=())


def check_motion(design: Design, parts: tuple[Part, ...]) -> MotionCheck:
    """Verify the whole way from P to Q."""
    floor = design.parameters.gap_mm - LENGTH_TOLERANCE_MM
    chains = sub_chains(design.motion, design.scale)
    failures: list[str] = []
    examined, gap, complete = 0, math.inf, True
    for sub_chain in chains:
        least, proof, messages = _check_sub_chain(design, sub_chain, floor)
        gap, examined, complete = min(gap, least), examined + proof.examined, complete and proof.complete
        failures += messages
    if len(chains) > 1:
        messages = _check_lifting(design, chains, floor)
        complete = complete and not messages
        failures += messages
    times = pose_times(design)
    overlap = 0.0
    for t in times:
        common, pair = _overlap(design, parts, t)
        overlap = max(overlap, common)
        if common > OVERLAP_TOLERANCE_MM3:
            failures.append(f"{pair} overlap by {common:.3g} mm³ at time {t:.2f}: enlarge gap_mm or size_mm")
    return MotionCheck(floor, complete, examined, gap, len(times), overlap, tuple(failures))


def _check_sub_chain(design: Design, sub_chain: SubChain, floor: float) -> tuple[float, Proof, list[str]]:
    """Least gap, proof and failures of the pieces that share a plane."""
    pieces = [design.pieces[i] for i in sub_chain.pieces]
    ends = [(piece.start, piece.end) for piece in pieces]
    regions = make_regions([piece.footprint for piece in pieces], ends, [piece.length for piece in pieces])
    nearest = min(least_gaps(sub_chain, regions), key=lambda pair: pair.gap, default=None)
    gap = math.inf if nearest is None else nearest.gap
    proof, messages = proven(design.motion, sub_chain, regions, floor), []
    examined, complete = proof.examined, proof.complete
    if not proof.complete:
        assert nearest is not None
        first, second = pieces[nearest.i], pieces[nearest.j]
        time = float(sub_chain.times[nearest.sample])
        hinge = f" at hinge {second.start.hinge}" if nearest.j == nearest.i + 1 else ""
        messages.append(
            f"{first.name} and {second.name}{hinge} come within {nearest.gap:.3f} mm at time {time:.2f} "
            f"(clear up to {proof.time:.3f}): gap_mm asks for {design.parameters.gap_mm:g}"
        )
    for first, second in pairwise(pieces):
        at_hinge = proven_at_hinge(design.motion, first, second, floor)
        examined += at_hinge.examined
        if not at_hinge.complete:
            complete = False
            messages.append(
                f"hinge {second.start.hinge}: {first.name} and {second.name} come nearer than {floor:.3f} mm around it "
                f"at time {at_hinge.time:.3f}: gap_mm asks for {design.parameters.gap_mm:g}"
            )
    return gap, Proof(complete, proof.time, examined), messages


def _check_lifting(design: Design, chains: list[SubChain], floor: float) -> list[str]:
    """Failures of pieces to lift past each other in the closed P and the closed Q.

    A piece that rises meets of another all that is higher than its own lowest: so every layer of the one must be
    clear, in plan, of all of the other's that end above its lower face.
    """
    plane = {int(piece): k for k, sub_chain in enumerate(chains) for piece in sub_chain.pieces}
    messages = []
    for t in (0.0, 1.0):
        placed = [_plan(design, i, t) for i in range(len(design.pieces))]
        for i, j in combinations(range(len(placed)), 2):
            if plane[i] == plane[j]:
                continue
            low, high = (i, j) if plane[i] < plane[j] else (j, i)
            near = math.inf
            for lying, below in placed[low]:
                for rising, above in placed[high]:
                    if rising.low < lying.high - HEIGHT_TOLERANCE_MM and shapely.dwithin(below, above, floor):
                        near = min(near, float(below.distance(above)))
            if near < floor:
                messages.append(
                    f"{design.pieces[high].name} cannot lift past {design.pieces[low].name} in the closed "
                    f"{'Q' if t else 'P'}: {near:.3f} mm between them where gap_mm asks for "
                    f"{design.parameters.gap_mm:g}"
                )
    return messages


def _plan(design: Design, piece: int, t: float) -> list[tuple[Slab, shapely.Geometry]]:
    """The layers of a piece where the closed P (t = 0) or Q (1) has them, prepared."""
    pose, slabs = design.transform.pose(t), design.pieces[piece].slabs
    placed = [shapely.transform(slab.section, lambda points: design.place(pose, piece, points)) for slab in slabs]
    shapely.prepare(placed)
    return list(zip(slabs, placed, strict=True))


def pose_times(design: Design) -> FloatArray:
    """Times of the motion at which solids are cut with each other: even ones, and between lifting and lying."""
    times = np.linspace(0.0, 1.0, OVERLAP_POSES)
    if design.motion.flat:
        return times
    moving = LIFT + (1.0 - 2.0 * LIFT) * times
    return np.concatenate([[0.0, 0.5 * LIFT], moving, [1.0 - 0.5 * LIFT, 1.0]])


def placed_parts(design: Design, parts: tuple[Part, ...], t: float) -> list[tuple[str, manifold3d.Manifold]]:
    """Every piece, pin and sleeve where the motion has it at time t, mm, with its name."""
    pose, heights = design.motion.pose_at(t), design.lift * design.motion.levels_at(t)
    named = {part.name: part.solid for part in parts}
    profile = () if design.pivot is None else design.pivot.profile
    pin = extruded(rings_slabs(profile)) if profile else None
    placed = []
    for i, piece in enumerate(design.pieces):
        x, y = (design.scale * pose.origins[i]).tolist()
        z, turn = float(heights[i]), float(pose.headings[i])
        c, s = math.cos(turn), math.sin(turn)
        placed.append((piece.name, named[piece.name].transform(((c, -s, 0.0, x), (s, c, 0.0, y), (0.0, 0.0, 1.0, z)))))
        if piece.start.kind == "pin" and pin is not None:
            placed.append((f"the pin of hinge {i}", pin.translate((x, y, z))))
        elif piece.start.kind == "telescopic" and design.telescope is not None:
            ground = float(heights[i - 1])
            risen = (z - ground) * design.telescope.sleeve_travel / design.telescope.travel
            up = ground + design.telescope.sleeve[0].low + risen
            placed.append((f"the sleeve of hinge {i}", named["sleeve"].translate((x, y, up))))
    return placed


def pressed_pairs(design: Design) -> list[set[str]]:
    """Names of a pin and of the piece whose hole it is pressed into, for every hinge: these overlap."""
    return [
        {f"the pin of hinge {piece.index}", (design.pieces[piece.index - 1] if piece.upside_down else piece).name}
        for piece in design.pieces
        if piece.start.kind == "pin" and design.pins
    ]


def _overlap(design: Design, parts: tuple[Part, ...], t: float) -> tuple[float, str]:
    """The greatest volume that two parts have in common at time t, and which two."""
    worst, pair = 0.0, ""
    pressed = pressed_pairs(design)
    for (name, solid), (other, other_solid) in combinations(placed_parts(design, parts, t), 2):
        if {name, other} in pressed:
            continue
        common = common_volume(solid, other_solid)
        if common > worst:
            worst, pair = common, f"{name} and {other}"
    return worst, pair
