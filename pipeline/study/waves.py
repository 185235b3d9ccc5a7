"""Deform shapes slightly, as if they were drawn a second time. Ours."""

from __future__ import annotations

import numpy as np

from riot.types import FloatArray

WAVES = 3
"""Number of plane waves in a deformation (ours)."""

LONGEST, SHORTEST = 3.0, 1.2
"""Wave lengths, in units of √area."""


def deformed(points: FloatArray, amplitude: float, rng: np.random.Generator) -> FloatArray:
    """Points (m, 2) of a unit-area shape moved by a sum of plane waves, long and low.

    The displacement's greatest slope is at most 2π · amplitude / `SHORTEST` < 1, so that no two points change sides.
    """
    moved = points.copy()
    for _ in range(WAVES):
        angle, phase, way = rng.uniform(0.0, 2.0 * np.pi, 3)
        length = rng.uniform(SHORTEST, LONGEST)
        along = points @ np.array([np.cos(angle), np.sin(angle)])
        wave = amplitude / WAVES * np.sin(2.0 * np.pi / length * along + phase)
        moved += wave[:, None] * np.array([np.cos(way), np.sin(way)])
    return moved
