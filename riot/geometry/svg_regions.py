"""Closed rings of a drawing → the regions that they fill, and the object among these regions (ours)."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from riot.geometry.crossings import TangleError
from riot.types import FloatArray

MAX_POINTS = 200_000
"""Greatest number of vertices of a drawing with flattened curves. Ours: it bounds the time."""

_MAX_WINDINGS = 200_000_000
"""Greatest number of faces times vertices of an element. Ours: it bounds the time."""

_WINDINGS_AT_ONCE = 2_000_000
"""Faces times vertices that are in memory together. Ours: it bounds the memory."""

_BACKGROUND_SHARE = 0.99
"""An element that covers at least this share of the page is its background. Ours."""

_SAME_COLOUR = 25
"""Colours whose channels differ by at most this, of 255, are the same. Ours."""

Colour = tuple[int, ...]
"""Red, green, blue, 0 … 255."""


def object_region(painted: list[tuple[Any, Colour]], page: Any) -> Any:
    """The region of the object among what is painted in this order: all of it, less what has the background's colour.

    What covers the whole ``page`` (an icon on a coloured square) is the background. The result is cut to the page.
    """
    background: Colour | None = None
    region: Any = shapely.Polygon()
    waiting: list[Any] = []  # unions are cheaper in bulk, and only a background's colour has to keep the order
    for patch, colour in painted:
        if patch.intersection(page).area >= _BACKGROUND_SHARE * page.area and (
            background is None or _same(colour, background)
        ):
            background, region, waiting = colour, shapely.Polygon(), []
        elif background is not None and _same(colour, background):
            region, waiting = shapely.union_all([region, *waiting]).difference(patch), []
        else:
            waiting.append(patch)
    region = shapely.union_all([region, *waiting])
    # A square that fills the page on purpose has nothing painted over it.
    if region.is_empty and background is not None:
        region = shapely.union_all([patch for patch, _ in painted])
    return region if page.contains(region) else region.intersection(page)


def _same(first: Colour, second: Colour) -> bool:
    return max(abs(a - b) for a, b in zip(first, second, strict=True)) <= _SAME_COLOUR


def filled_region(rings: list[FloatArray], odd: bool) -> Any:
    """The region that an element's rings fill, by the rule "evenodd" or "nonzero"."""
    if len(rings) == 1:
        polygon = shapely.Polygon(rings[0])
        if polygon.is_valid:
            return polygon
    lines = shapely.union_all([shapely.LineString(np.concatenate([ring, ring[:1]])) for ring in rings])
    faces = list(shapely.get_parts(shapely.polygonize(shapely.get_parts(lines))))
    if not faces:
        return shapely.Polygon()
    inner = shapely.get_coordinates(shapely.point_on_surface(faces))
    if len(inner) * sum(map(len, rings)) > _MAX_WINDINGS:
        raise TangleError(f"one element has {len(inner)} faces")
    turns = sum(_winding(ring, inner) for ring in rings)
    return shapely.union_all([face for face, n in zip(faces, turns, strict=True) if (n % 2 if odd else n)])


def _winding(ring: FloatArray, points: FloatArray) -> Any:
    """How often a closed ring, (m, 2), winds around each of (k, 2) points that are not on it: (k,) int64."""
    step = max(1, _WINDINGS_AT_ONCE // len(ring))
    return np.concatenate([_turns(ring, points[start : start + step]) for start in range(0, len(points), step)])


def _turns(ring: FloatArray, points: FloatArray) -> Any:
    x, y = points[:, 0, None], points[:, 1, None]
    x0, y0 = ring[:, 0], ring[:, 1]
    x1, y1 = np.roll(x0, -1), np.roll(y0, -1)
    side = (x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)
    up = (y0 <= y) & (y1 > y) & (side > 0.0)
    down = (y0 > y) & (y1 <= y) & (side < 0.0)
    return up.sum(axis=1) - down.sum(axis=1)
