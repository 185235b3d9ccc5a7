"""Parts laid out close together on sheets of one size, turned by quarters, on a raster (ours).

The largest parts come first. Each goes where its upper edge is lowest, on the first sheet that has room for it; what is
free is found for all places at once, as a correlation of the sheet's raster with the part's.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.fft
import shapely
from shapely import affinity

CELL_MM = 1.5
"""mm: step of the raster. A finer one packs little closer and takes longer."""

MOST_CELLS = 320
"""Cells of the raster along a sheet's longer side, at most: bounds the time on large beds."""

Raster = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Nested:
    """Where a part lies: on which sheet, turned by ``angle`` radians about the origin, and then moved by (x, y)."""

    sheet: int
    angle: float
    x: float
    y: float

    def place(self, geometry: shapely.Geometry) -> shapely.Geometry:
        """A geometry of the part's frame on the sheet.

        >>> Nested(0, 0.0, 2.0, 1.0).place(shapely.Point(1.0, 1.0)).coords[0]
        (3.0, 2.0)
        """
        cosine, sine = math.cos(self.angle), math.sin(self.angle)
        return affinity.affine_transform(geometry, [cosine, -sine, sine, cosine, self.x, self.y])


@dataclass(frozen=True, eq=False)
class _Turned:
    """A part turned: the lower left corner of its box, and the cells that it and half the space around it touch."""

    angle: float
    low: tuple[float, float]
    raster: Raster


def nest(parts: Sequence[shapely.Polygon], width: float, height: float, apart: float) -> list[Nested]:
    """Lay parts out on sheets of ``width`` × ``height``, at least ``apart`` from each other and from the sheet's edge.

    All in mm. Raises ValueError, whose second argument is the index of the part, if a part fits on no empty sheet.

    Examples
    --------
    >>> [spot.sheet for spot in nest([shapely.box(0.0, 0.0, 60.0, 60.0)] * 2, 100.0, 100.0, 5.0)]
    [0, 1]
    """
    cell = max(CELL_MM, max(width, height) / MOST_CELLS)
    rows, columns = (max(1, int((side - apart) / cell + 1e-9)) for side in (height, width))
    sheets: list[Raster] = []
    spots: dict[int, Nested] = {}
    for index in sorted(range(len(parts)), key=lambda i: (-float(parts[i].area), i)):
        turned = list(_turned(parts[index], cell, rows, columns, apart))
        if not turned:
            raise ValueError("a part is larger than the sheet", index)
        for number in range(len(sheets) + 1):
            if number == len(sheets):
                sheets.append(np.zeros((rows, columns), dtype=np.bool_))
            place = _lowest(sheets[number], turned)
            if place is not None:
                part, row, column = place
                high, wide = part.raster.shape
                sheets[number][row : row + high, column : column + wide] |= part.raster
                x, y = column * cell + apart - part.low[0], row * cell + apart - part.low[1]
                spots[index] = Nested(number, part.angle, x, y)
                break
    return [spots[index] for index in range(len(parts))]


def _turned(part: shapely.Polygon, cell: float, rows: int, columns: int, apart: float) -> Iterator[_Turned]:
    """The part in its four quarter turns, its narrowest box upright, if that fits."""
    base = _slant(part)
    for quarter in range(4):
        angle = base + 0.5 * math.pi * quarter
        placed = Nested(0, angle, 0.0, 0.0).place(part)
        x0, y0, x1, y1 = placed.bounds
        # Half of the space belongs to the part: two parts share none of it.
        wide, high = (math.ceil((length + apart) / cell - 1e-9) for length in (x1 - x0, y1 - y0))
        if wide > columns or high > rows:
            continue
        reached = shapely.buffer(placed, 0.5 * apart + 0.5 * math.sqrt(2.0) * cell, quad_segs=4)
        shapely.prepare(reached)
        x, y = np.meshgrid(
            x0 - 0.5 * apart + cell * (np.arange(wide) + 0.5), y0 - 0.5 * apart + cell * (np.arange(high) + 0.5)
        )
        yield _Turned(angle, (x0, y0), shapely.contains_xy(reached, x, y))


def _slant(part: shapely.Polygon) -> float:
    """The turn, in radians, that makes the longer side of the part's narrowest box level."""
    corners = shapely.get_coordinates(shapely.minimum_rotated_rectangle(part))[:3]
    sides = np.diff(corners, axis=0)
    x, y = sides[int((sides[1] ** 2).sum() > (sides[0] ** 2).sum())].tolist()
    return -math.atan2(y, x)


def _lowest(sheet: Raster, turned: Sequence[_Turned]) -> tuple[_Turned, int, int] | None:
    """The part's turn, row and column at which its upper edge is lowest, and then its right one leftmost."""
    rows, columns = sheet.shape
    # A shift beyond the sheet would come back on its other side; such shifts are not asked for.
    shape = scipy.fft.next_fast_len(rows, True), scipy.fft.next_fast_len(columns, True)
    taken = scipy.fft.rfft2(sheet.astype(np.float64), shape)
    best: tuple[tuple[int, int], tuple[_Turned, int, int]] | None = None
    for part in turned:
        high, wide = part.raster.shape
        shared = scipy.fft.irfft2(taken * scipy.fft.rfft2(part.raster.astype(np.float64), shape).conj(), shape)
        free = shared[: rows - high + 1, : columns - wide + 1] < 0.5  # counts of cells, but for rounding
        if free.any():
            row, column = divmod(int(free.argmax()), free.shape[1])
            key = (row + high, column + wide)
            if best is None or key < best[0]:
                best = key, (part, row, column)
    return None if best is None else best[1]
