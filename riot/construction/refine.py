"""Refine a plan: move its trunks, conjugate all the while, to where an exact construction changes both shapes least.

After CRS the trunk vertices lie on sparse boundary points, and made conjugate they are off the boundary. The bound of
the IoU (theory §8) is a function of the two trunks alone, with a gradient. Refinement maximises a smooth stand-in for
the worse shape's bound by quasi-Newton steps on the surface of conjugate trunks (theory §7; ours): each step is taken
along the surface and then put back on it.
"""

from __future__ import annotations

import math

import numpy as np

from riot.construction.ascent import ascend
from riot.construction.conjugate import is_convex
from riot.construction.plan import ConstructionPlan, feet_of, plan_on
from riot.construction.tuning import (
    ACCEPTED_EDGE_DIFFERENCE,
    CONJUGATE_STEPS,
    EDGE_TOLERANCE,
    SHARPNESS,
    WORTHWHILE_GAIN,
)
from riot.kernels.change import least_changes
from riot.kernels.conjugate import conjugated, tangential
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
        best, _ = ascend(_Conjugate(plan, parameters, sharpness), best, steps // len(SHARPNESS))
    refined = plan_on(plan.pair, best, parameters.bound_lines)
    return refined if refined.bound > plan.bound + WORTHWHILE_GAIN else plan


class _Conjugate:
    """The surface of conjugate trunks near those of a plan, with the stand-in of one sharpness."""

    def __init__(self, plan: ConstructionPlan, parameters: RefineParameters, sharpness: float) -> None:
        self.outlines, self.lines, self.sharpness = plan.pair.windowed_outlines, parameters.lines, sharpness
        self.start, self.slide, self.attach = plan.trunks, parameters.slide * D_C, parameters.attach

    def put_back(self, trunks: FloatArray, step: FloatArray) -> FloatArray | None:
        """The conjugate trunks near where a step leads; None if they are too far from the start or not convex."""
        conjugate, worst = conjugated(trunks + step.reshape(trunks.shape), EDGE_TOLERANCE, CONJUGATE_STEPS)
        if not worst <= ACCEPTED_EDGE_DIFFERENCE or np.abs(conjugate - self.start).max() > self.slide:
            return None
        return conjugate if is_convex(conjugate[0]) and is_convex(conjugate[1, ::-1]) else None

    def step(self, trunks: FloatArray, after: FloatArray) -> FloatArray:
        """The moves of all corners, one after the other."""
        return (after - trunks).ravel()

    def rate(self, trunks: FloatArray) -> tuple[float, FloatArray, float]:
        """The stand-in, its gradient (4n,) along the surface, and the worse bound; of both the attachment is taken.

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
        return worse - math.log(total) / self.sharpness - cost, along.ravel(), worse - cost
