"""The exact construction: conjugate trunks, arcs swung in, both trunks partitioned, pieces cut (theory §7, §8)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from riot.certify import overlap_ratio
from riot.construct.conjugate import is_convex, make_conjugate
from riot.construct.dissect import dissect
from riot.errors import ConstructionError
from riot.kernels.coverage import swung_arcs, uncovered
from riot.parameters import ConstructParameters
from riot.polyline import edge_lengths, signed_area, trunk_angles
from riot.pose import Placement, rotate
from riot.shape import FloatArray, IntArray, Shape
from riot.transform import Piece, Transform


@dataclass(frozen=True, eq=False)
class TrunkPair:
    """Corresponding trunks of two outlines.

    Parameters
    ----------
    p, q : Shape
        The inputs.
    outline_p, outline_q : (m, 2) float64
        Their outlines, with the trunk vertices among the points.
    trunk_p, trunk_q : (n,) int64
        Trunk vertices among those points, in corresponding order: counter-clockwise on P, clockwise on Q.
    """

    p: Shape
    q: Shape
    outline_p: FloatArray
    outline_q: FloatArray
    trunk_p: IntArray
    trunk_q: IntArray


@dataclass(frozen=True, eq=False)
class Plan:
    """A trunk pair made conjugate, with the arcs of either outline swung into the other's trunk.

    ``trunk_p``, ``trunk_q`` (n, 2) are conjugate, in corresponding order. ``arcs_p`` (s, 2) with ``offsets_p`` (n +
    1,): P's arcs in Q's trunk, arc i from corner i to corner i + 1 of ``trunk_q``; ``arcs_q``: Q's arcs in P's trunk,
    arc i from corner n − i to corner n − 1 − i of ``trunk_p`` (mod n). ``followed_*``
    are the outlines whose arcs have followed their trunks; ``expected_*`` the highest IoU with these that an exact
    construction can have, and the partition reaches it.
    """

    pair: TrunkPair
    trunk_p: FloatArray
    trunk_q: FloatArray
    arcs_p: FloatArray
    offsets_p: IntArray
    arcs_q: FloatArray
    offsets_q: IntArray
    followed_p: FloatArray
    followed_q: FloatArray
    expected_p: float
    expected_q: float

    @cached_property
    def bound_p(self) -> float:
        """The highest IoU with P that an exact construction can have, by the triangle inequality of the Jaccard
        distance."""
        return min(1.0, self.expected_p + 1.0 - overlap_ratio(self.followed_p, self.pair.outline_p))

    @cached_property
    def bound_q(self) -> float:
        """The same for Q."""
        return min(1.0, self.expected_q + 1.0 - overlap_ratio(self.followed_q, self.pair.outline_q))

    @property
    def bound(self) -> float:
        """Of the worse shape."""
        return min(self.bound_p, self.bound_q)

    @property
    def expected(self) -> float:
        """Of the worse shape."""
        return min(self.expected_p, self.expected_q)


def plan_pair(pair: TrunkPair, parameters: ConstructParameters) -> Plan:
    """Make the trunks conjugate, swing the arcs in, and bound the IoU; ConstructionError if the trunks fail."""
    corners_p, corners_q = pair.outline_p[pair.trunk_p], pair.outline_q[pair.trunk_q]
    for name, trunk in (("P", corners_p), ("Q", corners_q[::-1])):
        if not is_convex(trunk):
            raise ConstructionError("not-convex", f"the trunk of {name} is not convex")
    trunk_p, trunk_q = make_conjugate(corners_p, corners_q)
    arcs_p, offsets_p = _swing(pair.outline_p, pair.trunk_p, trunk_q)
    arcs_q, offsets_q = _swing(pair.outline_q, pair.trunk_q[::-1], trunk_p[::-1])
    followed_p = _followed(pair.outline_p, pair.trunk_p, trunk_p)
    followed_q = _followed(pair.outline_q, pair.trunk_q[::-1], trunk_q[::-1])
    expected_p = _least_change(trunk_q, arcs_p, offsets_p, followed_p, parameters.lines)
    expected_q = _least_change(trunk_p, arcs_q, offsets_q, followed_q, parameters.lines)
    return Plan(
        pair,
        trunk_p,
        trunk_q,
        arcs_p,
        offsets_p,
        arcs_q,
        offsets_q,
        followed_p,
        followed_q,
        expected_p,
        expected_q,
    )


def construct_plan(plan: Plan, parameters: ConstructParameters) -> Transform:
    """Partition both trunks and cut the pieces; ConstructionError with the reason if a partition fails."""
    # A dissection is made in a counter-clockwise trunk, region k on the edge from corner k to corner k + 1.
    lower = dissect(plan.trunk_q[::-1], _reverse_arcs(plan.arcs_p, plan.offsets_p), parameters, "Q's trunk")
    upper = dissect(plan.trunk_p, _reverse_arcs(plan.arcs_q, plan.offsets_q), parameters, "P's trunk")
    n = len(plan.trunk_p)
    lengths = 0.5 * (edge_lengths(plan.trunk_p) + edge_lengths(plan.trunk_q))
    pieces = []
    for i in range(n):
        # Corner i + 1 of Q's trunk in corresponding order is corner n − 2 − i of it read backwards.
        below = lower[(n - 2 - i) % n][::-1]
        above = upper[i][::-1]
        pieces.append(
            Piece(
                float(lengths[i]),
                _in_piece_frame(below, plan.trunk_q[i], plan.trunk_q[(i + 1) % n], float(lengths[i])),
                _in_piece_frame(above, plan.trunk_p[i], plan.trunk_p[(i + 1) % n], float(lengths[i])),
            )
        )
    return Transform(
        pieces=tuple(pieces),
        angles=trunk_angles(plan.trunk_p),
        conjugate_angles=trunk_angles(plan.trunk_q),
        place_p=Placement.of(plan.trunk_p),
        place_q=Placement.of(plan.trunk_q),
        p=plan.pair.p,
        q=plan.pair.q,
        trunk_p=plan.pair.outline_p[plan.pair.trunk_p],
        trunk_q=plan.pair.outline_q[plan.pair.trunk_q],
        bound_p=plan.bound_p,
        bound_q=plan.bound_q,
    )


def _swing(outline: FloatArray, trunk: IntArray, target: FloatArray) -> tuple[FloatArray, IntArray]:
    n = len(trunk)
    out, offsets = np.empty((len(outline) + n, 2)), np.empty(n + 1, dtype=np.int64)
    total = swung_arcs(outline, np.ascontiguousarray(trunk), np.ascontiguousarray(target), out, offsets)
    return out[:total], offsets


def _followed(outline: FloatArray, trunk: IntArray, moved: FloatArray) -> FloatArray:
    """The outline, (m, 2), whose arcs have followed its trunk from ``trunk`` (n,) to ``moved`` (n, 2)."""
    arcs, offsets = _swing(outline, trunk, moved)
    once = np.ones(len(arcs), dtype=np.bool_)
    once[offsets[1:] - 1] = False
    return arcs[once]


def _least_change(target: FloatArray, arcs: FloatArray, offsets: IntArray, followed: FloatArray, lines: int) -> float:
    """The highest IoU with the followed outline that an exact construction can have (theory §8)."""
    gaps, overlaps, outside = uncovered(np.ascontiguousarray(target), arcs, offsets, lines)
    area = signed_area(followed)
    return float((area - overlaps - outside) / (area + gaps))


def _reverse_arcs(arcs: FloatArray, offsets: IntArray) -> tuple[FloatArray, IntArray]:
    """The arcs in opposite order, each read backwards: what runs clockwise around a trunk then runs
    counter-clockwise."""
    total = offsets[-1]
    return np.ascontiguousarray(arcs[::-1]), (total - offsets[::-1]).astype(np.int64)


def _in_piece_frame(path: FloatArray, start: FloatArray, stop: FloatArray, length: float) -> FloatArray:
    """Move a path from ``start`` to ``stop``, or back, so that these lie at (0, 0) and (length, 0), exactly."""
    edge = stop - start
    moved = rotate(path - start, -math.atan2(edge[1], edge[0]))
    ends = np.array([[0.0, 0.0], [length, 0.0]])
    forwards = abs(moved[0, 0]) < 0.5 * length
    moved[0], moved[-1] = (ends[0], ends[1]) if forwards else (ends[1], ends[0])
    return moved
