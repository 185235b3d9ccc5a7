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

from riot.geometry.polyline import arc_length, at_length
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
    # Without a tree, which is in scipy: to load that takes longer than to measure all distances.
    squared = (a[:, None, 0] - b[:, 0]) ** 2 + (a[:, None, 1] - b[:, 1]) ** 2
    start = int(np.argmin(np.sqrt(squared.min(axis=1))))
    along_a, along_b = np.roll(_directions(a), -start), np.roll(_directions(b), -int(np.argmin(squared[start])))
    window = math.ceil(SAMPLES_PER_SCALE * DISPLACEMENT_WINDOW / SMOOTHING_SCALE)
    return _warped_difference(along_a, along_b, window, LONE_STEP_COST)


def _smoothed(outline: FloatArray) -> tuple[FloatArray, float]:
    """Even samples of a closed polygon, smoothed along it, and their distance along it."""
    length = float(arc_length(outline)[-1])
    count = max(LEAST_SMOOTHED_SAMPLES, math.ceil(SAMPLES_PER_SCALE * length / SMOOTHING_SCALE))
    step = length / count
    samples = at_length(outline, np.arange(count, dtype=np.float64) * step)
    return _gaussian(samples, SMOOTHING_SCALE / step), step


def _gaussian(samples: FloatArray, sigma: float) -> FloatArray:
    """Samples (m, 2) of a closed curve, smoothed along it by a Gaussian of ``sigma`` samples, cut off at four."""
    reach = int(4.0 * sigma + 0.5)
    weights = np.exp(-0.5 / (sigma * sigma) * np.arange(-reach, reach + 1) ** 2)
    weights /= weights.sum()
    smooth: FloatArray = samples * weights[reach]
    for distance in range(reach, 0, -1):
        both = np.roll(samples, distance, axis=0) + np.roll(samples, -distance, axis=0)
        smooth += both * weights[reach - distance]
    return smooth


def _warped_difference(a: FloatArray, b: FloatArray, window: int, skew: float) -> float:
    """Mean angle, radians, between directions ``a`` (m,) and ``b`` (k,) of even samples of two outlines.

    Of all monotone correspondences from start to start and end to end that stay within ``window`` samples of the even
    one, that of least sum, where a step on one outline only costs ``skew`` more. Sample i of the first can correspond
    to sample j of the second; the pairs of equal i + j are one diagonal, whose sums depend on the two diagonals before.
    """
    m, k = len(a), len(b)
    rows = np.arange(m)
    middle = rows * (k - 1) // max(m - 1, 1)
    low, high = np.maximum(middle - window, 0), np.minimum(middle + window + 1, k)
    diagonals = np.arange(m + k - 1)
    firsts = np.searchsorted(rows + high, diagonals, side="right")
    lasts = np.searchsorted(rows + low, diagonals, side="right")
    # Of the last three diagonals: the least sums and their numbers of steps by row, after a row before the first.
    sums, steps = np.full((3, m + 1), np.inf), np.zeros((3, m + 1))
    for diagonal, first, last in zip(diagonals.tolist(), firsts.tolist(), lasts.tolist(), strict=True):
        now, before, earlier = diagonal % 3, (diagonal - 1) % 3, (diagonal - 2) % 3
        here, above = slice(first + 1, last + 1), slice(first, last)
        angle = np.abs((a[above] - b[diagonal - rows[above]] + np.pi) % (2.0 * np.pi) - np.pi)
        sums[now] = np.inf
        if diagonal == 0:
            sums[now, here], steps[now, here] = angle, 1.0
            continue
        best, count = sums[earlier, above] + 2.0 * angle, steps[earlier, above] + 2.0
        for predecessor in (above, here):  # a step on the first outline only, or on the second
            alone = sums[before, predecessor] + angle + skew
            shorter = alone < best
            best = np.where(shorter, alone, best)
            count = np.where(shorter, steps[before, predecessor] + 1.0, count)
        sums[now, here], steps[now, here] = best, count
    end = (m + k - 2) % 3
    return float(sums[end, m] / steps[end, m])


def _directions(points: FloatArray) -> FloatArray:
    ahead = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    return np.asarray(np.arctan2(ahead[:, 1], ahead[:, 0]))
