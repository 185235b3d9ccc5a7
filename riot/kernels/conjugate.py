"""Making two trunks conjugate: edge differences, projection and direction of ascent (theory §7; ours)."""

from __future__ import annotations

import math

import numpy as np

from riot.kernels.options import inner, kernel
from riot.types import FloatArray

_LEAST_PIVOT = 1e-30
"""A smaller pivot of Cholesky's factors makes a matrix singular. Ours: edges are of order 1, and their squares are far
above this unless an edge has no length."""


@kernel
def edge_differences(trunks: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(n,) |e_j| − |e'_j| of two corresponding n-gons, (2, n, 2), and its (n, 4n) Jacobian."""
    n = trunks.shape[1]
    differences, jacobian = np.zeros(n), np.zeros((n, 4 * n))
    for side in range(2):
        sign = 1.0 - 2.0 * side
        for j in range(n):
            after = (j + 1) % n
            x, y = trunks[side, after, 0] - trunks[side, j, 0], trunks[side, after, 1] - trunks[side, j, 1]
            length = math.hypot(x, y)
            differences[j] += sign * length
            row, here, there = jacobian[j], 2 * (side * n + j), 2 * (side * n + after)
            row[there], row[there + 1] = sign * (x / length), sign * (y / length)
            row[here], row[here + 1] = -row[there], -row[there + 1]
    return differences, jacobian


@kernel
def conjugated(trunks: FloatArray, tolerance: float, steps: int) -> tuple[FloatArray, float]:
    """The nearest pair of n-gons (2, n, 2) to ``trunks`` with equal corresponding edges, and the greatest difference
    of edges that remains.

    Gauss–Newton: every step goes to the point nearest to the start on the linearised constraints.
    """
    n = trunks.shape[1]
    start = trunks.copy().reshape(4 * n)
    current = start.copy()
    worst = np.inf
    for _ in range(steps):
        residual, jacobian = edge_differences(current.reshape(2, n, 2))
        worst = 0.0
        for i in range(n):
            worst = max(worst, abs(residual[i]))
        if not worst >= tolerance:
            break
        normal, wanted = np.zeros((n, n)), np.zeros(n)
        for i in range(n):
            wanted[i] = -residual[i]
            for k in range(4 * n):
                if jacobian[i, k] == 0.0:
                    continue
                wanted[i] += jacobian[i, k] * (current[k] - start[k])
                for j in range(n):
                    normal[i, j] += jacobian[i, k] * jacobian[j, k]
        if not _solve(normal, wanted):
            return current.reshape(2, n, 2), np.inf
        for k in range(4 * n):
            step = 0.0
            for i in range(n):
                step += jacobian[i, k] * wanted[i]
            current[k] = start[k] + step
    return current.reshape(2, n, 2), worst


@kernel
def tangential(trunks: FloatArray, gradient: FloatArray) -> FloatArray:
    """The part of a gradient (2, n, 2) along which corresponding edges of conjugate ``trunks`` stay equal."""
    n = trunks.shape[1]
    _, jacobian = edge_differences(trunks)
    along = gradient.copy().reshape(4 * n)
    normal, wanted = np.zeros((n, n)), np.zeros(n)
    for i in range(n):
        for k in range(4 * n):
            if jacobian[i, k] == 0.0:
                continue
            wanted[i] += jacobian[i, k] * along[k]
            for j in range(n):
                normal[i, j] += jacobian[i, k] * jacobian[j, k]
    if _solve(normal, wanted):
        for i in range(n):
            for k in range(4 * n):
                along[k] -= jacobian[i, k] * wanted[i]
    return along.reshape(2, n, 2)


@kernel
def quasi_newton(moves: FloatArray, changes: FloatArray, count: int, gradient: FloatArray) -> FloatArray:
    """The direction of ascent by the last ``count`` moves (h, N) and the changes (h, N) of the gradient in these moves.

    Two-loop recursion of limited-memory BFGS (Nocedal 1980); the rows are filled in turn, the newest is row
    (count − 1) mod h. Every stored pair has move · change < 0, as near a maximum.
    """
    held, size = min(count, len(moves)), len(gradient)
    direction, weights = gradient.copy(), np.empty(max(held, 1))
    for age in range(held):
        row = (count - 1 - age) % len(moves)
        inner, along = 0.0, 0.0
        for k in range(size):
            inner -= moves[row, k] * changes[row, k]
            along += moves[row, k] * direction[k]
        weights[age] = along / inner
        for k in range(size):
            direction[k] += weights[age] * changes[row, k]
    if held > 0:
        row = (count - 1) % len(moves)
        inner, square = 0.0, 0.0
        for k in range(size):
            inner -= moves[row, k] * changes[row, k]
            square += changes[row, k] * changes[row, k]
        for k in range(size):
            direction[k] *= inner / square
    for age in range(held - 1, -1, -1):
        row = (count - 1 - age) % len(moves)
        inner, along = 0.0, 0.0
        for k in range(size):
            inner -= moves[row, k] * changes[row, k]
            along -= changes[row, k] * direction[k]
        for k in range(size):
            direction[k] += (weights[age] - along / inner) * moves[row, k]
    return direction


@inner
def _solve(matrix: FloatArray, right: FloatArray) -> bool:
    """Solve a positive definite system, (n, n), by Cholesky's factors; the solution replaces ``right``, (n,). False if
    the matrix is singular."""
    n = len(right)
    for i in range(n):
        for j in range(i + 1):
            left = matrix[i, j]
            for k in range(j):
                left -= matrix[i, k] * matrix[j, k]
            if i == j:
                if not left > _LEAST_PIVOT:
                    return False
                matrix[i, i] = math.sqrt(left)
            else:
                matrix[i, j] = left / matrix[j, j]
    for i in range(n):
        for k in range(i):
            right[i] -= matrix[i, k] * right[k]
        right[i] /= matrix[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            right[i] -= matrix[k, i] * right[k]
        right[i] /= matrix[i, i]
    return True


@kernel
def turns(polygon: FloatArray) -> tuple[float, float]:
    """(least cross product of consecutive edges, sum of the turns between them in radians) of a polygon (n, 2)."""
    n = len(polygon)
    least, total = np.inf, 0.0
    for j in range(n):
        before, after = (j - 1) % n, (j + 1) % n
        ux, uy = polygon[j, 0] - polygon[before, 0], polygon[j, 1] - polygon[before, 1]
        vx, vy = polygon[after, 0] - polygon[j, 0], polygon[after, 1] - polygon[j, 1]
        cross = ux * vy - uy * vx
        least = min(least, cross)
        total += math.atan2(cross, vx * ux + vy * uy)
    return least, total


def warm() -> None:
    """Compile on a triangle."""
    triangle = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    pair = np.stack((triangle, triangle[::-1]))
    conjugated(pair, 1e-14, 8)
    tangential(pair, pair)
    quasi_newton(np.ones((1, 12)), -np.ones((1, 12)), 1, np.ones(12))
    turns(triangle)
