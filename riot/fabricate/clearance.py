"""The gaps between pieces of one plane during the motion: sampled, and proven for every moment. Ours."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import shapely
from shapely import affinity

from riot.fabricate.model import HingeEnd, PieceDesign, Slab, filled, polygons
from riot.fabricate.outlines import disc, polygons_by_area, subtract
from riot.fabricate.sub_chains import SubChain, moving, sub_chain_at
from riot.fabricate.tuning import (
    GAP_CAP_MM,
    HEIGHT_TOLERANCE_MM,
    QUARTER_SEGMENTS,
    SHAVE_MARGIN_MM,
    SHAVE_ROUNDS,
    SHAVE_SAMPLES,
)
from riot.kernels.collide import clear_share, separation
from riot.transform.motion import Motion
from riot.types import FloatArray, IntArray

_NO_HINGE = HingeEnd(-1, "open", "none", 0.0, 0.0, (), (), 0.0)
_NO_HINGES = _NO_HINGE, _NO_HINGE


@dataclass(frozen=True, eq=False)
class Regions:
    """Flat regions of the pieces of one sub-chain, three a piece, as `riot.kernels.collide` takes them; mm.

    Region 3k is what piece k covers, 3k + 1 the same without the room around the hinge at its start, 3k + 2 at its
    end: of two pieces on one hinge these count.
    """

    points: FloatArray
    rings: IntArray
    bodies: IntArray
    lengths: FloatArray
    reaches: FloatArray


@dataclass(frozen=True)
class Nearest:
    """The least gap between two pieces of a sub-chain (members i < j) among the samples, and where it is."""

    i: int
    j: int
    gap: float
    sample: int


def make_regions(
    covers: list[shapely.Geometry], ends: list[tuple[HingeEnd, HingeEnd]], lengths: list[float]
) -> Regions:
    """The regions of pieces in chain order."""
    covered = []
    for cover, pair in zip(covers, ends, strict=True):
        covered += [cover, *(outside(cover, end) for end in pair)]
    rings = [[shapely.get_coordinates(polygon.exterior)[:-1] for polygon in polygons(region)] for region in covered]
    flat = [ring for of_region in rings for ring in of_region]
    reaches = []
    for of_region, length in zip(rings[::3], lengths, strict=True):
        points = np.concatenate([np.zeros((1, 2)), *of_region])
        reaches.append([np.hypot(points[:, 0] - x, points[:, 1]).max() for x in (0.0, length)])
    return Regions(
        np.concatenate([np.empty((0, 2)), *flat]),
        _offsets([len(ring) for ring in flat]),
        _offsets([len(of_region) for of_region in rings]),
        np.array(lengths),
        np.array(reaches),
    )


def outside(region: shapely.Geometry, end: HingeEnd) -> shapely.Geometry:
    """A region without the room around a hinge; all of it if there is no hinge."""
    if end.relief_radius == 0.0:
        return region
    return region.difference(disc(end.x, end.y, end.relief_radius))


def least_gaps(sub_chain: SubChain, regions: Regions) -> list[Nearest]:
    """The least gap of every two pieces over the samples of a sub-chain, `GAP_CAP_MM` or more if it is wider."""
    nearest = []
    for i, j in combinations(range(len(sub_chain.pieces)), 2):
        gaps = pair_gaps(sub_chain, regions, i, j)
        k = int(gaps.argmin())
        nearest.append(Nearest(i, j, float(gaps[k]), k))
    return nearest


def pair_gaps(sub_chain: SubChain, regions: Regions, i: int, j: int) -> FloatArray:
    """(k,) gap of two pieces at every sample, mm; `GAP_CAP_MM` or more where it is wider."""
    a, b = (3 * i + 2, 3 * j + 1) if j == i + 1 else (3 * i, 3 * j)
    position = sub_chain.seen_from(i, sub_chain.points[:, j])
    turned = sub_chain.headings[:, j] - sub_chain.headings[:, i]
    poses = np.concatenate([position, turned[:, None]], axis=1)
    return np.array(
        [separation(regions.points, regions.rings, regions.bodies, a, b, pose, GAP_CAP_MM) for pose in poses]
    )


@dataclass(frozen=True)
class Proof:
    """A proof that pieces stay apart at every moment of the motion.

    ``complete`` tells whether the proof reaches the end of the motion, ``time`` how far it reaches, and ``examined``
    how many poses of two pieces it examines.
    """

    complete: bool
    time: float
    examined: int


def proven(motion: Motion, sub_chain: SubChain, regions: Regions, floor: float) -> Proof:
    """Whether all pieces of a sub-chain stay ``floor`` mm or more apart at every moment, not only at samples.

    By conservative advancement (`riot.kernels.collide.clear_share`) from key frame to key frame.
    """
    return _proven(motion, sub_chain.pieces[1:], regions, floor)


def proven_at_hinge(motion: Motion, before: PieceDesign, after: PieceDesign, floor: float) -> Proof:
    """Whether two pieces on one pin hinge stay ``floor`` mm or more apart wherever both have something at one height.

    Their knuckles, and the room for them, count as they are. A pin in its socket is the hinge's check.
    """
    sections = {
        (first.wkb, second.wkb): [first, second]
        for one in before.slabs
        for other in after.slabs
        if min(one.high, other.high) - max(one.low, other.low) > HEIGHT_TOLERANCE_MM
        for first, second in [(_without_pin(one, before.end), _without_pin(other, after.start))]
    }
    examined = 0
    for pair in sections.values():
        regions = make_regions(pair, [_NO_HINGES, _NO_HINGES], [before.length, after.length])
        proof = _proven(motion, np.array([after.start.hinge]), regions, floor)
        examined += proof.examined
        if not proof.complete:
            return Proof(False, proof.time, examined)
    return Proof(True, 1.0, examined)


def _without_pin(slab: Slab, end: HingeEnd) -> shapely.Geometry:
    """A layer with its holes filled, without a pin that is within a socket."""
    region = filled(slab.section)
    if slab.high > end.captive + HEIGHT_TOLERANCE_MM:
        return region
    return region.difference(disc(end.x, end.y, end.radius, outside=True))


def _proven(motion: Motion, hinges: IntArray, regions: Regions, floor: float) -> Proof:
    times = moving(motion)
    turns = motion.turns[np.isin(motion.times, times)][:, hinges]
    examined = 0
    if len(hinges) == 0:
        return Proof(True, 1.0, 0)
    for k in range(len(times) - 1):
        share, checks = clear_share(
            regions.points,
            regions.rings,
            regions.bodies,
            regions.lengths,
            regions.reaches,
            turns[k].copy(),
            turns[k + 1].copy(),
            floor,
            GAP_CAP_MM,
            False,
        )
        examined += int(checks)
        if share < 1.0:
            return Proof(False, float(times[k] + share * (times[k + 1] - times[k])), examined)
    return Proof(True, 1.0, examined)


def shaved(
    bodies: list[shapely.Polygon],
    ends: list[tuple[HingeEnd, HingeEnd]],
    lengths: list[float],
    motion: Motion,
    chains: list[SubChain],
    gap: float,
    scale: float,
) -> list[shapely.Polygon]:
    """The bodies with so much taken off that no two of a plane come nearer than ``gap`` mm on their way.

    Planned motions let pieces slip by each other closer than that; the larger of the two pieces gives way. Done at all
    samples, then wherever between them the gap turns out to be less, `TRIES` times at most.
    """
    remaining = list(bodies)
    for sub_chain in chains:
        _shave(remaining, ends, lengths, sub_chain, gap)
        pieces = sub_chain.pieces.tolist()
        for _ in range(SHAVE_ROUNDS):
            regions = make_regions(
                [remaining[i] for i in pieces], [ends[i] for i in pieces], [lengths[i] for i in pieces]
            )
            proof = proven(motion, sub_chain, regions, gap)
            if proof.complete:
                break
            before = int(np.searchsorted(sub_chain.times, proof.time, side="right")) - 1
            after = min(before + 2, len(sub_chain.times) - 1)
            times = np.linspace(sub_chain.times[before], sub_chain.times[after], SHAVE_SAMPLES)
            _shave(
                remaining, ends, lengths, sub_chain_at(motion, scale, sub_chain.pieces, times), gap + SHAVE_MARGIN_MM
            )
    return remaining


def _shave(
    bodies: list[shapely.Polygon],
    ends: list[tuple[HingeEnd, HingeEnd]],
    lengths: list[float],
    sub_chain: SubChain,
    gap: float,
) -> None:
    """Take off of the pieces in ``made`` what is nearer than the gap at a sample."""
    pieces = sub_chain.pieces.tolist()
    regions = make_regions([bodies[i] for i in pieces], [ends[i] for i in pieces], [lengths[i] for i in pieces])
    for i, j in combinations(range(len(pieces)), 2):
        near = np.flatnonzero(pair_gaps(sub_chain, regions, i, j) < gap)
        if len(near) == 0:
            continue
        keep, cut = sorted((i, j), key=lambda k: bodies[pieces[k]].area)
        kept = bodies[pieces[keep]]
        if j == i + 1:
            kept = outside(kept, ends[pieces[keep]][1 if keep == i else 0])
        bodies[pieces[cut]] = _shaved(sub_chain, bodies[pieces[cut]], kept, cut, keep, near, gap)


def _shaved(
    sub_chain: SubChain,
    body: shapely.Polygon,
    other: shapely.Geometry,
    member: int,
    neighbour: int,
    samples: IntArray,
    gap: float,
) -> shapely.Polygon:
    """A member's body less a neighbour's, with the gap around it, at some samples."""
    grown = other.buffer(gap + SHAVE_MARGIN_MM, quad_segs=QUARTER_SEGMENTS)
    cuts = []
    for k in samples.tolist():
        turn = float(sub_chain.headings[k, neighbour] - sub_chain.headings[k, member])
        origin = sub_chain.seen_from(member, sub_chain.points[:, neighbour])[k]
        c, s = math.cos(turn), math.sin(turn)
        cuts.append(affinity.affine_transform(grown, [c, -s, s, c, *origin.tolist()]))
    left = polygons_by_area(subtract(body, shapely.union_all(cuts)))
    return shapely.Polygon(left[0].exterior) if left else shapely.Polygon()


def _offsets(sizes: list[int]) -> IntArray:
    return np.concatenate([[0], np.cumsum(np.array(sizes, dtype=np.int64))]).astype(np.int64)
