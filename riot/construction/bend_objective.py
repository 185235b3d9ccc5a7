"""What trunks and bends of a pair are worth together, and its gradient (theory §12; ours).

softmin(bound_P, bound_Q) − attach − weight · (E_P + E_Q) − contact: the bounds are against the bent shapes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from riot.construction.bend_arcs import SwungArcs, areas_of, iou_gradient, swing_arcs, swung_back
from riot.construction.bend_contact import contact_cost
from riot.construction.bent_side import BentSide
from riot.construction.tuning import FLAT_TURN, FLAT_WEIGHT, SPARE_CONTACT
from riot.types import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class BendObjective:
    """The function that is maximised.

    Parameters
    ----------
    sides : two BentSide
        P and Q.
    windows : two (n, 2) int64 arrays
        As `riot.construction.plan.TrunkPair.windowed_outlines` has them, Q's for its trunk read backwards.
    lines : int
        Scanlines.
    sharpness : float
        1 / IoU: how near the softmin is to the worse shape's bound.
    attach : float
        Weight of the squared distances of corners from the bent outlines.
    weight : float
        Weight of the energies.
    contact : float
        Weight of the squares of what other pieces cover of trunk edges beyond a part of what is allowed.
    allowed : float
        Share of a trunk edge that other pieces may cover.
    """

    sides: tuple[BentSide, BentSide]
    windows: tuple[IntArray, IntArray]
    lines: int
    sharpness: float
    attach: float
    weight: float
    contact: float
    allowed: float

    def rate(
        self, trunks: FloatArray, amplitudes: Sequence[FloatArray]
    ) -> tuple[float, FloatArray, tuple[FloatArray, FloatArray], float]:
        """The value, its gradient by trunks (2, n, 2) and by both amplitudes (K,), and the value with the worse bound
        in place of the softmin; −inf where nothing is left of a shape."""
        swung = [self._swing(side, trunks, amplitudes[side]) for side in range(2)]
        if swung[0] is None or swung[1] is None:
            return (
                -math.inf,
                np.zeros_like(trunks),
                (np.zeros_like(amplitudes[0]), np.zeros_like(amplitudes[1])),
                -math.inf,
            )
        bent = [side for side in swung if side is not None]
        ious = np.array([side.iou for side in bent])
        worse = float(ious.min())
        parts = np.exp(-self.sharpness * (ious - worse))
        total = float(parts.sum())
        cost, by_trunks = _flatness(trunks)
        by_trunks, by_amplitudes = -by_trunks, []
        for which, part in enumerate(parts / total):
            side_cost, along_trunks, along_amplitudes = self._gradient(
                which, bent[which], float(part), amplitudes[which]
            )
            cost += side_cost
            by_trunks += along_trunks
            by_amplitudes.append(along_amplitudes)
        smooth = worse - math.log(total) / self.sharpness
        return smooth - cost, by_trunks, (by_amplitudes[0], by_amplitudes[1]), worse - cost

    def _swing(self, which: int, trunks: FloatArray, amplitudes: FloatArray) -> _Bent | None:
        outline, scale = self.sides[which].scaled_outline(amplitudes)
        if not scale > 0.0:
            return None
        # Arcs run along their outline: Q's trunk is read backwards.
        order = slice(None, None, 1 if which == 0 else -1)
        source, target = trunks[which, order].copy(), trunks[1 - which, order].copy()
        arcs = swing_arcs(outline, self.windows[which], source, target)
        iou, pull, _ = iou_gradient(*areas_of(arcs, self.lines), 1.0)
        return _Bent(outline, scale, source, target, arcs, iou, pull)

    def _gradient(
        self, which: int, bent: _Bent, part: float, amplitudes: FloatArray
    ) -> tuple[float, FloatArray, FloatArray]:
        """The cost of one side, and the gradient by trunks and amplitudes of its share of the softmin less the cost."""
        side, arcs = self.sides[which], bent.arcs
        energy, by_amplitudes, by_scale = side.energy(amplitudes, bent.scale)
        off = bent.source - arcs.feet
        cost = self.weight * energy + self.attach * float((off * off).sum())
        pull = part * bent.pull
        if self.contact > 0.0:
            lost, by_points, _ = contact_cost(arcs.points, arcs.offsets, SPARE_CONTACT * self.allowed, self.contact)
            cost += lost
            pull = pull - by_points
        by_outline, by_source, by_target = swung_back(arcs, pull, bent.outline, bent.source, bent.target)
        by_source -= 2.0 * self.attach * off
        _pull_feet(arcs, 2.0 * self.attach * off, bent.outline, by_outline)
        by_trunks = np.stack([by_source, by_target]) if which == 0 else np.stack([by_target[::-1], by_source[::-1]])
        along = side.by_amplitudes(bent.outline, bent.scale, by_outline, -self.weight * by_scale)
        return cost, by_trunks, along - self.weight * by_amplitudes


@dataclass(frozen=True, eq=False)
class _Bent:
    """A side as it is bent: outline, its scale, trunk and conjugate, arcs, IoU and its gradient by the arcs' points."""

    outline: FloatArray
    scale: float
    source: FloatArray
    target: FloatArray
    arcs: SwungArcs
    iou: float
    pull: FloatArray


def _flatness(trunks: FloatArray) -> tuple[float, FloatArray]:
    """The cost of corners of conjugate ``trunks`` (2, n, 2) that are almost flat, and its gradient.

    At a corner that turns no more the maximisation would stand before a wall.
    """
    before = trunks - _rolled(trunks, -1)
    after = _rolled(before, 1)
    lengths = np.sqrt((before * before).sum(axis=2))
    product = lengths * _rolled(lengths, 1)
    sense = np.array([[1.0], [-1.0]])  # T is counter-clockwise, its conjugate clockwise
    turn = sense * (before[..., 0] * after[..., 1] - before[..., 1] * after[..., 0]) / product
    short = np.maximum(1.0 - turn / FLAT_TURN, 0.0)
    pull = (-2.0 * FLAT_WEIGHT / FLAT_TURN * short)[..., None]
    square = (before * before).sum(axis=2)[..., None]
    next_square = _rolled(square, 1)
    signed, turns = (sense / product)[..., None], turn[..., None]
    by_before = pull * (signed * np.stack([after[..., 1], -after[..., 0]], axis=2) - turns * before / square)
    by_after = pull * (signed * np.stack([-before[..., 1], before[..., 0]], axis=2) - turns * after / next_square)
    by_edge = by_before + _rolled(by_after, -1)
    return FLAT_WEIGHT * float((short * short).sum()), by_edge - _rolled(by_edge, 1)


def _rolled(values: FloatArray, by: int) -> FloatArray:
    """Values of corners, (2, n, …), from corner ``by`` on: `numpy.roll` the other way, quicker."""
    return np.concatenate([values[:, by:], values[:, :by]], axis=1)


def _pull_feet(arcs: SwungArcs, pull: FloatArray, outline: FloatArray, by_outline: FloatArray) -> None:
    """Add what draws feet towards their corners to the gradient by the outline.

    The feet are the nearest points, so that it does not matter that they slide.
    """
    following = (arcs.edges + 1) % len(outline)
    edge = outline[following] - outline[arcs.edges]
    square = (edge * edge).sum(axis=1)
    share = ((arcs.feet - outline[arcs.edges]) * edge).sum(axis=1) / np.where(square > 0.0, square, 1.0)
    np.add.at(by_outline, arcs.edges, (1.0 - share)[:, None] * pull)
    np.add.at(by_outline, following, share[:, None] * pull)
