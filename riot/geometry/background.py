"""Fields that are small on the page and large on the object: distances of colours from the page's (ours)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from riot.geometry.levels import two_levels
from riot.geometry.quality import CHECKED, SHADED
from riot.types import BoolArray, FloatArray

_NOISE = 12.0
"""Distance of colours, of 255, that is noise at least."""

_UNIFORM = 0.6
"""Share of the border that must have one colour for it to be the page's."""

_CHECKS = 8
"""Least changes between two colours along the border of a checkerboard."""

_CHECK_SHARE = 0.25
"""Least share of each of them."""

_FIT_SIDE = 96
"""Pixels of the longer side at which the light on a page is fitted."""

_FIT_ROUNDS = 6
_FIT_DEGREE = 4

_FINE = 16.0
"""The fitted light is rounded to 1 / this grey value, so that rounding does not depend on the machine."""

_AXIS_ROUNDS = 3

_OUTLIERS = 0.2
"""Per cent of the values at each end that may be outliers."""

_PLATEAU_ROUNDS = 3
_LEAST_PLATEAU = 0.02
_STEEP = 0.2


def fields(values: FloatArray) -> Iterator[tuple[FloatArray, str]]:
    """Fields (rows, columns) by which values (rows, columns, channels) may separate, each with a remark or ""."""
    rim = _rim(values)
    page = np.median(rim, axis=0)
    far = _distance(rim, page)
    noise = max(_NOISE, 3.0 * float(np.median(far)))
    checks = _two_colours(rim)
    if checks is not None:
        yield np.minimum(_distance(values, checks[0]), _distance(values, checks[1])), CHECKED
    if (far <= noise).mean() >= _UNIFORM:
        yield _capped(_distance(values, page)), ""
    yield _capped(_shaded(values)), SHADED
    if values.shape[2] > 1:
        yield _along_axis(values), ""
    low, high = np.percentile(values.mean(axis=2), [_OUTLIERS, 100.0 - _OUTLIERS])
    yield np.clip(values.mean(axis=2), low, high), ""


def explained_variance(colours: npt.NDArray[np.uint8], light: BoolArray) -> float:
    """Share of the variance of colours (rows, columns, 3) that the difference of two classes explains, 0 … 1.

    >>> colours = np.zeros((2, 2, 3), np.uint8)
    >>> colours[0, 0] = 255
    >>> explained_variance(colours, colours[..., 0] > 0)
    1.0
    """
    values = colours.reshape(-1, 3).astype(np.float64)
    chosen = light.ravel()
    variance = float(values.var(axis=0).sum())
    share = float(chosen.mean())
    if variance == 0.0 or not 0.0 < share < 1.0:
        return 0.0
    difference = values[chosen].mean(axis=0) - values[~chosen].mean(axis=0)
    return share * (1.0 - share) * float((difference**2).sum()) / variance


def _rim(values: FloatArray) -> FloatArray:
    return np.concatenate([values[0], values[1:-1, -1], values[-1, ::-1], values[-2:0:-1, 0]])


def _distance(values: FloatArray, colour: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(((values - colour) ** 2).sum(axis=-1)))


def _capped(distance: FloatArray) -> FloatArray:
    """Distances that are cut off at the level of the object's palest part, so that its other parts are no nearer."""
    for _ in range(_PLATEAU_ROUNDS):
        if distance.max() <= 0.0:
            return distance
        levels = two_levels(distance)
        threshold = 0.5 * (levels.low + levels.high)
        light = distance > threshold
        between = ~light & (distance > max(_NOISE, 3.0 * levels.low, _STEEP * threshold))
        if between.sum() < _LEAST_PLATEAU * light.sum():
            break
        thick = ndimage.binary_opening(between, np.ones((3, 3), dtype=bool))
        inner = distance[thick]
        if inner.size < max(_LEAST_PLATEAU * light.sum(), 0.4 * between.sum()) or inner.std() > 0.25 * inner.mean():
            break
        distance = np.minimum(distance, float(np.median(inner)))
    else:
        return distance
    # Above the object's own level there is nothing to tell apart.
    return np.minimum(distance, float(np.percentile(distance[light], 25.0))) if light.any() else distance


