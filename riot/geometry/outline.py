"""Closed outline → Shape: simple, counter-clockwise, sampled, in the unit-area frame (paper §6; repair and limits
ours)."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import shapely

from riot.errors import SilhouetteError
from riot.geometry import polyline
from riot.geometry.crossings import TangleError, refuse_tangles
from riot.geometry.quality import ReadingQuality
from riot.geometry.shape import Shape
from riot.parameters import ShapeParameters
from riot.types import BoolArray, FloatArray
from riot.units import L_C

_REPAIRED = 0.95
"""A self-crossing outline is accepted if one simple region has at least this share of its area. Ours."""

_THIN = 1e-9
"""A polygon with less area than this share of its bounding square is degenerate. Ours."""

_ROUNDING = 1e-9
"""Share of the area that a repair may change by rounding."""

_LONGEST = 32.0
"""A longer outline, in ``L_c`` at unit area, is degenerate. Ours: its S1 is 0, and it has thousands of points."""

_MOST_POINTS = 50_000
"""An outline with more points is refused. Ours: the time of later steps may grow with the square of their number."""

SCALES = (1e-100, 1e100)
"""Least and greatest size of coordinates and grey values. Ours: beyond them squares overflow."""

_DIGITS = 1e-12
"""An outline smaller than this share of its distance from the origin is refused. Ours: rounding has changed its
form."""

_SAMPLING_TRIES = 4
"""How often the sampling is repeated with a smaller unit or tolerance. Ours."""

_SMALLER_UNIT, _FINER = 0.999, 4.0
"""Factor of the unit of length, and divisor of the tolerance, at each repetition. Ours."""


def outline_shape(
    points: FloatArray,
    name: str,
    where: str,
    parameters: ShapeParameters,
    vertex_tolerance: float = math.inf,
    *,
    y_down: bool,
    quality: ReadingQuality | None = None,
) -> Shape:
    """Sample a closed outline, (m, 2) in either orientation, and bring it to the frame of a `Shape`.

    ``where`` names the outline in errors. Vertices stay up to ``vertex_tolerance``, in units of ``L_c``. ``y_down``:
    the outline has the y axis of pictures. ``quality`` is what is known of it from before; its roughness, and what a
    repair changed, are added.

    Raises
    ------
    SilhouetteError
        ``degenerate``, ``self-crossing``, ``too-large``.

    >>> square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    >>> outline_shape(square, "square", "the square", ShapeParameters(), y_down=False).to_source[0]
    array([2., 0., 1.])
    """
    if len(points) > _MOST_POINTS:
        raise SilhouetteError(
            "too-large", f"{where}: the outline has {len(points)} points, more than {_MOST_POINTS}; simplify it"
        )
    _refuse_scale(points, where)
    flip = np.array([1.0, -1.0 if y_down else 1.0])
    outline, changed = _simple_outline(points * flip, where)
    samples, feature = _sampled(outline, where, parameters, vertex_tolerance)
    corners = float(polyline.edge_lengths(samples[feature]).sum())
    roughness = float(polyline.edge_lengths(outline).sum()) / corners - 1.0
    known = replace(quality or ReadingQuality(), roughness=roughness, changed=changed)
    area = polyline.signed_area(samples)
    centre = polyline.centroid(samples)
    scale = math.sqrt(area)
    to_source = np.column_stack([np.diag(scale * flip), centre * flip])
    return Shape((samples - centre) / scale, feature, name, to_source, known)


def _refuse_scale(points: FloatArray, where: str) -> None:
    far = float(np.abs(points).max(initial=0.0))
    extent = polyline.extent(points) if far <= SCALES[1] and len(points) else 0.0
    if far > SCALES[1] or 0.0 < extent < SCALES[0]:
        raise SilhouetteError(
            "degenerate", f"{where}: the coordinates are beyond {SCALES[0]} … {SCALES[1]} in size; scale the outline"
        )
    if 0.0 < extent < _DIGITS * far:
        raise SilhouetteError(
            "degenerate",
            f"{where}: an outline {extent:.3g} wide, {far:.3g} from the origin, has lost its form to rounding; move it",
        )


def _simple_outline(points: FloatArray, where: str) -> tuple[FloatArray, float]:
    """A simple counter-clockwise polygon that starts at its vertex farthest from its centroid, and the share of the
    area that its repair changed."""
    differs = points != polyline.shifted(points, -1)
    distinct = points[differs[:, 0] | differs[:, 1]]
    extent = polyline.extent(points) if len(points) else 0.0
    if len(distinct) < 3:
        raise SilhouetteError("degenerate", f"{where}: an outline needs three distinct points at least")
    changed = 0.0
    if not polyline.is_simple(distinct):
        distinct, changed = _repaired(distinct, where)
    area = polyline.signed_area(distinct)
    if abs(area) <= _THIN * extent**2:
        raise SilhouetteError("degenerate", f"{where}: the outline encloses no area")
    if area < 0.0:
        distinct = distinct[::-1]
    start = polyline.farthest(distinct, polyline.centroid(distinct))
    return polyline.shifted(distinct, start), changed


def _repaired(points: FloatArray, where: str) -> tuple[FloatArray, float]:
    """The dominant region of a self-touching outline; holes that it pinches off are filled.

    Also the area that is filled or dropped, as a share of the area that is inside by the even-odd rule.
    """
    try:
        refuse_tangles([points])
    except TangleError as error:
        raise SilhouetteError("self-crossing", f"{where}: {error}; give the boundary of one region") from error
    components = shapely.get_parts(shapely.make_valid(shapely.Polygon(points)))
    regions = [
        shapely.Polygon(component.exterior)
        for component in components
        if component.geom_type == "Polygon" and component.area > 0.0
    ]
    regions += [
        shapely.Polygon(piece.exterior)
        for component in components
        if component.geom_type == "MultiPolygon"
        for piece in component.geoms
    ]
    if not regions:
        raise SilhouetteError("degenerate", f"{where}: the outline encloses no area")
    best = max(regions, key=lambda region: float(region.area))
    if best.area < _REPAIRED * sum(region.area for region in regions) or not best.is_valid:
        raise SilhouetteError("self-crossing", f"{where}: the outline crosses itself; give the boundary of one region")
    enclosed = sum(float(component.area) for component in components if component.area > 0.0)
    within = sum(float(component.intersection(best).area) for component in components if component.area > 0.0)
    changed = (float(best.area) - within + enclosed - within) / enclosed
    # A repair that moves rounding only changes nothing.
    changed = changed if changed > _ROUNDING else 0.0
    return np.asarray(best.exterior.coords, dtype=np.float64)[:-1], changed


def _sampled(
    outline: FloatArray, where: str, parameters: ShapeParameters, vertex_tolerance: float
) -> tuple[FloatArray, BoolArray]:
    """Feature points and midpoints between them, closer than ``L_c / spacing`` at the samples' own scale.

    Vertices without which the outline would be off by ``vertex_tolerance``, in units of ``L_c``, are among them.
    """
    unit = math.sqrt(polyline.signed_area(outline))
    length = float(polyline.edge_lengths(outline).sum()) / (L_C * unit)
    if length > _LONGEST:
        raise SilhouetteError(
            "degenerate",
            f"{where}: the outline is {length:.0f} times as long as that of a disc of the same area, more than "
            f"{_LONGEST:.0f}; the object is too thin, or its outline too ragged, for a dissection",
        )
    tolerance = parameters.feature_tolerance
    for _ in range(_SAMPLING_TRIES):
        main = polyline.simplify(outline, tolerance * L_C * unit)
        kept = main
        if vertex_tolerance < tolerance:
            kept = np.union1d(main, polyline.simplify(outline, vertex_tolerance * L_C * unit))
        samples, feature = polyline.insert_midpoints(outline, kept, L_C / parameters.spacing * unit)
        feature[np.flatnonzero(feature)[~np.isin(kept, main)]] = False
        area = polyline.signed_area(samples)
        if len(samples) >= 3 and area > 0.0 and polyline.is_simple(samples):
            if polyline.edge_lengths(samples).max() < L_C / parameters.spacing * math.sqrt(area):
                return samples, feature
            unit = _SMALLER_UNIT * math.sqrt(area)  # sampling cuts corners off, so that the unit of length shrinks
        else:
            tolerance /= _FINER  # the samples pass a narrow neck on the wrong side
    raise SilhouetteError(
        "self-crossing",
        f"{where}: the outline is too fine to be sampled without crossing itself; remove slivers and narrow necks",
    )
