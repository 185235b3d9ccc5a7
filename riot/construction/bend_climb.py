"""The maximisation of trunks and bends together (theory §12; ours).

Quasi-Newton steps on the surface of conjugate trunks, as in `riot.construction.refine`, with the amplitudes of both
shapes' modes as more unknowns. The corners are carried along by the modes, so that a step of an amplitude bends shape
and trunk alike, and amplitudes are in units of energy or of distance, whichever is the smaller step: both make steps of
all unknowns comparable.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from riot.construction.ascent import ascend
from riot.construction.bend_objective import BendObjective
from riot.construction.bent_side import BentSide
from riot.construction.conjugate import is_convex
from riot.construction.plan import ConstructionPlan, feet_of
from riot.construction.tuning import (
    ACCEPTED_EDGE_DIFFERENCE,
    CONJUGATE_STEPS,
    EDGE_TOLERANCE,
    FULLEST_STRAIN,
    STRAIN_TRIALS,
)
from riot.kernels.conjugate import conjugated
from riot.parameters import BendParameters
from riot.types import FloatArray
from riot.units import D_C


@dataclass(frozen=True, eq=False)
class BendState:
    """Where a maximisation is.

    Parameters
    ----------
    sides : two BentSide
        P and Q, as they were when their modes were computed.
    trunks : (2, n, 2) float64
        Conjugate, on the bent shapes as they are scaled to unit area.
    amplitudes : two (K,) float64 arrays
        By how much the sides are bent since.
    """

    sides: tuple[BentSide, BentSide]
    trunks: FloatArray
    amplitudes: tuple[FloatArray, FloatArray]


_Point = tuple[FloatArray, FloatArray]
"""Trunks (2, n, 2), and amplitudes (2, K)."""


class BendClimb:
    """One maximisation from a state on, with one objective."""

    def __init__(
        self,
        plan: ConstructionPlan,
        state: BendState,
        objective: BendObjective,
        parameters: BendParameters,
        slide: float,
    ) -> None:
        self.objective, self.parameters, self.slide = objective, parameters, slide * D_C
        self.sides, self.start = state.sides, state.trunks
        self.count = len(state.amplitudes[0])
        self.carry = _carry(plan, state)

    def run(self, state: BendState, steps: int) -> tuple[BendState, float]:
        """The best state on the way of so many steps at most, and its objective with the worse bound in place of the
        softmin."""
        (trunks, amplitudes), worth = ascend(self, (state.trunks, np.stack(state.amplitudes)), steps)
        return replace(state, trunks=trunks, amplitudes=(amplitudes[0], amplitudes[1])), worth

    def step(self, point: _Point, after: _Point) -> FloatArray:
        """The step between two points in the unknowns: corners as if they were not carried, and amplitudes."""
        change = after[1] - point[1]
        return np.concatenate([(after[0] - point[0] - self.carried(change)).ravel(), change.ravel()])

    def carried(self, change: FloatArray) -> FloatArray:
        """How the corners (2, n, 2) go along with a change of the amplitudes (2, K)."""
        return np.asarray(np.einsum("sk,sknx->snx", change, self.carry))

    def put_back(self, point: _Point, step: FloatArray) -> _Point | None:
        """Conjugate trunks and amplitudes within the limits of strain after a step.

        None if the trunks are too far from the start or not convex.
        """
        trunks, amplitudes = point
        corners = trunks.size
        target = amplitudes + step[corners:].reshape(amplitudes.shape)
        for side in range(2):
            for _ in range(STRAIN_TRIALS):
                fullness = self.fullness(side, target[side])
                if not fullness > 1.0:
                    break
                # Strain is nearly in proportion to the amplitudes.
                target[side] *= FULLEST_STRAIN / fullness
            if not fullness <= 1.0:
                return None
        moved = trunks + step[:corners].reshape(trunks.shape) + self.carried(target - amplitudes)
        conjugate, worst = conjugated(moved, EDGE_TOLERANCE, CONJUGATE_STEPS)
        if not worst <= ACCEPTED_EDGE_DIFFERENCE or np.abs(conjugate - self.start).max() > self.slide:
            return None
        convex = is_convex(conjugate[0]) and is_convex(conjugate[1, ::-1])
        return (conjugate, target) if convex else None

    def fullness(self, side: int, amplitudes: FloatArray) -> float:
        """The strain of a side as a share of what is allowed."""
        rms, greatest = self.sides[side].strains(amplitudes)
        return max(rms / self.parameters.rms_strain, greatest / self.parameters.max_strain)

    def rate(self, point: _Point) -> tuple[float, FloatArray, float]:
        """The objective, its gradient by the unknowns along the surface of conjugate trunks, and the objective with the
        worse bound in place of the softmin."""
        trunks, amplitudes = point
        value, by_trunks, by_amplitudes, worse = self.objective.rate(trunks, list(amplitudes))
        carried = np.einsum("snx,sknx->sk", by_trunks, self.carry)
        gradient = np.concatenate([by_trunks.ravel(), (np.stack(by_amplitudes) + carried).ravel()])
        constraints = self.constraints(trunks)
        normal = np.linalg.solve(constraints @ constraints.T, constraints @ gradient)
        return value, gradient - normal @ constraints, worse

    def constraints(self, trunks: FloatArray) -> FloatArray:
        """(n, N) derivatives of the differences of corresponding edges by the unknowns."""
        n = trunks.shape[1]
        j, after = np.arange(n), (np.arange(n) + 1) % n
        edges = trunks[:, after] - trunks
        along = np.array([[[1.0]], [[-1.0]]]) * edges / np.hypot(edges[..., 0], edges[..., 1])[..., None]
        jacobian = np.zeros((n, 2, n, 2))
        jacobian[j, :, after] = along.swapaxes(0, 1)
        jacobian[j, :, j] -= along.swapaxes(0, 1)
        by_carry = np.einsum("jsnx,sknx->jsk", jacobian, self.carry)
        return np.concatenate([jacobian.reshape(n, -1), by_carry.reshape(n, -1)], axis=1)


def _carry(plan: ConstructionPlan, state: BendState) -> FloatArray:
    """(2, K, n, 2) how each amplitude moves the outline, scaled to unit area, where the corners are."""
    _, windows_p, _, windows_q = plan.pair.windowed_outlines
    outlines = [side.scaled_outline(change)[0] for side, change in zip(state.sides, state.amplitudes, strict=True)]
    feet = feet_of((outlines[0], windows_p, outlines[1], windows_q), state.trunks)
    carry = []
    for side, outline, on in zip(state.sides, outlines, feet, strict=True):
        nearest = ((on[:, None] - outline) ** 2).sum(axis=2).argmin(axis=1)
        across = np.roll(outline, -1, axis=0) - np.roll(outline, 1, axis=0)
        growth = 0.5 * (side.moves[:, :, 0] @ across[:, 1] - side.moves[:, :, 1] @ across[:, 0])
        carry.append(side.moves[:, nearest] - 0.5 * growth[:, None, None] * on)
    return np.stack(carry)