def _two_colours(rim: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """The two colours that alternate along a border, if they do."""
    grey = rim.mean(axis=1)
    if np.ptp(grey) <= 0.0:
        return None
    levels = two_levels(grey[None])
    light = grey > 0.5 * (levels.low + levels.high)
    share = float(light.mean())
    changes = int((light[1:] != light[:-1]).sum())
    if not _CHECK_SHARE <= share <= 1.0 - _CHECK_SHARE or changes < _CHECKS or levels.criterion < 0.9:
        return None
    return np.median(rim[light], axis=0), np.median(rim[~light], axis=0)


def _shaded(values: FloatArray) -> FloatArray:
    """Distance from a page whose colour changes smoothly: a polynomial, fitted to all that is near it."""
    step = max(1, -(-max(values.shape[:2]) // _FIT_SIDE))
    coarse = values[step // 2 :: step, step // 2 :: step]
    rows, columns = np.mgrid[0 : coarse.shape[0], 0 : coarse.shape[1]].astype(np.float64)
    y, x = rows / max(1, coarse.shape[0] - 1) * 2.0 - 1.0, columns / max(1, coarse.shape[1] - 1) * 2.0 - 1.0
    ring = (np.abs(y) > 0.9) | (np.abs(x) > 0.9)
    chosen = ring
    degree = 2
    fitted = np.zeros_like(coarse)
    coefficients = np.zeros((1, values.shape[2]))
    for number in range(_FIT_ROUNDS):
        terms = _terms(y, x, degree)
        coefficients = np.linalg.lstsq(terms[chosen], coarse[chosen], rcond=None)[0]
        fitted = terms @ coefficients
        distance = _distance(coarse, fitted)
        if distance.max() <= 0.0:
            break
        levels = two_levels(distance)
        chosen = distance <= max(_NOISE, 0.5 * (levels.low + levels.high) * 0.7)
        if number + 1 < _FIT_ROUNDS and chosen.sum() > 60:
            degree = _FIT_DEGREE if number else 2
        if chosen.sum() <= 60:
            chosen = ring
            break
    full_y = (np.arange(values.shape[0]) - step // 2) / step / max(1, coarse.shape[0] - 1) * 2.0 - 1.0
    full_x = (np.arange(values.shape[1]) - step // 2) / step / max(1, coarse.shape[1] - 1) * 2.0 - 1.0
    page = _surface(full_y, full_x, coefficients)
    return _distance(values, np.rint(page * _FINE) / _FINE)


def _powers(count: int) -> list[tuple[int, int]]:
    degree = 0
    while (degree + 1) * (degree + 2) // 2 < count:
        degree += 1
    return [(a, total - a) for total in range(degree + 1) for a in range(total + 1)]


def _terms(y: FloatArray, x: FloatArray, degree: int) -> FloatArray:
    powers = _powers((degree + 1) * (degree + 2) // 2)
    return np.stack([y**a * x**b for a, b in powers], axis=-1)


def _surface(y: FloatArray, x: FloatArray, coefficients: FloatArray) -> FloatArray:
    page = np.zeros((len(y), len(x), coefficients.shape[1]))
    for (a, b), weights in zip(_powers(len(coefficients)), coefficients, strict=True):
        page += (y**a)[:, None, None] * (x**b)[None, :, None] * weights
    return page


def _along_axis(values: FloatArray) -> FloatArray:
    """Values along the line through the means of two classes of colours, which start from the best channel."""
    best = max(range(values.shape[2]), key=lambda channel: _contrast(values[..., channel]))
    field = values[..., best]
    for _ in range(_AXIS_ROUNDS):
        if field.max() <= field.min():
            break
        levels = two_levels(field)
        light = field > 0.5 * (levels.low + levels.high)
        axis = values[light].mean(axis=0) - values[~light].mean(axis=0)
        length = float(np.sqrt((axis**2).sum()))
        if length <= 0.0:
            break
        field = ((values - values[~light].mean(axis=0)) * (axis / length)).sum(axis=-1)
    return np.asarray(field)


def _contrast(channel: FloatArray) -> float:
    return two_levels(channel).criterion if np.ptp(channel) > _NOISE else 0.0
