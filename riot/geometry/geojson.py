"""Polygons in the form that geographic libraries exchange (RFC 7946 and ``__geo_interface__``), in the plane. Ours."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from riot.errors import SilhouetteError
from riot.types import FloatArray

COLLECTIONS = {"FeatureCollection": "features", "GeometryCollection": "geometries"}
"""Kinds that hold others, and where."""


@dataclass(frozen=True, eq=False)
class OuterRing:
    """The (m, 2) outer ring of a polygon, the name in its properties, and how many holes it has."""

    points: npt.ArrayLike
    name: str = ""
    holes: int = 0


def read_outer_ring(polygon: Any, where: str) -> OuterRing:
    """Read the outer ring of a polygon; holes are left out, with a warning that counts them.

    ``polygon`` is a GeoJSON mapping (a geometry or a feature) or an object with ``__geo_interface__``, such as a
    polygon of shapely or an element of a GeoSeries; of a collection or multipolygon the only polygon. What is neither
    is returned as it is. Heights are left out. ``where`` names the polygon in messages.

    Raises
    ------
    SilhouetteError
        ``empty`` (no polygon), ``several`` (more than one), ``unreadable`` (other geometry, or no GeoJSON).

    >>> read_outer_ring({"type": "Polygon", "coordinates": [[(0, 0), (4, 0), (4, 3), (0, 0)]]}, "it").points.shape
    (4, 2)
    """
    document = polygon if isinstance(polygon, Mapping) else getattr(polygon, "__geo_interface__", None)
    if document is None:
        return OuterRing(polygon)
    try:
        ring = _outer_ring(document, where)
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        if isinstance(error, SilhouetteError):
            raise
        raise SilhouetteError("unreadable", f"{where}: this is no GeoJSON of a polygon ({error!r})") from error
    if ring.holes:
        words = "a hole is" if ring.holes == 1 else f"{ring.holes} holes are"
        warnings.warn(f"{where}: {words} filled, since a shape has none", stacklevel=3)
    return ring


def polygon_feature(points: FloatArray, **properties: Any) -> dict[str, Any]:
    """A GeoJSON feature of an (m, 2) counter-clockwise outline, each point once; the ring is closed.

    >>> corner = polygon_feature(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), name="corner")
    >>> corner["geometry"]["coordinates"][0]
    [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]
    """
    ring = np.concatenate([points, points[:1]]).tolist()
    return {
        "type": "Feature",
        "properties": properties,
        "geometry": {"type": "Polygon", "coordinates": [ring]},
    }


def _outer_ring(document: Mapping[str, Any], where: str) -> OuterRing:
    kind = document["type"]
    if kind == "Feature":
        ring = _outer_ring(_only([document["geometry"]], where), where)
        return OuterRing(ring.points, str((document.get("properties") or {}).get("name") or ""), ring.holes)
    if kind in COLLECTIONS:
        return _outer_ring(_only(document[COLLECTIONS[kind]], where), where)
    rings = document.get("coordinates", ())
    if kind == "MultiPolygon":
        rings = _only(rings, where)
    elif kind == "LinearRing":
        rings = [rings]
    elif kind != "Polygon":
        raise SilhouetteError("unreadable", f"{where}: a {kind} is no polygon")
    if not rings:
        raise SilhouetteError("empty", f"{where}: the polygon is empty")
    return OuterRing(np.array([point[:2] for point in rings[0]], dtype=np.float64), holes=len(rings) - 1)


def _only(parts: Sequence[Any], where: str) -> Any:
    present = [part for part in parts if part]
    if not present:
        raise SilhouetteError("empty", f"{where}: there is no polygon in it")
    if len(present) > 1:
        raise SilhouetteError(
            "several",
            f"{where}: {len(present)} polygons are no single shape; choose one, such as that of greatest area",
        )
    return present[0]
