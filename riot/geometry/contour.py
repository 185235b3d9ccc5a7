"""From the pixels of a picture to the outline of the object in it (paper §6)."""

from __future__ import annotations

import math

import numpy as np
from scipy import ndimage
from skimage.measure import find_contours

from riot.errors import SilhouetteError
from riot.geometry import polyline
from riot.geometry.picture import Picture
from riot.geometry.quality import ReadingQuality
from riot.geometry.separation import separate
from riot.parameters import ShapeParameters
from riot.types import BoolArray, FloatArray

_FINE_SIDE = 512.0
"""√area, pixels, above which an object is averaged down. Ours: the contour stays many times finer than the sampling."""

_FAITHFUL = 0.02
"""Share of the area by which a contour may differ from the pixels; above it smoothing is reduced. Ours."""

_BLUR_REACH = 4.0
"""Standard deviations after which SciPy cuts off a Gaussian."""


def find_object(
    picture: Picture, where: str, parameters: ShapeParameters
) -> tuple[FloatArray, BoolArray, ReadingQuality]:
    """Find the object in a picture: its share of each pixel, in [0, 1], its largest component's pixels, filled, and
    how well it is separate from the page.

    ``where`` names the picture in errors.

    Raises
    ------
    SilhouetteError
        ``one-colour``, ``all-border``, ``too-small``.
    """
    if picture.grey.min() == picture.grey.max() and picture.colours is None:
        raise SilhouetteError(
            "one-colour", f"{where}: all pixels are alike; the picture must show an object on a background"
        )
    if min(picture.grey.shape) < 3:
        raise SilhouetteError("all-border", f"{where}: every pixel is on the border; add a margin to the picture")
    seen = separate(picture)
    count = int(seen.component.sum()) * picture.factor**2
    if count < parameters.min_pixels:
        raise SilhouetteError(
            "too-small",
            f"{where}: the object has {count} pixels, fewer than min_pixels, {parameters.min_pixels}; "
            "use a larger picture",
        )
    return seen.ramp, seen.component, seen.quality


def trace_contour(ramp: FloatArray, component: BoolArray, smoothing: float, where: str) -> FloatArray:
    """Trace the outline of a component at sub-pixel accuracy: (m, 2) as (column, row), in pixels.

    ``ramp`` (rows, columns) is the object's share of each pixel; ``smoothing`` the standard deviation of a Gaussian, in
    pixels, which is lowered where it would change the area. Raises SilhouetteError ``degenerate``.
    """
    rows, columns = np.flatnonzero(component.any(axis=1)), np.flatnonzero(component.any(axis=0))
    top, left = int(rows[0]), int(columns[0])
    box = (slice(top, int(rows[-1]) + 1), slice(left, int(columns[-1]) + 1))
    inside = component[box]
    step = max(1, int(math.sqrt(inside.sum()) / _FINE_SIDE))
    margin = step * (2 + math.ceil(_BLUR_REACH * smoothing))
    extra = [-n % step for n in inside.shape]
    inside = np.pad(inside, ((margin, margin + extra[0]), (margin, margin + extra[1])))
    near = np.pad(ramp[box], ((margin, margin + extra[0]), (margin, margin + extra[1])))
    # Grey values count only next to the outline, and cannot move it to another component.
    field = np.where(inside, np.maximum(near, 0.5), np.minimum(near, 0.5))
    all_sides, any_side = _with_neighbours(inside)
    field[all_sides] = 1.0
    field[~any_side] = 0.0
    if step > 1:
        field = field.reshape(field.shape[0] // step, step, field.shape[1] // step, step).mean(axis=(1, 3))
    area = float(field.sum())
    for sigma in (smoothing, smoothing / 2.0, 0.0):
        smooth = ndimage.gaussian_filter(field, sigma, mode="constant") if sigma > 0.0 else field
        # "low": the background connects over corners, the object does not, as in the labelling above.
        contours = find_contours(smooth, 0.5, fully_connected="low")
        if not contours:
            continue
        contour = max(contours, key=lambda points: abs(polyline.signed_area(points[:-1])))[:-1]
        if sigma == 0.0 or abs(abs(polyline.signed_area(contour)) - area) <= _FAITHFUL * area:
            break
    else:
        raise SilhouetteError("degenerate", f"{where}: the object is too thin for an outline; use a larger picture")
    pixels = contour[:, ::-1] * step + ((step - 1) / 2.0 - margin)
    return np.asarray(pixels + np.array([left, top]), dtype=np.float64)


def _with_neighbours(inside: BoolArray) -> tuple[BoolArray, BoolArray]:
    """Pixels that are inside with all four neighbours; pixels that are, or have a neighbour, inside.

    The array's own border must be outside.
    """
    rows = inside[:-1] & inside[1:]
    columns = inside[:, :-1] & inside[:, 1:]
    all_sides = np.zeros_like(inside)
    all_sides[1:-1, 1:-1] = rows[:-1, 1:-1] & rows[1:, 1:-1] & columns[1:-1, :-1] & columns[1:-1, 1:]
    any_side = inside.copy()
    any_side[1:] |= inside[:-1]
    any_side[:-1] |= inside[1:]
    any_side[:, 1:] |= inside[:, :-1]
    any_side[:, :-1] |= inside[:, 1:]
    return all_sides, any_side
