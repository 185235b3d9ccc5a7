"""Measure how much of an outline's detail a construction keeps: corners, straight lines, small features. Ours.

IoU and distances hardly see detail: a corner rounded off or a straight line made wavy costs next to no area. Two
measures do, one number a shape each:

* `bending_ratio`: bending energy ∫κ² ds of the assembled outline over the input's, both smoothed along the boundary by
  a Gaussian of `riot.transform.tuning.SMOOTHING_SCALE`. Rounding off takes energy away (below 1), waves and kinks add
  some (above 1); so a blunted and wavy outline can be near 1, and the ratio alone does not judge.
* `direction_error`: mean angle between the directions of the assembled outline and of the input's at points that
  correspond, in radians, at the same scale. The correspondence is the best monotone one within
  `riot.transform.tuning.DISPLACEMENT_WINDOW` along the outline: every lost corner and every added wave counts, none
  against another. Detail that is only displaced, a line parallel to itself or a corner along a line, counts as kept.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import cKDTree

from riot.geometry.polyline import arc_length, at_length
from riot.kernels.fidelity import warped_difference
from riot.transform.tuning import (
    DISPLACEMENT_WINDOW,
    LEAST_SMOOTHED_SAMPLES,
    LONE_STEP_COST,
    SAMPLES_PER_SCALE,
    SMOOTHING_SCALE,
)
from riot.types import FloatArray


def bending_energy(outline: FloatArray) -> float:
    """∫κ² ds, 1 / length, of a closed polygon (m, 2) smoothed along its boundary by `SMOOTHING_SCALE`.

    The smoothing makes it finite: a corner of angle φ has about φ² / (2 √π `SMOOTHING_SCALE`).

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> bending_energy(2.0 * square) < 1.01 * bending_energy(square)  # the same four corners
    True
    """
    points, step = _smoothed(outline)
    before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
    turn = np.arctan2(
        before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], before[:, 0] * after[:, 0] + before[:, 1] * after[:, 1]
    )
    return float((turn**2).sum() / step)


def bending_ratio(outline: FloatArray, reference: FloatArray) -> float:
    """Bending energy of an outline (m, 2) over that of the reference (k, 2): 1 if it bends as much.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> corner_cut = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.8], [0.8, 1.0], [0.0, 1.0]])
    >>> bending_ratio(corner_cut, square) < 1.0
    True
    """
    return bending_energy(outline) / bending_energy(reference)


def direction_error(outline: FloatArray, reference: FloatArray) -> float:
    """Mean angle, radians, between two closed polygons of the same orientation along their best correspondence.

    It starts where the two are nearest to each other.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> direction_error(square + 0.001, square) < 1e-9
    True
    """
    (a, _), (b, _) = _smoothed(outline), _smoothed(reference)
    far, near = (np.asarray(values) for values in cKDTree(b).query(a))
    start = int(np.argmin(far))
    along_a, along_b = np.roll(_directions(a), -start), np.roll(_directions(b), -int(near[start]))
    window = math.ceil(SAMPLES_PER_SCALE * DISPLACEMENT_WINDOW / SMOOTHING_SCALE)
    return warped_difference(along_a, along_b, window, LONE_STEP_COST)


def _smoothed(outline: FloatArray) -> tuple[FloatArray, float]:
    """Even samples of a closed polygon, smoothed along it, and their distance along it."""
    length = float(arc_length(outline)[-1])
    count = max(LEAST_SMOOTHED_SAMPLES, math.ceil(SAMPLES_PER_SCALE * length / SMOOTHING_SCALE))
    step = length / count
    samples = at_length(outline, np.arange(count, dtype=np.float64) * step)
    smooth: FloatArray = gaussian_filter1d(samples, SMOOTHING_SCALE / step, axis=0, mode="wrap")
    return smooth, step


def _directions(points: FloatArray) -> FloatArray:
    ahead = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    return np.asarray(np.arctan2(ahead[:, 1], ahead[:, 0]))
