"""Which limbs of an input a result lacks, and where they were. Ours."""

from __future__ import annotations

from dataclasses import dataclass

import shapely

from riot.transform.centreline import centre_line
from riot.transform.tuning import CENTRE_LINE_STEP, LEAST_TIP
from riot.types import FloatArray


@dataclass(frozen=True)
class LostLimb:
    """A limb of an input, or its tip, that a result lacks: its middle, and its share of the input's centre line."""

    x: float
    y: float
    share: float


def lost_limbs(outline: FloatArray, reference: FloatArray) -> list[LostLimb]:
    """Limbs of an input's outline (k, 2) that a result's (m, 2) lacks, the longest first.

    A limb, or the tip of one, is a connected section of the input's centre line outside the result; those shorter than
    `riot.transform.tuning.LEAST_TIP` of the whole centre line do not count. Ours.

    >>> import numpy as np
    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> tail = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.48], [2.0, 0.5], [1.0, 0.52], [1.0, 1.0], [0.0, 1.0]])
    >>> [round(limb.x, 1) for limb in lost_limbs(square, tail)]
    [1.5]
    """
    line = centre_line(reference)
    region = shapely.make_valid(shapely.polygons(outline))
    shapely.prepare(region)
    outside = line[~shapely.dwithin(region, shapely.points(line), 0.5 * CENTRE_LINE_STEP)]
    # Cells of the grid that touch, by a corner at least, are one section.
    parts = shapely.union_all(shapely.buffer(shapely.points(outside), 0.75 * CENTRE_LINE_STEP, quad_segs=1))
    limbs = []
    for part in shapely.get_parts(parts):
        section = outside[shapely.intersects_xy(part, outside)]
        if len(section) >= LEAST_TIP * len(line):
            x, y = section.mean(axis=0).tolist()
            limbs.append(LostLimb(x, y, len(section) / len(line)))
    return sorted(limbs, key=lambda limb: -limb.share)
