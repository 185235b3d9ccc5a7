"""The exact construction: both trunks of a plan partitioned, pieces cut (theory §8)."""

from __future__ import annotations

import math

import numpy as np

from riot.construct.dissect import dissect
from riot.construct.plan import Plan
from riot.parameters import ConstructParameters
from riot.polyline import edge_lengths, trunk_angles
from riot.pose import Placement, rotate
from riot.shape import FloatArray, IntArray
from riot.transform import Piece, Transform


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
        trunk_p=plan.feet[0],
        trunk_q=plan.feet[1],
        bound_p=plan.bound_p,
        bound_q=plan.bound_q,
    )


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
