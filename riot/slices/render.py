"""Solids in the round seen from the side at a slant, in a parallel view, by a depth buffer. Ours.

No window and no graphics library: every triangle is cut into rows of pixels, and of all that fall on a pixel the
nearest stays. Sums and products only, in a fixed order, so that a picture has the same bytes on any machine.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from riot.types import FloatArray, IntArray

ByteArray = npt.NDArray[np.uint8]

AZIMUTH, ELEVATION = math.radians(-60.0), math.radians(24.0)
"""Of the eye: around the z-axis from the x-axis, and over the plane."""

FINER = 2
"""Pixels are means of so many squared."""

_LIGHT = (-0.45, 0.35, 0.82)
"""Towards the light: to the right, upwards, to the eye."""
_DARKEST = 0.42
_EDGE = 0.35
_BATCH = 1 << 20


@dataclass(frozen=True, eq=False)
class Body:
    """A solid: (v, 3) points in mm, (f, 3) triangles counter-clockwise from outside; colour: RGB in [0, 1]."""

    points: FloatArray
    triangles: IntArray
    colour: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class View:
    """A picture, (rows, columns, 3), white where nothing is, and its size in mm as seen."""

    pixels: ByteArray
    width: float
    height: float


def seen(points: FloatArray) -> FloatArray:
    """(v, 3) points as the eye has them: to the right, upwards, towards it."""
    x, y, z = points.T
    across, deep = -math.sin(AZIMUTH), math.cos(AZIMUTH)
    # The eye is at azimuth and elevation; `out` is the part of a point towards it on the plane.
    right = across * x + deep * y
    out = deep * x - across * y
    up = z * math.cos(ELEVATION) - out * math.sin(ELEVATION)
    near = out * math.cos(ELEVATION) + z * math.sin(ELEVATION)
    return np.column_stack([right, up, near])


def render(bodies: Sequence[Body], mm_per_pixel: float) -> View:
    """Draw some solids, edges between two of them and towards the background darkened."""
    step = mm_per_pixel / FINER
    corners = [seen(body.points)[body.triangles] for body in bodies]
    every = np.concatenate([each.reshape(-1, 3) for each in corners])
    low, high = every.min(axis=0), every.max(axis=0)
    # Two pixels of margin, for the edges.
    columns, rows = (FINER * (math.ceil(length / mm_per_pixel) + 4) for length in (high - low)[:2].tolist())
    shift = np.array([low[0], low[1], 0.0]) - 2.0 * FINER * step * np.array([1.0, 1.0, 0.0])
    scaled = [(each - shift) / np.array([step, step, 1.0]) for each in corners]
    owners = np.repeat(np.arange(len(bodies)), [len(each) for each in corners])
    owner, bright = _buffer(
        np.concatenate(scaled), np.concatenate([_brightness(each) for each in corners]), owners, rows, columns
    )
    colours = np.array([body.colour for body in bodies])
    image = np.ones((rows, columns, 3))
    image[owner >= 0] = colours[owner[owner >= 0]] * bright[owner >= 0, None]
    image[_edges(owner)] *= _EDGE
    mean = image.reshape(rows // FINER, FINER, columns // FINER, FINER, 3).mean(axis=(1, 3))
    pixels = np.round(255.0 * mean[::-1]).astype(np.uint8)
    return View(pixels, columns * step, rows * step)


def _brightness(corners: FloatArray) -> FloatArray:
    """(f,) how bright each triangle (f, 3, 3) is, as the light falls on it."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(a, b)
    length = np.sqrt((normal * normal).sum(axis=1))
    length[length == 0.0] = 1.0
    x, y, z = (normal / length[:, None]).T
    fallen: FloatArray = np.clip(x * _LIGHT[0] + y * _LIGHT[1] + z * _LIGHT[2], 0.0, 1.0)
    return _DARKEST + (1.0 - _DARKEST) * fallen


