"""Filled elements of an SVG drawing → closed rings with curves flattened, and the regions that they fill (ours)."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import shapely
import svgelements

from riot.geometry.crossings import TangleError
from riot.types import FloatArray

_MAX_POINTS = 200_000
"""Greatest number of vertices of a drawing with flattened curves. Ours: it bounds the time."""

_MAX_WINDINGS = 200_000_000
"""Greatest number of faces times vertices of an element. Ours: it bounds the time."""

_WINDINGS_AT_ONCE = 2_000_000
"""Faces times vertices that are in memory together. Ours: it bounds the memory."""

_MAX_CHORDS = 1000
"""Greatest number of chords of a curve. Ours: enough for a full turn at the flatness of an outline."""


def closed_rings(elements: list[Any], flatness: float) -> list[list[FloatArray]]:
    """The closed rings, (m, 2) each, of each element, with curves flattened; rings have three vertices or more.

    Raises `riot.geometry.crossings.TangleError` for a drawing of too many vertices.
    """
    element_rings: list[list[FloatArray]] = []
    total = 0
    for element in elements:
        path = svgelements.Path(element)
        path.approximate_arcs_with_cubics()
        rings: list[FloatArray] = []
        for subpath in path.as_subpaths():
            ring = _ring(subpath, flatness, _MAX_POINTS - total)
            total += len(ring)
            if len(ring) >= 3:
                rings.append(ring)
        element_rings.append(rings)
    return element_rings


def fills_even_odd(element: Any) -> bool:
    """Whether an element is filled by the even–odd rule."""
    return str(element.values.get("fill-rule", "nonzero")).strip() == "evenodd"


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


def _ring(subpath: Any, flatness: float, allowed: int) -> FloatArray:
    """Vertices, (m, 2), of a subpath with curves flattened; `TangleError` when they are more than ``allowed``."""
    pieces: list[FloatArray] = []
    for segment in subpath:
        if segment.end is None:
            continue
        allowed -= len(pieces[-1]) if pieces else 0
        if allowed <= 0:
            raise TangleError(f"its curves have more than {_MAX_POINTS} points")
        controls = [segment.start] if segment.start is not None else []
        for name in ("control", "control1", "control2"):
            point = getattr(segment, name, None)
            if point is not None:
                controls.append(point)
        corners = np.array([[p.x, p.y] for p in (*controls, segment.end)], dtype=np.float64)
        pieces.append(
            corners[-1:] if len(corners) < 3 or isinstance(segment, svgelements.Move) else _flat(corners, flatness)
        )
    if not pieces:
        return np.empty((0, 2))
    ring = np.concatenate(pieces)
    if not np.isfinite(ring).all():
        raise ValueError("a coordinate is not finite")
    return np.asarray(ring[(ring != np.roll(ring, 1, axis=0)).any(axis=1)], dtype=np.float64)


def _flat(controls: FloatArray, flatness: float) -> FloatArray:
    """Points, without the first, on a quadratic or cubic Bézier curve whose chords stay within ``flatness``."""
    degree = len(controls) - 1
    bend = float(np.linalg.norm(np.diff(controls, n=2, axis=0), axis=1).max()) * degree * (degree - 1)
    steps = min(_MAX_CHORDS, max(1, math.ceil(math.sqrt(bend / (8.0 * flatness)))))
    t = (np.arange(1, steps + 1) / steps)[:, None]
    level = [np.broadcast_to(c, (steps, 2)) for c in controls]
    while len(level) > 1:  # de Casteljau
        level = [(1.0 - t) * a + t * b for a, b in itertools.pairwise(level)]
    return np.asarray(level[0], dtype=np.float64)
