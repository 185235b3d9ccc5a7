"""Boxes laid out in rows: pieces on a sheet of paper or for the laser, parts on a printer's bed. Ours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from riot.types import FloatArray


@dataclass(frozen=True)
class Spot:
    """Where a box lies: its page, its lower left corner, and whether it is turned by a quarter, counter-clockwise."""

    page: int
    x: float
    y: float
    turned: bool


def shelves(sizes: FloatArray, width: float, height: float, apart: float) -> list[Spot]:
    """Lay boxes out in rows on pages of one size: the tallest first, each row as high as its first box.

    Parameters
    ----------
    sizes : (k, 2) float64
        Width and height of every box. A box that fits a page only after a quarter turn is turned.
    width, height : float
        Of a page; the height may be infinite.
    apart : float
        Between boxes.

    Raises ValueError if a box fits no page.
    """
    turned = (sizes[:, 0] > width) | (sizes[:, 1] > height)
    boxes = np.where(turned[:, None], sizes[:, ::-1], sizes)
    if (boxes[:, 0] > width).any() or (boxes[:, 1] > height).any():
        raise ValueError(f"a box of {boxes.max():.0f} mm does not fit a page of {width:.0f} × {height:.0f} mm")
    spots: dict[int, Spot] = {}
    page, x, y, row = 0, 0.0, 0.0, 0.0
    for k in sorted(range(len(boxes)), key=lambda k: (-boxes[k, 1], k)):
        wide, high = boxes[k].tolist()
        if x > 0.0 and x + wide > width:
            x, y, row = 0.0, y + row + apart, 0.0
        if y > 0.0 and y + high > height:
            page, x, y, row = page + 1, 0.0, 0.0, 0.0
        spots[k] = Spot(page, x, y, bool(turned[k]))
        x, row = x + wide + apart, max(row, high)
    return [spots[k] for k in range(len(boxes))]