def _buffer(
    corners: FloatArray, bright: FloatArray, owners: IntArray, rows: int, columns: int
) -> tuple[IntArray, FloatArray]:
    """(rows, columns) which body is seen at each pixel's middle, −1 for none, and how bright it is.

    ``corners`` (f, 3, 3): column, row, towards the eye.
    """
    depth = np.full(rows * columns, -np.inf)
    owner, light = np.full(rows * columns, -1, dtype=np.int64), np.ones(rows * columns)
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    doubled = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    front = np.flatnonzero(doubled > 0.0)
    pixels = np.maximum(
        1, np.ceil(np.ptp(corners[front, :, 0], axis=1)) * np.ceil(np.ptp(corners[front, :, 1], axis=1))
    )
    batch = (np.cumsum(pixels) // _BATCH).astype(np.int64)
    for number in np.unique(batch).tolist():
        chosen = front[batch == number]
        place, near, triangle = _fragments(corners[chosen], doubled[chosen], columns)
        # The nearest last, so that it is what stays; of equals the first triangle.
        order = np.lexsort((-triangle, near, place))
        place, near, triangle = place[order], near[order], chosen[triangle[order]]
        last = np.flatnonzero(np.append(place[1:] != place[:-1], True)) if len(place) else order
        last = last[near[last] > depth[place[last]]]
        depth[place[last]], owner[place[last]] = near[last], owners[triangle[last]]
        light[place[last]] = bright[triangle[last]]
    return owner.reshape(rows, columns), light.reshape(rows, columns)


def _fragments(corners: FloatArray, doubled: FloatArray, columns: int) -> tuple[IntArray, FloatArray, IntArray]:
    """All middles of pixels in some triangles: which pixel, how near, and which triangle."""
    first = np.ceil(corners[:, :, 1].min(axis=1) - 0.5).astype(np.int64)
    count = np.maximum(0, np.floor(corners[:, :, 1].max(axis=1) - 0.5).astype(np.int64) - first + 1)
    owner, offset = _expanded(count)
    row = first[owner] + offset
    left, right = np.full(len(owner), -np.inf), np.full(len(owner), np.inf)
    y = row + 0.5
    for k in range(3):
        start, stop = corners[owner, k], corners[owner, (k + 1) % 3]
        rise = stop[:, 1] - start[:, 1]
        with np.errstate(divide="ignore", invalid="ignore"):
            at = start[:, 0] + (y - start[:, 1]) / rise * (stop[:, 0] - start[:, 0])
        # Counter-clockwise with rows upwards: what falls is on the left.
        left = np.where(rise < 0.0, np.maximum(left, at), left)
        right = np.where(rise > 0.0, np.minimum(right, at), right)
    begin = np.ceil(left - 0.5).astype(np.int64)
    width = np.maximum(0, np.floor(right - 0.5).astype(np.int64) - begin + 1)
    span, along = _expanded(width)
    triangle, x, y = owner[span], begin[span] + along + 0.5, y[span]
    origin = corners[triangle, 0]
    a, b = corners[triangle, 1] - origin, corners[triangle, 2] - origin
    x, y = x - origin[:, 0], y - origin[:, 1]
    s, t = (x * b[:, 1] - y * b[:, 0]) / doubled[triangle], (a[:, 0] * y - a[:, 1] * x) / doubled[triangle]
    near = origin[:, 2] + s * a[:, 2] + t * b[:, 2]
    return row[span] * columns + begin[span] + along, near, triangle


def _expanded(counts: IntArray) -> tuple[IntArray, IntArray]:
    """For ``counts[i]`` entries of each i: i, and the number of the entry within it."""
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)


def _edges(owner: IntArray) -> npt.NDArray[np.bool_]:
    """Pixels that lie beside a pixel of another body."""
    found = np.zeros(owner.shape, dtype=np.bool_)
    for axis in (0, 1):
        differs = np.diff(owner, axis=axis) != 0
        for side in (slice(None, -1), slice(1, None)):
            place = (side, slice(None)) if axis == 0 else (slice(None), side)
            found[place] |= differs
    return found & (owner >= 0)
