"""Which hinge to leave open, so that the pieces of a pictured swing meet each other least (theory §9). Ours."""

from __future__ import annotations

import numpy as np
import shapely

from riot.draw.panels import sketch
from riot.transform import Transform

TIMES = np.linspace(0.0, 1.0, 11)[1:-1]
"""Where the swing is looked at; the closed ends do not depend on the open hinge."""

COARSE = 5e-3
"""Simplification of the pieces for this choice (unit-area shapes)."""


def quiet_hinge(transform: Transform) -> int:
    """The hinge whose opening gives the swing with the least overlap of pieces, summed over `TIMES`.

    A choice for pictures, not a motion plan: the overlap may not be zero. The smallest index wins a tie.
    """
    rough = sketch(transform, COARSE)
    total = [_overlap(rough, hinge) for hinge in range(len(transform))]
    return int(np.argmin(np.round(total, 6)))


def _overlap(transform: Transform, open_hinge: int) -> float:
    total = 0.0
    for t in TIMES:
        parts = [shapely.Polygon(part) for part in transform.parts(transform.pose(float(t), open_hinge))]
        # A thinned arc may cross itself; buffer(0) makes it a region again, which is enough for a choice.
        parts = [part if part.is_valid else part.buffer(0) for part in parts]
        total += float(sum(part.area for part in parts) - shapely.union_all(parts).area)
    return total
