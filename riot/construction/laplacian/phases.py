"""The three phases: scale arcs that leave the trunk, push overlapping arcs apart, close gaps (paper §4.3).

The paper: "move the deepest point along the vector to the nearest point of the other arc", 0.003 a step, by Laplacian
editing, end points and points in contact fixed; gaps "the same way". Where it is silent we decided:

* The deepest point is looked for anew after every step, among the vertices of all arcs; so two arcs that overlap give
  way by turns. A point's depth is its distance to the arc whose piece it lies in.
* A gap's deepest point is the vertex farthest from the nearest other arc that lies ahead of it, outside its own piece.
* Editing starts from the arc as it stands, so that a step adds to those before.
* A point outside the trunk is treated as one in an overlap.
"""

from __future__ import annotations

import numpy as np

from riot.construction.laplacian.contact import TrunkArcs
from riot.construction.laplacian.editing import Editing
from riot.construction.tuning import CONTACT_DISTANCE, EDIT_STEP, LEAST_ARC_SCALE, SCALE_TRIALS
from riot.kernels.laplacian import ComplexArray
from riot.types import FloatArray


def scale_arcs(trunk: FloatArray, arcs: list[FloatArray]) -> list[FloatArray]:
    """Arcs (m_i, 2) of a clockwise convex trunk (n, 2), scaled where they leave it.

    The paper does not say about what. An arc's ends must stay, so its height over its own trunk edge is scaled, by the
    greatest factor at which it leaves the trunk by no more than `riot.construction.tuning.CONTACT_DISTANCE`. Where the
    arc is beyond its own edge it is laid on it. Scaling cannot bring in an arc that leaves sideways, next to a corner:
    if no factor from `riot.construction.tuning.LEAST_ARC_SCALE` on does it, `part_overlaps` has to.
    """
    return [_scaled(trunk, k, arc) for k, arc in enumerate(arcs)]


def _scaled(trunk: FloatArray, k: int, arc: FloatArray) -> FloatArray:
    edges = np.roll(trunk, -1, axis=0) - trunk
    outwards = np.column_stack([-edges[:, 1], edges[:, 0]]) / np.hypot(*edges.T)[:, None]
    if _excess(trunk, outwards, arc) < CONTACT_DISTANCE:
        return arc
    height = -((arc - trunk[k]) @ outwards[k])
    base = arc + height[:, None] * outwards[k]
    height = np.maximum(height, 0.0)
    chosen: FloatArray = base - height[:, None] * outwards[k]
    for scale in np.linspace(1.0, LEAST_ARC_SCALE, SCALE_TRIALS).tolist():
        candidate = base - scale * height[:, None] * outwards[k]
        if _excess(trunk, outwards, candidate) < CONTACT_DISTANCE:
            chosen = candidate
            break
    chosen[[0, -1]] = arc[[0, -1]]
    return chosen


def _excess(trunk: FloatArray, outwards: FloatArray, arc: FloatArray) -> float:
    """How far an arc goes beyond one of the trunk's edges at most."""
    offsets = (trunk * outwards).sum(axis=1)
    return float((arc @ outwards.T - offsets).max())


def part_overlaps(arcs: TrunkArcs, most: int) -> int:
    """Push arcs out of each other's pieces, and into the trunk, in ``most`` steps at most; returns how many."""
    for step in range(most):
        if not _advance(arcs, *arcs.overlaps(), trunk=True):
            return step
    return most


def close_gaps(arcs: TrunkArcs, most: int) -> int:
    """Pull arcs towards each other across gaps, in ``most`` steps at most; returns how many."""
    for step in range(most):
        if not _advance(arcs, *arcs.gaps(), trunk=False):
            return step
    return most


def _advance(arcs: TrunkArcs, depth: FloatArray, foot: ComplexArray, *, trunk: bool) -> bool:
    """Move the deepest vertex a step towards its foot; False if there is none deeper than `CONTACT_DISTANCE`."""
    k = int(depth.argmax())
    if depth[k] < CONTACT_DISTANCE:
        return False
    i = int(arcs.owner[k])
    span = arcs.span(i)
    fixed = (arcs.contact(trunk=trunk) | arcs.ends)[span]
    here = k - span.start
    fixed[here] = True
    moves = np.zeros(len(fixed), dtype=np.complex128)
    moves[here] = (foot[k] - arcs.points[k]) * min(1.0, EDIT_STEP / depth[k])
    arcs.points[span] += Editing.of(arcs.points[span], fixed).displace(moves)
    arcs.renew(i)
    return True
