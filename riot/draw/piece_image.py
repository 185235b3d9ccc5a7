"""What a piece looks like if it is not of one colour: a picture in the piece's own frame. Ours."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, eq=False)
class PieceImage:
    """The picture of one piece.

    Parameters
    ----------
    pixels : (rows, columns, 3) uint8
        Its first row is the highest in the piece's frame (y up).
    box : (4,) float
        x0, y0, x1, y1 of the picture in the piece's frame, units of the unit-area shape; it holds the piece.
    """

    pixels: npt.NDArray[np.uint8]
    box: tuple[float, float, float, float]


PieceImages = Mapping[str, tuple[PieceImage, ...]]
"""An image for every piece, by side: "p" is the front of the pieces, "q" their back as it is in Q's own picture."""

NO_IMAGES: PieceImages = MappingProxyType({})
"""Every piece has its colour."""
