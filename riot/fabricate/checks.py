"""What is verified of a design and its solids, check by check. Ours.

Nothing here trusts how the design was made: clearances are measured on the layers, overlaps on the solids.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import combinations, pairwise

import manifold3d
import numpy as np
import shapely

from riot.fabricate.clearance import HEIGHT_TOLERANCE, Proof, least_gaps, make_regions, proven, proven_at_hinge
from riot.fabricate.model import Design, HingeEnd, PieceDesign, Slab
from riot.fabricate.outlines import disc, mends, narrowest
from riot.fabricate.solid import Part, genus
from riot.fabricate.sub_chains import SubChain, sub_chains
from riot.transform.motion import LIFT
from riot.types import FloatArray

LENGTH_TOLERANCE = 2e-3
"""Lengths that fall short by less are as asked for: twice the grid of the flat outlines, mm."""

VOLUME_TOLERANCE = 1e-6
"""Relative difference of volumes that counts as none."""

OVERLAP_TOLERANCE = 1e-6
"""Volume of two solids in common that counts as none, mm³."""

LEAST_WALL = 0.8
"""Nothing thinner is printed reliably: two lines of a nozzle of 0.4 mm."""

POSES = 7
"""Poses at which solids are cut with each other, from P to Q; more if pieces lift."""


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


@dataclass(frozen=True)
class HingeCheck:
    """One hinge: gaps between its knuckles along the axis, and between pin and holes in radius; mm.

    Of a telescopic hinge ``axial_gap`` is that between cap and barrel, ``male_gap`` that of rod and sleeve, and
    ``female_gap`` that of sleeve and barrel.
    """

    hinge: int
    kind: str
    axial_gap: float
    male_gap: float
    female_gap: float
    failures: tuple[str, ...] = field(default=())


@dataclass(frozen=True)
class MotionCheck:
    """The whole way from P to Q; mm, mm³.

    Parameters
    ----------
    floor : float
        What two pieces must keep between them.
    proven : bool
        That they do at every moment of the motion, at every height; ``looked`` poses of two pieces show it.
    gap : float
        The least gap found among samples of the motion; hinged pieces count outside the room of their hinge.
    poses : int
        At how many poses the solids, pins and sleeves among them, were cut with each other.
    overlap : float
        The greatest volume that two of them had in common.
    """

    floor: float
    proven: bool
    looked: int
    gap: float
    poses: int
    overlap: float
    failures: tuple[str, ...] = field(default=())


def check_part(part: Part, piece: PieceDesign | None) -> PartCheck:
    """Verify one part by itself."""
    status = part.solid.status()
    volume, expected = part.volume, sum(slab.volume for slab in part.slabs)
    components = len(part.solid.decompose())
    found, wanted = int(part.solid.genus()), genus(part.slabs)
    wall = math.nan if piece is None else narrowest(piece)
    failures = []
    if status != manifold3d.Error.NoError or part.solid.is_empty():
        failures.append(f"{part.name} is no closed solid ({status.name})")
    if components != 1:
        failures.append(f"{part.name} is in {components} parts: enlarge size_mm")
    if abs(volume - expected) > VOLUME_TOLERANCE * expected:
        failures.append(f"{part.name} has {volume:.3f} mm³ where its layers have {expected:.3f}")
    if found != wanted:
        failures.append(f"{part.name} has {found} handles where its layers have {wanted}")
    mend = "size_mm"
    if piece is not None and wall < LEAST_WALL:
        mend = mends(piece, LEAST_WALL)
        failures.append(
            f"{part.name} (hinges {piece.start.hinge} and {piece.end.hinge}) is only {wall:.2f} mm wide where a "
            f"knuckle or a good part of it hangs on it, less than {LEAST_WALL:g}: enlarge {mend}"
        )
    return PartCheck(
        part.name, part.count, status.name, components, volume, expected, found, wanted, wall, mend, tuple(failures)
    )


def check_hinges(design: Design, parts: tuple[Part, ...]) -> tuple[HingeCheck, ...]:
    """Verify every hinge that joins two pieces."""
    n = len(design.pieces)
    return tuple(
        _check_pin(design, design.pieces[hinge - 1], design.pieces[hinge])
        if design.pieces[hinge].start.kind == "pin"
        else _check_telescope(design, hinge, parts)
        for hinge in range(n)
        if design.pieces[hinge].start.kind != "open"
    )


def _check_pin(design: Design, one: PieceDesign, two: PieceDesign) -> HingeCheck:
    """The male knuckle is the end of ``one``, the female ones the start of ``two``."""
    parameters, hinge = design.parameters, two.start.hinge
    radius = 0.5 * parameters.pin_mm
    male, female = _standing(one.slabs, one.end), _standing(two.slabs, two.start)
    axial = min((max(b.low - a.high, a.low - b.high) for a in male for b in female), default=math.inf)
    gaps = [
        min((slab.section.distance(shapely.Point(end.x, end.y)) for slab in slabs), default=0.0) - radius
        for slabs, end in ((male, one.end), (female, two.start))
    ]
    failures = []
    if axial < parameters.axial_gap_mm - LENGTH_TOLERANCE:
        failures.append(
            f"hinge {hinge}: knuckles of {one.name} and {two.name} are {axial:.2f} mm apart along the axis: "
            f"axial_gap_mm asks for {parameters.axial_gap_mm:g}"
        )
    for words, found, asked in (("male", gaps[0], "clearance_mm"), ("female", gaps[1], "play_mm")):
        if found < getattr(parameters, asked) - LENGTH_TOLERANCE:
            failures.append(
                f"hinge {hinge}: the pin has {found:.2f} mm around it in the {words} knuckle: {asked} asks for "
                f"{getattr(parameters, asked):g}"
            )
    return HingeCheck(hinge, "pin", float(axial), float(gaps[0]), float(gaps[1]), tuple(failures))


def _standing(slabs: tuple[Slab, ...], end: HingeEnd) -> list[Slab]:
    """The layers that have something of a knuckle around the axis of a hinge."""
    knuckle = disc(end.x, end.y, end.radius)
    return [slab for slab in slabs if slab.section.intersection(knuckle).area > 0.25 * knuckle.area]


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
    around = manifold3d.Manifold.cylinder(3.0 * parameters.height, telescope.radius, -1.0, 64)
    barrel, rod = barrel ^ around, rod ^ around
    axial = telescope.cap_height - telescope.barrel_height
    inner = float(sleeve.translate((0.0, 0.0, seat)).min_gap(rod, 2.0))
    outer = float(sleeve.translate((0.0, 0.0, seat)).min_gap(barrel, 2.0))
    failures = []
    for share in (0.0, 0.5, 1.0):
        raised = share * parameters.travel
        risen = raised * telescope.sleeve_travel / telescope.travel
        parts_at = (barrel, sleeve.translate((0.0, 0.0, seat + risen)), rod.translate((0.0, 0.0, raised)))
        common = max(_common(a, b) for a, b in combinations(parts_at, 2))
        if common > OVERLAP_TOLERANCE:
            failures.append(
                f"hinge {hinge}: its cylinders overlap by {common:.3g} mm³ when lifted by {raised:.1f} mm: enlarge "
                "telescope_gap_mm"
            )
    beyond = telescope.travel + 0.5 * parameters.layer_mm
    sleeve_up = sleeve.translate((0.0, 0.0, seat + telescope.sleeve_travel - 1e-3))
    caught = _common(rod.translate((0.0, 0.0, beyond)), sleeve_up) > OVERLAP_TOLERANCE
    held = _common(sleeve.translate((0.0, 0.0, seat + telescope.sleeve_travel + 0.1)), barrel) > OVERLAP_TOLERANCE
    if not (caught and held):
        failures.append(f"hinge {hinge}: its cylinders come apart: enlarge telescope_ledge_mm")
    if min(inner, outer) < min(parameters.telescope_gap_mm, parameters.layer_mm) - LENGTH_TOLERANCE:
        failures.append(f"hinge {hinge}: its cylinders are {min(inner, outer):.2f} mm apart: enlarge telescope_gap_mm")
    return HingeCheck(hinge, "telescopic", axial, inner, outer, tuple(failures))


def check_motion(design: Design, parts: tuple[Part, ...]) -> MotionCheck:
    """Verify the whole way from P to Q."""
    floor = design.parameters.gap_mm - LENGTH_TOLERANCE
    chains = sub_chains(design.motion, design.scale)
    failures: list[str] = []
    looked, gap, holds = 0, math.inf, True
    for sub_chain in chains:
        least, proof, said = _check_sub_chain(design, sub_chain, floor)
        gap, looked, holds = min(gap, least), looked + proof.looked, holds and proof.holds
        failures += said
    if len(chains) > 1:
        said = _check_lifting(design, chains, floor)
        holds = holds and not said
        failures += said
    times = pose_times(design)
    overlap = 0.0
    for t in times:
        common, said_of = _overlap(design, parts, t)
        overlap = max(overlap, common)
        if common > OVERLAP_TOLERANCE:
            failures.append(f"{said_of} overlap by {common:.3g} mm³ at time {t:.2f}: enlarge gap_mm or size_mm")
    return MotionCheck(floor, holds, looked, gap, len(times), overlap, tuple(failures))


def _check_sub_chain(design: Design, sub_chain: SubChain, floor: float) -> tuple[float, Proof, list[str]]:
    """Least gap, proof and failures of the pieces that share a plane."""
    pieces = [design.pieces[i] for i in sub_chain.pieces]
    ends = [(piece.start, piece.end) for piece in pieces]
    regions = make_regions([piece.footprint for piece in pieces], ends, [piece.length for piece in pieces])
    nearest = min(least_gaps(sub_chain, regions), key=lambda found: found.gap, default=None)
    gap = math.inf if nearest is None else nearest.gap
    proof, said = proven(design.motion, sub_chain, regions, floor), []
    looked, holds = proof.looked, proof.holds
    if not proof.holds:
        assert nearest is not None
        one, two = pieces[nearest.i], pieces[nearest.j]
        time = float(sub_chain.times[nearest.sample])
        hinge = f" at hinge {two.start.hinge}" if nearest.j == nearest.i + 1 else ""
        said.append(
            f"{one.name} and {two.name}{hinge} come within {nearest.gap:.3f} mm at time {time:.2f} "
            f"(clear up to {proof.time:.3f}): gap_mm asks for {design.parameters.gap_mm:g}"
        )
    for one, two in pairwise(pieces):
        at_hinge = proven_at_hinge(design.motion, one, two, floor)
        looked += at_hinge.looked
        if not at_hinge.holds:
            holds = False
            said.append(
                f"hinge {two.start.hinge}: {one.name} and {two.name} come nearer than {floor:.3f} mm around it at time "
                f"{at_hinge.time:.3f}: gap_mm asks for {design.parameters.gap_mm:g}"
            )
    return gap, Proof(holds, proof.time, looked), said


def _check_lifting(design: Design, chains: list[SubChain], floor: float) -> list[str]:
    """Failures of pieces to lift past each other in the closed P and the closed Q.

    A piece that rises meets of another all that is higher than its own lowest: so every layer of the one must be
    clear, in plan, of all of the other's that end above its lower face.
    """
    plane = {int(piece): k for k, sub_chain in enumerate(chains) for piece in sub_chain.pieces}
    said = []
    for t in (0.0, 1.0):
        placed = [_plan(design, i, t) for i in range(len(design.pieces))]
        for i, j in combinations(range(len(placed)), 2):
            if plane[i] == plane[j]:
                continue
            low, high = (i, j) if plane[i] < plane[j] else (j, i)
            near = math.inf
            for lying, below in placed[low]:
                for rising, above in placed[high]:
                    if rising.low < lying.high - HEIGHT_TOLERANCE and shapely.dwithin(below, above, floor):
                        near = min(near, float(below.distance(above)))
            if near < floor:
                said.append(
                    f"{design.pieces[high].name} cannot lift past {design.pieces[low].name} in the closed "
                    f"{'Q' if t else 'P'}: {near:.3f} mm between them where gap_mm asks for "
                    f"{design.parameters.gap_mm:g}"
                )
    return said


def _plan(design: Design, piece: int, t: float) -> list[tuple[Slab, shapely.Geometry]]:
    """The layers of a piece where the closed P (t = 0) or Q (1) has them, prepared."""
    pose, slabs = design.transform.pose(t), design.pieces[piece].slabs
    placed = [shapely.transform(slab.section, lambda points: design.place(pose, piece, points)) for slab in slabs]
    shapely.prepare(placed)
    return list(zip(slabs, placed, strict=True))


def pose_times(design: Design) -> FloatArray:
    """Times of the motion at which solids are cut with each other: even ones, and between lifting and lying."""
    times = np.linspace(0.0, 1.0, POSES)
    if design.motion.flat:
        return times
    moving = LIFT + (1.0 - 2.0 * LIFT) * times
    return np.concatenate([[0.0, 0.5 * LIFT], moving, [1.0 - 0.5 * LIFT, 1.0]])


def placed_parts(design: Design, parts: tuple[Part, ...], t: float) -> list[tuple[str, manifold3d.Manifold]]:
    """Every piece, pin and sleeve where the motion has it at time t, mm, with its name."""
    pose, heights = design.motion.pose_at(t), design.lift * design.motion.levels_at(t)
    named = {part.name: part.solid for part in parts}
    found = []
    for i, piece in enumerate(design.pieces):
        x, y = (design.scale * pose.origins[i]).tolist()
        z, turn = float(heights[i]), float(pose.headings[i])
        c, s = math.cos(turn), math.sin(turn)
        found.append((piece.name, named[piece.name].transform(((c, -s, 0.0, x), (s, c, 0.0, y), (0.0, 0.0, 1.0, z)))))
        if piece.start.kind == "pin":
            found.append((f"the pin of hinge {i}", named["pin"].translate((x, y, z))))
        elif piece.start.kind == "telescopic" and design.telescope is not None:
            ground = float(heights[i - 1])
            risen = (z - ground) * design.telescope.sleeve_travel / design.telescope.travel
            up = ground + design.telescope.sleeve[0].low + risen
            found.append((f"the sleeve of hinge {i}", named["sleeve"].translate((x, y, up))))
    return found


def _overlap(design: Design, parts: tuple[Part, ...], t: float) -> tuple[float, str]:
    """The greatest volume that two parts have in common at time t, and which two."""
    worst, said = 0.0, ""
    for (name, one), (other, two) in combinations(placed_parts(design, parts, t), 2):
        common = _common(one, two)
        if common > worst:
            worst, said = common, f"{name} and {other}"
    return worst, said


def _common(one: manifold3d.Manifold, two: manifold3d.Manifold) -> float:
    """Volume that two solids have in common, mm³."""
    a, b = one.bounding_box(), two.bounding_box()
    if any(a[k] >= b[k + 3] or b[k] >= a[k + 3] for k in range(3)):
        return 0.0
    return float((one ^ two).volume())
