"""Convexity of one shape: how much of its convex hull it fills, and how many concavities it has. Ours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull

from riot.geometry.shape import Shape
from riot.parameters import ConvexityParameters
from riot.types import FloatArray
from riot.units import D_C


@dataclass(frozen=True)
class Convexity:
    """How convex a shape is.

    Parameters
    ----------
    solidity : float
        Area of the shape over that of its convex hull, in (0, 1]; 1 for a convex shape.
    concavities : int
        Parts of the hull outside of the shape that reach deeper than ``ConvexityParameters.depth``.
    """

    solidity: float
    concavities: int


def convexity(shape: Shape, parameters: ConvexityParameters | None = None) -> Convexity:
    """Compare a shape with its convex hull. Ours.

    >>> from riot import Shape
    >>> arrow = Shape.from_polygon([(0, 0), (2, 1), (0, 2), (1, 1)])
    >>> result = convexity(arrow)
    >>> round(result.solidity, 3), result.concavities
    (0.5, 1)
    """
    parameters = parameters or ConvexityParameters()
    hull = ConvexHull(shape.points)
    return Convexity(1.0 / float(hull.volume), int((_depths(shape, hull) > parameters.depth * D_C).sum()))


def _depths(shape: Shape, hull: ConvexHull) -> FloatArray:
    """(edges of the hull,) how far the boundary between the ends of each goes away from it."""
    corners = np.sort(hull.vertices)  # along the boundary, which passes them in the hull's order
    depths = np.zeros(len(corners))
    for number, (first, last) in enumerate(zip(corners, np.roll(corners, -1), strict=True)):
        between = shape.points[np.arange(first, last + len(shape.points) * (last <= first)) % len(shape.points)]
        edge = shape.points[last] - shape.points[first]
        offsets = between - shape.points[first]
        depths[number] = (edge[0] * offsets[:, 1] - edge[1] * offsets[:, 0]).max() / np.hypot(*edge)
    return depths
