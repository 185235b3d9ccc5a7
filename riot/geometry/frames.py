"""What scans and prints add to a page: lines across it, and frames around it (ours)."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from riot.types import BoolArray, FloatArray

_LINE = 0.01
"""Greatest width of a line, as a share of the page's side."""

_ACROSS = 0.9
"""Least length of a line, as a share of the page's side."""

_RECTANGLE = 0.98
"""Share of its upright box that a rectangle fills at least."""

_AROUND = 0.6
"""Share of the page that a frame goes around at least."""

_THIN = 0.25
"""Greatest share of its box that a frame covers."""

_MARGIN = 0.04
"""Greatest width of a frame at the border of the page, as a share of its side."""

_SHOWN = 0.01
"""Least share of the page inside a frame that shows something."""

_NESTED = 3
"""Frames inside one another."""

MOST_LINES = 4
"""Lines that are left out, one after another."""


def box_of(mask: BoolArray) -> tuple[slice, slice]:
    """The upright box around the pixels of a mask that has some.

    >>> box_of(np.eye(3, dtype=bool))
    (slice(0, 3, None), slice(0, 3, None))
    """
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def is_rectangle(mask: BoolArray) -> bool:
    """Whether a mask fills its upright box.

    >>> is_rectangle(np.eye(3, dtype=bool))
    False
    """
    return bool(mask.any()) and float(mask[box_of(mask)].mean()) >= _RECTANGLE


def is_line(mask: BoolArray) -> bool:
    """Whether a mask is a row or a column, or a few, from side to side of the page.

    >>> page = np.zeros((50, 200), bool)
    >>> page[:, 7] = True
    >>> is_line(page)
    True
    """
    return bool(mask.any()) and _line_axis(mask) is not None


def _line_axis(mask: BoolArray) -> int | None:
    sizes = [part.stop - part.start for part in box_of(mask)]
    for axis in (0, 1):
        side, other = mask.shape[axis], mask.shape[1 - axis]
        if sizes[axis] <= max(2.0, _LINE * side) and sizes[1 - axis] >= _ACROSS * other:
            return axis
    return None


def without_lines(values: FloatArray, component: BoolArray) -> FloatArray | None:
    """Values (rows, columns, channels) with what ``component`` has of a line replaced by what is beside it; None if it
    is no line."""
    axis = _line_axis(component) if component.any() else None
    if axis is None:
        return None
    part = box_of(component)[axis]
    start, stop = part.start, part.stop
    moved = np.moveaxis(values, axis, 0).copy()
    if start == 0 and stop == len(moved):
        return None
    # One pixel more on each side: lines have soft edges.
    low, high = max(0, start - 1), min(len(moved), stop + 1)
    moved[low:high] = moved[low - 1] if low > 0 else moved[high]
    return np.moveaxis(moved, 0, axis)


def inside_frame(ramp: FloatArray, light: BoolArray, component: BoolArray) -> tuple[FloatArray, BoolArray] | None:
    """Share and pixels of the object inside a frame that was taken for the object; None if there is no frame."""
    found = None
    for _ in range(_NESTED):
        if not is_rectangle(component) or component.mean() < _AROUND * _RECTANGLE:
            break
        inner = _inside(ramp, light, component)
        if inner is None:
            break
        found = ramp, light = inner
        component = _largest(light)
    return found


def _inside(ramp: FloatArray, light: BoolArray, component: BoolArray) -> tuple[FloatArray, BoolArray] | None:
    box = box_of(component)
    area = int(component.sum())
    line = _connected(light, component)
    if int(line.sum()) <= _THIN * area:  # a line around a page, on which the object has the line's colour
        shown = light & component & ~line
        share = np.where(component & ~line, ramp, 0.0)
    else:  # a page inside a border of the object's colour
        margins = (box[0].start, light.shape[0] - box[0].stop, box[1].start, light.shape[1] - box[1].stop)
        if max(margins) > _MARGIN * max(light.shape):
            return None
        shown = component & ~light
        share = np.where(component, 1.0 - ramp, 0.0)
        rim = component & ~ndimage.binary_erosion(component, np.ones((3, 3), dtype=bool), iterations=2)
        share[rim] = 0.0
        shown &= ~rim
    return (share, shown) if int(shown.sum()) >= _SHOWN * area else None


def _connected(light: BoolArray, component: BoolArray) -> BoolArray:
    """The largest part of ``light`` within ``component`` that reaches the edge of its box: the component, unfilled."""
    labels, _ = ndimage.label(light & component, structure=np.ones((3, 3), dtype=bool))
    box = box_of(component)
    middle = (box[0].start + box[0].stop) // 2
    row = labels[middle, box[1]]
    present = row[row > 0]
    return np.asarray(labels == int(present[0]) if len(present) else labels > 0, dtype=np.bool_)


def _largest(light: BoolArray) -> BoolArray:
    outside, _ = ndimage.label(np.pad(~light, 1, constant_values=True), structure=np.ones((3, 3), dtype=bool))
    labels, _ = ndimage.label(outside[1:-1, 1:-1] != outside[0, 0])
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    return np.asarray(labels == int(sizes.argmax()), dtype=np.bool_)
