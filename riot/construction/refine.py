"""Refine a plan: move its trunks, conjugate all the while, to where an exact construction changes both shapes least.

After CRS the trunk vertices lie on sparse boundary points, and made conjugate they are off the boundary. The bound of
the IoU (theory §8) is a function of the two trunks alone, with a gradient. Refinement maximises a smooth stand-in for
the worse shape's bound by quasi-Newton steps on the surface of conjugate trunks (theory §7; ours): each step is taken
along the surface and then put back on it.
"""

from __future__ import annotations

import math

import numpy as np

from riot.construction.conjugate import is_convex
from riot.construction.plan import ConstructionPlan, feet_of, plan_on
from riot.construction.tuning import (
    ACCEPTED_EDGE_DIFFERENCE,
    ARMIJO_SHARE,
    BACKTRACK_FACTOR,
    CONJUGATE_STEPS,
    EDGE_TOLERANCE,
    FIRST_MOVE,
    LEAST_CURVATURE,
    LONGEST_MOVE,
    MOST_BACKTRACKS,
    MOVE_HISTORY,
    SETTLED_GAIN,
    SHARPNESS,
    WORTHWHILE_GAIN,
)
from riot.kernels.change import least_changes
from riot.kernels.conjugate import conjugated, quasi_newton, tangential
from riot.parameters import RefineParameters
from riot.types import FloatArray
from riot.units import D_C


def refine(plan: ConstructionPlan, steps: int, parameters: RefineParameters) -> ConstructionPlan:
    """Move the trunks of a plan in at most so many steps; returns the plan itself if that hardly raises its bound.

    No corner moves farther than ``parameters.slide`` along either axis. Ours (theory §7).

    >>> from riot import Shape
    >>> house = Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)])
    >>> kite = Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)])
    >>> from riot.construction import alternatives
    >>> plan = alternatives(house, kite)[0]
    >>> refine(plan, 8, RefineParameters()).bound >= plan.bound
    True
    """
    best = plan.trunks
    for sharpness in SHARPNESS:
        best = _Climb(plan, parameters, sharpness).run(best, steps // len(SHARPNESS))
    refined = plan_on(plan.pair, best, parameters.bound_lines)
    return refined if refined.bound > plan.bound + WORTHWHILE_GAIN else plan


class _Climb:
    """One maximisation with one sharpness."""

    def __init__(self, plan: ConstructionPlan, parameters: RefineParameters, sharpness: float) -> None:
        self.outlines, self.lines, self.sharpness = plan.pair.windowed_outlines, parameters.lines, sharpness
        self.start, self.slide, self.attach = plan.trunks, parameters.slide * D_C, parameters.attach

    def run(self, trunks: FloatArray, steps: int) -> FloatArray:
        value, gradient, worse = self.rate(trunks)
        best, best_worse = trunks, worse
        moves, changes, count = np.empty((MOVE_HISTORY, trunks.size)), np.empty((MOVE_HISTORY, trunks.size)), 0
        for _ in range(steps):
            direction = quasi_newton(moves, changes, count, gradient.ravel()).reshape(trunks.shape)
            slope, length = float((direction * gradient).sum()), math.sqrt(float((direction * direction).sum()))
            if length == 0.0 or not slope > 0.0:
                break
            share = min(1.0, (LONGEST_MOVE if count else FIRST_MOVE) / length)
            for _ in range(MOST_BACKTRACKS):
                moved = self.put_back(trunks + share * direction)
                if moved is not None:
                    there, onward, worse = self.rate(moved)
                    if there >= value + ARMIJO_SHARE * share * slope:
                        break
                share *= BACKTRACK_FACTOR
            else:
                if count == 0:
                    break
                count = 0  # the curvature that was learnt does not hold here: begin again with the gradient
                continue
            move, change = (moved - trunks).ravel(), (onward - gradient).ravel()
            if float((move * change).sum()) < -LEAST_CURVATURE:
                moves[count % MOVE_HISTORY], changes[count % MOVE_HISTORY] = move, change
                count += 1
            gain = there - value
            trunks, value, gradient = moved, there, onward
            if worse > best_worse:
                best, best_worse = trunks, worse
            if gain < SETTLED_GAIN:
                break
        return best

    def put_back(self, trunks: FloatArray) -> FloatArray | None:
        """The nearest conjugate trunks; None if they are too far from the start or not convex."""
        conjugate, worst = conjugated(trunks, EDGE_TOLERANCE, CONJUGATE_STEPS)
        if not worst <= ACCEPTED_EDGE_DIFFERENCE or np.abs(conjugate - self.start).max() > self.slide:
            return None
        return conjugate if is_convex(conjugate[0]) and is_convex(conjugate[1, ::-1]) else None

    def rate(self, trunks: FloatArray) -> tuple[float, FloatArray, float]:
        """The stand-in, its gradient (2, n, 2) along the surface, and the worse bound; of both the attachment is taken.

        A corner off the boundary costs area only to second order, but makes a notch or a spike as deep as it is far.
        """
        bounds, gradients = least_changes(*self.outlines, trunks, self.lines)
        worse = float(bounds.min())
        shares = np.exp(-self.sharpness * (bounds - worse))
        total = float(shares.sum())
        gradient = (shares[0] * gradients[0] + shares[1] * gradients[1]) / total
        off = trunks - feet_of(self.outlines, trunks)
        cost = self.attach * float((off * off).sum())
        along = tangential(trunks, gradient - 2.0 * self.attach * off)
        return worse - math.log(total) / self.sharpness - cost, along, worse - cost
