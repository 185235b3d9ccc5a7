"""What a laser engraves on a part: its number and, over it, an arrow to the top of the first shape. Ours."""

from __future__ import annotations

import math

import shapely
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath
from shapely import affinity

MARK_MM = 6.0
"""mm: greatest height of a numeral; smaller where the part is narrow."""

MARK_SHARE = 0.8
"""Share of the widest circle within the part that the marks fill at most."""

_POINTS = 100.0
"""Size at which letters are made: their curves are split finely enough for the laser then."""

_ARROW, _SPACE = 0.55, 0.25
"""Height of the arrow, and of what is free under it, in heights of a numeral."""


def letters(words: str, height_mm: float) -> shapely.Geometry:
    """Words as regions, capitals and numerals ``height_mm`` high, from the origin to the right.

    >>> letters("1", 5.0).bounds[3].__round__(6)
    5.0
    """
    region = shapely.MultiPolygon()
    path = TextPath((0.0, 0.0), words, size=_POINTS, prop=FontProperties(family="DejaVu Sans", weight="bold"))
    for ring in path.to_polygons():
        region = region.symmetric_difference(shapely.Polygon(ring))  # holes of letters are rings within rings
    capital = TextPath((0.0, 0.0), "1", size=_POINTS, prop=FontProperties(family="DejaVu Sans", weight="bold"))
    scale = height_mm / float(capital.get_extents().height)
    return affinity.scale(region, scale, scale, origin=(0.0, 0.0))


def marks(words: str, region: shapely.Polygon, up: float) -> shapely.Geometry:
    """``words`` and an arrow over them within a region, in mm; ``up`` is the direction of the arrow, radians."""
    text = letters(words, 1.0)
    x0, _, x1, _ = text.bounds
    middle, low = 0.5 * (x0 + x1), 1.0 + _SPACE
    arrow = shapely.Polygon([(middle - 0.4, low), (middle + 0.4, low), (middle, low + _ARROW)])
    both = affinity.translate(shapely.union(text, arrow), -middle, -0.5 * (low + _ARROW))
    circle = shapely.maximum_inscribed_circle(region)
    reach = math.hypot(0.5 * (x1 - x0), 0.5 * (low + _ARROW))
    size = min(MARK_MM, MARK_SHARE * float(circle.length) / reach)
    turned = affinity.rotate(affinity.scale(both, size, size, origin=(0.0, 0.0)), up - 0.5 * math.pi, (0.0, 0.0), True)
    x, y = circle.coords[0]
    return affinity.translate(turned, x, y)
