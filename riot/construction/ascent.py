"""The maximisation that refining and bending share: quasi-Newton steps, put back on a surface (theory §7; ours)."""

from __future__ import annotations

import math
from typing import Protocol, TypeVar

import numpy as np

from riot.construction.tuning import (
    ARMIJO_SHARE,
    BACKTRACK_FACTOR,
    FIRST_MOVE,
    LEAST_CURVATURE,
    LONGEST_MOVE,
    MOST_BACKTRACKS,
    MOVE_HISTORY,
    SETTLED_GAIN,
)
from riot.kernels.conjugate import quasi_newton
from riot.types import FloatArray

Point = TypeVar("Point")


class Surface(Protocol[Point]):
    """Where a maximisation goes: points of N unknowns, such as conjugate trunks."""

    def rate(self, point: Point) -> tuple[float, FloatArray, float]:
        """The objective at a point, its gradient (N,) along the surface, and what a point is chosen by in the end."""

    def put_back(self, point: Point, step: FloatArray) -> Point | None:
        """The point of the surface near where a step (N,) leads; None if there is none that is allowed."""

    def step(self, point: Point, after: Point) -> FloatArray:
        """The step (N,) from one point to another."""


def ascend(surface: Surface[Point], start: Point, steps: int) -> tuple[Point, float]:
    """The best point on the way of so many steps at most, and what it is chosen by.

    It is chosen by what the objective stands in for, which is not smooth.

    >>> class Hill:
    ...     def rate(self, point):
    ...         return -float(point @ point), -2.0 * point, -float(point @ point)
    ...     def put_back(self, point, step):
    ...         return point + step
    ...     def step(self, point, after):
    ...         return after - point
    >>> top, height = ascend(Hill(), np.array([0.1, -0.2]), 20)
    >>> bool(np.abs(top).max() < 1e-3)
    True
    """
    point = start
    value, gradient, worth = surface.rate(point)
    best, best_worth = point, worth
    moves, changes, count = np.empty((MOVE_HISTORY, len(gradient))), np.empty((MOVE_HISTORY, len(gradient))), 0
    for _ in range(steps):
        direction = quasi_newton(moves, changes, count, gradient)
        slope, length = _dot(direction, gradient), math.sqrt(_dot(direction, direction))
        if length == 0.0 or not slope > 0.0:
            break
        share = min(1.0, (LONGEST_MOVE if count else FIRST_MOVE) / length)
        for _ in range(MOST_BACKTRACKS):
            moved = surface.put_back(point, share * direction)
            if moved is not None:
                there, onward, worth = surface.rate(moved)
                if there >= value + ARMIJO_SHARE * share * slope:
                    break
            share *= BACKTRACK_FACTOR
        else:
            if count == 0:
                break
            count = 0  # the curvature that was learnt does not hold here: begin again with the gradient
            continue
        assert moved is not None
        move, change = surface.step(point, moved), onward - gradient
        if _dot(move, change) < -LEAST_CURVATURE:
            moves[count % MOVE_HISTORY], changes[count % MOVE_HISTORY] = move, change
            count += 1
        gain = there - value
        point, value, gradient = moved, there, onward
        if worth > best_worth:
            best, best_worth = point, worth
        if gain < SETTLED_GAIN:
            break
    return best, best_worth


def _dot(a: FloatArray, b: FloatArray) -> float:
    """The scalar product; not by BLAS, whose sums depend on the machine."""
    return float((a * b).sum())
