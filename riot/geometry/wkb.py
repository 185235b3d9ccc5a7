"""Outlines as well-known binary, the form in which GeoParquet and spatial databases hold them. Ours."""

from __future__ import annotations

import shapely

from riot.types import FloatArray

LITTLE_ENDIAN = 1


def outline_wkb(points: FloatArray) -> bytes:
    """An (m, 2) outline, each point once, as the well-known binary of a polygon; exact to the last bit.

    >>> import shapely
    >>> round(shapely.from_wkb(outline_wkb(house.points)).area, 9)
    1.0
    """
    return bytes(shapely.to_wkb(shapely.Polygon(points), byte_order=LITTLE_ENDIAN))
