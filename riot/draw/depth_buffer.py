"""Find which triangle is nearest to the eye at every pixel. Ours.

Every triangle is cut into rows of pixels, and of all that fall on a pixel the nearest stays. Sums and products only, in
a fixed order, so that a picture has the same bytes on any machine.
"""

from __future__ import annotations

import numpy as np

from riot.draw.tuning import BATCH_PIXELS
from riot.types import FloatArray, IntArray


def nearest_triangles(corners: FloatArray, rows: int, columns: int) -> IntArray:
    """(rows, columns) which of the triangles (f, 3, 3) is seen at each pixel's middle, −1 for none.

    ``corners`` are columns, rows, and how near; a triangle that is clockwise is seen from behind, and not drawn.

    >>> triangle = np.array([[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]])
    >>> nearest_triangles(triangle, 4, 5)[1].tolist()
    [0, 0, 0, -1, -1]
    """
    depth = np.full(rows * columns, -np.inf)
    nearest = np.full(rows * columns, -1, dtype=np.int64)
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    doubled = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    front = np.flatnonzero(doubled > 0.0)
    # Of each triangle about its area, and half a pixel of every row at either end.
    pixels = 1.0 + 0.5 * doubled[front] + np.ceil(np.ptp(corners[front, :, 1], axis=1))
    batch = (np.cumsum(pixels) // BATCH_PIXELS).astype(np.int64)
    for number in np.unique(batch).tolist():
        chosen = front[batch == number]
        pixel, near, triangle = _fragments(corners[chosen], doubled[chosen], columns)
        nearer = near > depth[pixel]
        pixel, near, triangle = pixel[nearer], near[nearer], chosen[triangle[nearer]]
        np.maximum.at(depth, pixel, near)
        # Backwards, as the last of equal pixels is what stays: of triangles that are equally near, the first.
        winners = np.flatnonzero(near == depth[pixel])[::-1]
        nearest[pixel[winners]] = triangle[winners]
    return nearest.reshape(rows, columns)


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
    # How near is a plane over the pixels: its value where a row begins, and its slope along the row.
    x, y = begin + 0.5 - corners[owner, 0, 0], y - corners[owner, 0, 1]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    along_rows = (a[:, 2] * b[:, 1] - b[:, 2] * a[:, 1]) / doubled
    upwards = (b[:, 2] * a[:, 0] - a[:, 2] * b[:, 0]) / doubled
    at_begin = corners[owner, 0, 2] + x * along_rows[owner] + y * upwards[owner]
    near = at_begin[span] + along * along_rows[owner][span]
    return (row * columns + begin)[span] + along, near, owner[span]


def _expanded(counts: IntArray) -> tuple[IntArray, IntArray]:
    """For ``counts[i]`` entries of each i: i, and the number of the entry within it."""
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
