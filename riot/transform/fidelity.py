"""How much of an outline's detail a construction keeps: corners, straight lines, small features. Ours.

IoU and distances hardly see detail: a corner rounded off or a straight line made wavy costs next to no area. Two
measures do, one number a shape each:

* `bending_ratio`: bending energy ∫κ² ds of the assembled outline over the input's, both smoothed along the boundary by
  a Gaussian of `SCALE`. Rounding off takes energy away (below 1), waves and kinks add some (above 1); so a blunted and
  wavy outline can be near 1, and the ratio alone does not judge.
* `direction_error`: mean angle between the directions of the assembled outline and of the input's at points that
  correspond, in radians, at the same scale. The correspondence is monotone and the best there is, within `WINDOW`
  along the outline: every lost corner and every added wave counts, none against another, but detail that stays and is
  only displaced, a line parallel to itself or a corner along a line, is kept detail and counts next to nothing.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import cKDTree

from riot.geometry.polyline import arc_length, at_length
from riot.kernels.fidelity import warped_difference
from riot.types import FloatArray
from riot.units import L_C

SCALE = L_C / 150
"""Standard deviation of the smoothing along the boundary: less than the spacing of an input's points (`L_c / 100`)."""

SAMPLES = 3
"""Samples per `SCALE`."""

WINDOW = L_C / 15
"""Detail may be displaced this far along the outline."""

SKEW = 0.1
"""What a step on one outline only costs, as an angle."""


def bending_energy(outline: FloatArray) -> float:
    """∫κ² ds, 1 / length, of a closed polygon (m, 2) smoothed along its boundary by `SCALE`.

    The smoothing makes it finite: a corner of angle φ has about φ² / (2 √π `SCALE`).
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
    window = math.ceil(SAMPLES * WINDOW / SCALE)
    return warped_difference(along_a, along_b, window, SKEW)


def _smoothed(outline: FloatArray) -> tuple[FloatArray, float]:
    """Even samples of a closed polygon, smoothed along it, and their distance along it."""
    length = float(arc_length(outline)[-1])
    count = max(32, math.ceil(SAMPLES * length / SCALE))
    step = length / count
    samples = at_length(outline, np.arange(count, dtype=np.float64) * step)
    smooth: FloatArray = gaussian_filter1d(samples, SCALE / step, axis=0, mode="wrap")
    return smooth, step


def _directions(points: FloatArray) -> FloatArray:
    ahead = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    return np.asarray(np.arctan2(ahead[:, 1], ahead[:, 0]))
