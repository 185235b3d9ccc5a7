"""Regions that are painted on a shape, as a brush paints and erases them; in the frame of the input."""

from __future__ import annotations

import numpy as np
import shapely

from riot.types import FloatArray
from studio.messages import flat_of, points_of
from studio.session.state import StiffRegion

DIGITS = 9
"""Decimals of pins and regions that are kept: a millionth of a pixel."""

STROKE_TOLERANCE = 0.01
"""Douglas–Peucker tolerance of a painted region, in the unit-area frame."""

LEAST_AREA = 1e-4
"""What is left of a region and smaller is erased, too."""


def painted(stroke: FloatArray, radius: float, factor: float) -> StiffRegion:
    """What a brush paints along a stroke (k, 2).

    >>> painted(np.array([[0.0, 0.0], [1.0, 0.0]]), 0.1, 20.0).factor
    20.0
    """
    return _region(_brushed(stroke, radius), factor)


def erased(regions: tuple[StiffRegion, ...], stroke: FloatArray, radius: float) -> tuple[StiffRegion, ...]:
    """What is left of regions where a brush erases along a stroke (k, 2); one may become several, or none.

    >>> region = painted(np.array([[0.0, 0.0], [1.0, 0.0]]), 0.1, 20.0)
    >>> len(erased((region,), np.array([[0.5, -1.0], [0.5, 1.0]]), 0.1))
    2
    """
    brushed = _brushed(stroke, radius)
    left = []
    for region in regions:
        outline = shapely.Polygon(points_of(region.polygon))
        if not outline.intersects(brushed):
            left.append(region)
            continue
        left += [_region(part, region.factor) for part in _without_holes(outline.buffer(0.0).difference(brushed))]
    return tuple(left)


def _brushed(stroke: FloatArray, radius: float) -> shapely.Polygon:
    line = shapely.Point(stroke[0]) if len(stroke) == 1 else shapely.LineString(stroke)
    return line.buffer(radius).simplify(STROKE_TOLERANCE)


def _without_holes(area: shapely.Geometry) -> list[shapely.Polygon]:
    """Polygons of an area that have no hole: those that have are cut upright through it."""
    whole = list[shapely.Polygon]()
    for part in shapely.get_parts(area).tolist():
        if part.area < LEAST_AREA:
            continue
        if not part.interiors:
            whole.append(part)
            continue
        left, low, right, high = part.bounds
        middle = part.interiors[0].centroid.x
        for half in (shapely.box(left, low, middle, high), shapely.box(middle, low, right, high)):
            whole += _without_holes(part.intersection(half))
    return whole


def _region(outline: shapely.Polygon, factor: float) -> StiffRegion:
    return StiffRegion(tuple(flat_of(np.asarray(shapely.get_coordinates(outline.exterior)[:-1]), DIGITS)), factor)
