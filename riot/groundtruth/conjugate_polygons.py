"""Random pairs of conjugate convex polygons: equal edge lengths in opposite order (theory §7; ours)."""

from __future__ import annotations

import math

import numpy as np

from riot.geometry.polyline import signed_area
from riot.groundtruth.limits import PairLimits
from riot.types import FloatArray

# All constants are ours: they only decide which polygons are drawn, and how often.

_LEAST_EDGE, _EDGE_RANGE = 0.55, 0.9
"""Edge lengths are drawn evenly from the least one to that plus the range, before the area becomes 1."""

_LONGEST_EDGE = 0.95
"""Twice the longest edge is at most this share of the perimeter, so that the polygon has some width."""

_TURN_RANGE = 1.2
"""Turns are drawn evenly from 1 ± half of this, before they are scaled to 2π."""

_CLOSING_STEPS = 50
"""Newton steps in which a polygon must close."""

_CLOSED, _CLOSED_ENOUGH = 1e-15, 1e-12
"""Gap of a closed polygon: the steps end below the first times the number of edges; the second is the limit."""

_LEAST_DETERMINANT = 1e-6
"""With a smaller determinant the headings are nearly parallel, and the polygon cannot be closed by turning edges."""


def conjugate_polygons(rng: np.random.Generator, n: int, limits: PairLimits) -> tuple[FloatArray, FloatArray] | None:
    """Draw two convex n-gons, (n, 2) each, of total area 1 and equal edge lengths; None if the draw fails.

    The first is listed counter-clockwise, the second clockwise.

    >>> v, w = conjugate_polygons(np.random.default_rng(0), 4, PairLimits())
    >>> bool(np.allclose(np.hypot(*np.diff(v, axis=0).T), np.hypot(*np.diff(w, axis=0).T)))
    True
    """
    lengths = _LEAST_EDGE + _EDGE_RANGE * rng.random(n)
    if 2.0 * lengths.max() > _LONGEST_EDGE * lengths.sum():
        return None
    first, second = _convex_polygon(rng, lengths, limits), _convex_polygon(rng, lengths, limits)
    if first is None or second is None:
        return None
    second = second * [1.0, -1.0]
    scale = 1.0 / math.sqrt(signed_area(first) - signed_area(second))
    return first * scale, second * scale


def _convex_polygon(rng: np.random.Generator, lengths: FloatArray, limits: PairLimits) -> FloatArray | None:
    """A counter-clockwise convex polygon with these edge lengths and headings near random ones."""
    n = len(lengths)
    turns = 1.0 + _TURN_RANGE * (rng.random(n) - 0.5)
    headings = 2.0 * math.pi * np.cumsum(turns) / turns.sum()
    for _ in range(_CLOSING_STEPS):
        edges = lengths[:, None] * np.stack([np.cos(headings), np.sin(headings)], axis=1)
        gap = edges.sum(axis=0)
        if np.abs(gap).max() < _CLOSED * n:
            break
        # Minimum-norm step: d(edge)/d(heading) is the edge turned by a quarter.
        jacobian = np.stack([-edges[:, 1], edges[:, 0]])
        gram = jacobian @ jacobian.T
        if np.linalg.det(gram) < _LEAST_DETERMINANT:
            return None
        headings = headings - jacobian.T @ np.linalg.solve(gram, gap)
    polygon = np.concatenate([np.zeros((1, 2)), np.cumsum(edges, axis=0)[:-1]])
    angles = math.pi - np.diff(headings, append=headings[0] + 2.0 * math.pi)
    if np.abs(gap).max() > _CLOSED_ENOUGH:
        return None
    if angles.min() < limits.least_trunk_angle or angles.max() > limits.greatest_trunk_angle:
        return None
    return polygon
