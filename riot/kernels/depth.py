"""Which triangle is nearest to the eye at every pixel: the loop behind `riot.draw.depth_buffer`."""

from __future__ import annotations

import math

import numpy as np

from riot.kernels.options import kernel
from riot.types import FloatArray, IntArray


@kernel
def nearest(corners: FloatArray, rows: int, columns: int) -> IntArray:
    """(rows, columns) index of the triangle (f, 3, 3) that is seen at each pixel's middle, −1 for none.

    Corners are columns, rows, and how near; clockwise triangles are seen from behind, and left out. Of triangles that
    are equally near the first stays.
    """
    depth = np.full((rows, columns), -np.inf)
    found = np.full((rows, columns), -1, dtype=np.int64)
    for f in range(corners.shape[0]):
        ax = corners[f, 1, 0] - corners[f, 0, 0]
        ay = corners[f, 1, 1] - corners[f, 0, 1]
        az = corners[f, 1, 2] - corners[f, 0, 2]
        bx = corners[f, 2, 0] - corners[f, 0, 0]
        by = corners[f, 2, 1] - corners[f, 0, 1]
        bz = corners[f, 2, 2] - corners[f, 0, 2]
        doubled = ax * by - ay * bx
        if doubled <= 0.0:
            continue
        along_rows = (az * by - bz * ay) / doubled
        upwards = (bz * ax - az * bx) / doubled
        low = min(corners[f, 0, 1], corners[f, 1, 1], corners[f, 2, 1])
        high = max(corners[f, 0, 1], corners[f, 1, 1], corners[f, 2, 1])
        first = max(0, math.ceil(low - 0.5))
        last = min(rows - 1, math.floor(high - 0.5))
        for row in range(first, last + 1):
            y = row + 0.5
            left = -np.inf
            right = np.inf
            for k in range(3):
                n = k + 1 if k < 2 else 0
                rise = corners[f, n, 1] - corners[f, k, 1]
                if rise == 0.0:
                    continue
                at = corners[f, k, 0] + (y - corners[f, k, 1]) / rise * (corners[f, n, 0] - corners[f, k, 0])
                # Counter-clockwise with rows upwards: what falls is on the left.
                if rise < 0.0:
                    left = max(left, at)
                else:
                    right = min(right, at)
            begin = math.ceil(max(left, -1.0) - 0.5)
            end = math.floor(min(right, columns + 1.0) - 0.5)
            # How near is a plane over the pixels: its value where a row begins, and its slope along the row.
            x = begin + 0.5 - corners[f, 0, 0]
            at_begin = corners[f, 0, 2] + x * along_rows + (y - corners[f, 0, 1]) * upwards
            for column in range(max(begin, 0), min(end, columns - 1) + 1):
                near = at_begin + (column - begin) * along_rows
                if near > depth[row, column]:
                    depth[row, column] = near
                    found[row, column] = f
    return found


def warm() -> None:
    """Compile the kernel."""
    nearest(np.zeros((1, 3, 3)), 2, 2)
