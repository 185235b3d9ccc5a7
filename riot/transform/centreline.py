"""Compare centre lines: how much of a shape's thin features, its legs, tails and ears, a result keeps.

IoU hardly sees a tail, which has little area. The centre line of a shape runs through every limb, however thin, so that
the share of it inside the other shape does. Their harmonic mean is the centre-line Dice (Shit et al., *clDice: a Novel
Topology-Preserving Loss Function for Tubular Structure Segmentation*, CVPR 2021).

A result on bent inputs is compared with these: that takes the bend back, and a tail that is bent aside is not lost.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from PIL import Image, ImageDraw
from skimage.morphology import skeletonize

from riot.transform.tuning import CENTRE_LINE_STEP
from riot.types import FloatArray


@dataclass(frozen=True)
class CentreLineOverlap:
    """How much of two shapes' centre lines is inside the other shape.

    Parameters
    ----------
    precision : float
        Share of the result's centre line inside the input, in [0, 1]: below 1 if the result has limbs of its own.
    recall : float
        Share of the input's centre line inside the result, in [0, 1]: below 1 if the result lacks limbs of the input.
    """

    precision: float
    recall: float

    @property
    def dice(self) -> float:
        """Harmonic mean of precision and recall (Shit et al. 2021, eq. 2); 0 if both are."""
        total = self.precision + self.recall
        return 2.0 * self.precision * self.recall / total if total > 0.0 else 0.0


def centre_line(outline: FloatArray) -> FloatArray:
    """(k, 2) points of the centre line of a closed polygon (m, 2) in a unit-area frame, one a cell it passes.

    The centre line is the skeleton of the polygon drawn on a grid of `riot.transform.tuning.CENTRE_LINE_STEP`.

    >>> bar = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 1 / 3], [0.0, 1 / 3]])
    >>> bool(np.abs(centre_line(bar)[:, 1] - 1 / 6).max() < 0.2)  # the middle, and short branches to the corners
    True
    """
    low = outline.min(axis=0) - CENTRE_LINE_STEP
    width, height = (np.ceil((outline.max(axis=0) - low) / CENTRE_LINE_STEP).astype(int) + 1).tolist()
    image = Image.new("L", (width, height))
    ImageDraw.Draw(image).polygon([(x, y) for x, y in ((outline - low) / CENTRE_LINE_STEP - 0.5).tolist()], fill=1)
    rows, columns = np.nonzero(skeletonize(np.array(image) > 0))
    line: FloatArray = low + (np.column_stack([columns, rows]) + 0.5) * CENTRE_LINE_STEP
    return line


def centre_line_overlap(outline: FloatArray, reference: FloatArray) -> CentreLineOverlap:
    """Compare the centre lines of a result's outline (m, 2) and of its input's (k, 2), in one unit-area frame.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> tail = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.48], [2.0, 0.5], [1.0, 0.52], [1.0, 1.0], [0.0, 1.0]])
    >>> lost = centre_line_overlap(square, tail)
    >>> lost.precision > 0.99, lost.recall < 0.7
    (True, True)
    """
    return CentreLineOverlap(_share(outline, reference), _share(reference, outline))


def _share(outline: FloatArray, container: FloatArray) -> float:
    """Share of the outline's centre line within another polygon, which may touch itself, or half a cell beside it."""
    points = shapely.points(centre_line(outline))
    region = shapely.make_valid(shapely.polygons(container))
    shapely.prepare(region)
    return float(shapely.dwithin(region, points, 0.5 * CENTRE_LINE_STEP).mean())
