"""Surprise: how much two shapes differ, in their descriptors and in how long they are. Ours."""

from __future__ import annotations

import numpy as np

from riot.types import FloatArray


def elongation(points: FloatArray) -> float:
    """How long a shape is: 1 − its least over its greatest standard deviation along an axis; 0 for a disk or a square.

    ``points`` (m, 2) run counter-clockwise around the centroid at the origin, as a shape's do.

    >>> from riot import Shape
    >>> round(elongation(Shape.from_polygon([(0, 0), (4, 0), (4, 1), (0, 1)]).points), 3)
    0.75
    """
    following = np.roll(points, -1, axis=0)
    cross = points[:, 0] * following[:, 1] - points[:, 1] * following[:, 0]
    # Second moments of the triangles from the origin to each edge.
    sums = points + following
    xx, yy = ((np.square(sums) + np.square(points) + np.square(following)) * cross[:, None]).sum(axis=0) / 24
    xy = (
        (sums[:, 0] * sums[:, 1] + points[:, 0] * points[:, 1] + following[:, 0] * following[:, 1]) * cross
    ).sum() / 24
    middle, apart = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    return float(1.0 - np.sqrt(max(middle - apart, 0.0) / (middle + apart)))


def surprise(distance: FloatArray, elongation_p: FloatArray, elongation_q: FloatArray) -> FloatArray:
    """The surprise of pairs: 0 for two of the same shape, about 1 for a disk and a rod.

    ``distance`` is that of `riot.scores.likeness.distance`; both it and the difference of elongations count.

    >>> surprise(np.array([0.3]), np.array([0.1]), np.array([0.5])).tolist()
    [0.5]
    """
    return np.asarray(np.hypot(distance, elongation_p - elongation_q))
