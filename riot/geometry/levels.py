"""Two levels in a field of pixel values: Otsu's threshold, how clearly it separates, and levels that it overlooks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import ndimage
from skimage.filters import threshold_otsu

from riot.types import BoolArray, FloatArray, IntArray

LEVELS = 256
"""Levels of Otsu's threshold."""

_NEAR = 0.12
"""Share of the contrast by which a pixel may differ from the background and count as its noise. Ours."""

_SPREAD = 0.25
"""Standard deviation, as a share of the mean, above which such pixels are a slope and no level of their own. Ours:
values that are spread evenly from `_NEAR` to half the contrast have 0.35."""

_LEAST_LEVEL = 0.02
"""Share of the object's area below which a level of its own is left alone. Ours."""


class Levels(NamedTuple):
    """Mean of the dark and of the light pixels, and Otsu's criterion: between-class over total variance, 0 … 1."""

    low: float
    high: float
    criterion: float


@dataclass(frozen=True, eq=False)
class WeakLevel:
    """Pixels that count as background and have a level of their own: a pale part of the object, or another page.

    ``level`` is their mean share of the contrast, ``pixels`` a (rows, columns) mask.
    """

    level: float
    pixels: BoolArray


def two_levels(field: FloatArray) -> Levels:
    """Separate a field that is not constant by Otsu's threshold (Otsu 1979).

    >>> two_levels(np.array([[0.0, 0.0, 9.0]])).high
    9.0
    """
    least, most = float(field.min()), float(field.max())
    levels = ((field - least) * ((LEVELS - 1.0) / (most - least))).astype(np.uint8)
    counts: IntArray = np.bincount(levels.ravel(), minlength=LEVELS).astype(np.int64)
    split = int(threshold_otsu(hist=counts)) + 1
    dark, light = counts[:split], counts[split:]
    step = (most - least) / (LEVELS - 1.0)
    low = float(np.dot(dark, np.arange(split)) / dark.sum())
    high = float(np.dot(light, np.arange(split, LEVELS)) / light.sum())
    return Levels(least + step * low, least + step * high, _criterion(counts, split, low, high))


def _criterion(counts: IntArray, split: int, low: float, high: float) -> float:
    values, total = np.arange(LEVELS), float(counts.sum())
    mean = float((counts * values).sum()) / total
    variance = float((counts * (values - mean) ** 2).sum()) / total
    share = float(counts[:split].sum()) / total
    return min(1.0, share * (1.0 - share) * (high - low) ** 2 / variance)


def weak_level(field: FloatArray, levels: Levels, light: BoolArray) -> WeakLevel | None:
    """Find a level of its own among the pixels that are not ``light`` (rows, columns), or are light against polarity.

    Slopes, such as blurred edges and soft shadows, and single pixels of noise are none.
    """
    contrast = levels.high - levels.low
    inverted = bool(light.any()) and field[light].mean() < 0.5 * (levels.low + levels.high)
    page = levels.high if inverted else levels.low
    far = ~light & (np.abs(field - page) > _NEAR * contrast)
    if far.sum() < _LEAST_LEVEL * light.sum():
        return None
    thick = ndimage.binary_opening(far, np.ones((3, 3), dtype=bool))
    if thick.sum() < max(_LEAST_LEVEL * light.sum(), 0.5 * far.sum()):
        return None
    values = np.abs(field[thick] - page)
    mean = float(values.mean())
    return None if float(values.std()) > _SPREAD * mean else WeakLevel(mean / contrast, thick)
