"""Picture, vector outline or polygon → Shape (paper §6; theory: polarity by the border, sub-pixel contour)."""

from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np
import numpy.typing as npt
import shapely

from riot.errors import SilhouetteError
from riot.geometry import polyline, svg_outline
from riot.geometry.contour import find_object, trace_contour
from riot.geometry.crossings import TangleError, refuse_tangles
from riot.geometry.picture import Picture, decode
from riot.geometry.shape import Shape
from riot.parameters import ShapeParameters
from riot.types import BoolArray, FloatArray
from riot.units import L_C

_REPAIRED = 0.95
"""A self-crossing outline is accepted when one simple part holds at least this share of its region."""

_THIN = 1e-9
"""A polygon with less area than this share of its bounding square is degenerate."""

_LONGEST = 32.0
"""So is one with more perimeter than this, in units of ``L_c`` at unit area: its S1 is 0, and its points thousands."""

_MOST_POINTS = 50_000
"""An outline with more points than this is refused: what follows takes time that may grow with their square."""

_SCALES = (1e-100, 1e100)
"""Coordinates or grey values beyond these overflow when squared; none is meant in earnest."""

_DIGITS = 1e-12
"""An outline smaller than this share of its distance from the origin has lost its form to rounding."""


def read(path: str | os.PathLike[str], parameters: ShapeParameters | None = None) -> Shape:
    """Read the silhouette in a picture or SVG file, told apart by the content.

    The shape's name is the file's, without suffix. Raises `SilhouetteError` as `read_image` and `read_svg`.
    """
    return read_svg(path, parameters) if svg_outline.looks_like_svg(path) else read_image(path, parameters)


def read_image(path: str | os.PathLike[str], parameters: ShapeParameters | None = None) -> Shape:
    """Read the silhouette in a PNG, GIF, BMP, TIFF or JPEG file.

    Where the opacity varies the object is the opaque part; else Otsu's threshold parts dark from light, and
    the object is the side that holds less of the picture's border. Holes are filled, and the largest component
    is kept. ``to_source`` maps to pixels of the file, x = column, y = row, integers at pixel centres.

    Raises
    ------
    SilhouetteError
        ``unreadable``, ``not-a-picture``, ``too-large``, ``one-colour``, ``all-border``, ``too-small``,
        ``degenerate``, ``self-crossing``.
    """
    chosen = parameters or ShapeParameters()
    picture = decode(path, chosen.max_pixels)
    return _picture_shape(picture, Path(path).stem, str(path), chosen)


def read_svg(path: str | os.PathLike[str], parameters: ShapeParameters | None = None) -> Shape:
    """Read the outline of the filled geometry in an SVG file; see `riot.geometry.svg_outline.outline`.

    ``to_source`` maps to the file's user units, y downwards.

    Raises
    ------
    SilhouetteError
        ``unreadable``, ``unsupported``, ``empty``, ``degenerate``, ``self-crossing``, ``too-large``.
    """
    chosen = parameters or ShapeParameters()
    return _outline_shape(svg_outline.outline(path), Path(path).stem, str(path), chosen, y_down=True)


def mask_shape(mask: npt.ArrayLike, name: str = "", parameters: ShapeParameters | None = None) -> Shape:
    """Make a shape of a (rows, columns) array of booleans or grey values; polarity, errors as `read_image`."""
    chosen = parameters or ShapeParameters()
    where = name or "the array"
    try:
        values = np.asarray(mask)
    except ValueError as error:
        raise SilhouetteError("unreadable", f"{where}: a mask is a 2-D array; its rows differ in length") from error
    if values.ndim != 2 or values.size == 0:
        raise SilhouetteError("empty", f"{where}: a mask is a 2-D array with pixels, not {values.shape}")
    if values.dtype.kind not in "biuf" or not np.isfinite(values).all():
        raise SilhouetteError("unreadable", f"{where}: a mask holds finite numbers or booleans")
    values = values.astype(np.float64)
    if np.abs(values).max() > _SCALES[1] or 0.0 < values.max() - values.min() < _SCALES[0]:
        raise SilhouetteError(
            "unreadable", f"{where}: the grey values are beyond {_SCALES[0]} … {_SCALES[1]}; scale them"
        )
    return _picture_shape(Picture(values, False, 1), name, where, chosen)


def polygon_shape(points: npt.ArrayLike, name: str = "", parameters: ShapeParameters | None = None) -> Shape:
    """Make a shape of an (m, 2) closed polygon in either orientation, y upwards.

    The last point may repeat the first. Its vertices stay, up to ``vertex_tolerance``, with midpoints between them;
    ``feature_tolerance=0`` keeps every vertex. ``to_source`` maps to the polygon's own coordinates.

    Raises
    ------
    SilhouetteError
        ``unreadable`` (not numbers), ``degenerate`` (fewer than three places, or no area), ``self-crossing``,
        ``too-large``.
    """
    where = name or "the polygon"
    try:
        given = np.asarray(points)
        if given.dtype.kind in "cmM":
            raise TypeError(given.dtype)
        array = np.array(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise SilhouetteError("unreadable", f"{where}: a polygon is an (m, 2) array of numbers") from error
    if array.ndim != 2 or array.shape[1] != 2 or not np.isfinite(array).all():
        raise SilhouetteError("unreadable", f"{where}: a polygon is an (m, 2) array of finite numbers")
    parameters = parameters or ShapeParameters()
    return _outline_shape(array, name, where, parameters, parameters.vertex_tolerance, y_down=False)


def _picture_shape(picture: Picture, name: str, where: str, parameters: ShapeParameters) -> Shape:
    field, component = find_object(picture, where, parameters)
    contour = trace_contour(field, component, parameters.smoothing, where)
    # A value stands at the centre of its factor × factor pixels.
    contour = contour * picture.factor + (picture.factor - 1) / 2.0
    return _outline_shape(contour, name, where, parameters, y_down=True)


def _outline_shape(
    points: FloatArray,
    name: str,
    where: str,
    parameters: ShapeParameters,
    vertex_tolerance: float = math.inf,
    *,
    y_down: bool,
) -> Shape:
    """Sample one closed outline and bring it to the frame of a `Shape`."""
    if len(points) > _MOST_POINTS:
        raise SilhouetteError(
            "too-large", f"{where}: the outline has {len(points)} points, more than {_MOST_POINTS}; simplify it"
        )
    _refuse_scale(points, where)
    flip = np.array([1.0, -1.0 if y_down else 1.0])
    outline = _simple_outline(points * flip, where)
    samples, feature = _sampled(outline, where, parameters, vertex_tolerance)
    area = polyline.signed_area(samples)
    centre = polyline.centroid(samples)
    scale = math.sqrt(area)
    to_source = np.column_stack([np.diag(scale * flip), centre * flip])
    return Shape((samples - centre) / scale, feature, name, to_source)


def _refuse_scale(points: FloatArray, where: str) -> None:
    far = float(np.abs(points).max(initial=0.0))
    extent = polyline.extent(points) if far <= _SCALES[1] and len(points) else 0.0
    if far > _SCALES[1] or 0.0 < extent < _SCALES[0]:
        raise SilhouetteError(
            "degenerate", f"{where}: the coordinates are beyond {_SCALES[0]} … {_SCALES[1]} in size; scale the outline"
        )
    if 0.0 < extent < _DIGITS * far:
        raise SilhouetteError(
            "degenerate",
            f"{where}: an outline {extent:.3g} wide, {far:.3g} from the origin, has lost its form to rounding; move it",
        )


def _simple_outline(points: FloatArray, where: str) -> FloatArray:
    """A simple counter-clockwise polygon that starts at its vertex farthest from its centroid."""
    differs = points != polyline.shifted(points, -1)
    distinct = points[differs[:, 0] | differs[:, 1]]
    extent = polyline.extent(points) if len(points) else 0.0
    if len(distinct) < 3:
        raise SilhouetteError("degenerate", f"{where}: an outline needs three distinct points at least")
    if not polyline.is_simple(distinct):
        distinct = _repaired(distinct, where)
    area = polyline.signed_area(distinct)
    if abs(area) <= _THIN * extent**2:
        raise SilhouetteError("degenerate", f"{where}: the outline encloses no area")
    if area < 0.0:
        distinct = distinct[::-1]
    start = polyline.farthest(distinct, polyline.centroid(distinct))
    return polyline.shifted(distinct, start)


def _repaired(points: FloatArray, where: str) -> FloatArray:
    """The dominant part of a self-touching outline (holes that it pinches off are filled)."""
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
    return np.asarray(best.exterior.coords, dtype=np.float64)[:-1]


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
    for _ in range(4):
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
            unit = 0.999 * math.sqrt(area)  # sampling cut corners off: what was one unit is now more
        else:
            tolerance /= 4.0  # the samples pass a narrow neck on the wrong side
    raise SilhouetteError(
        "self-crossing",
        f"{where}: the outline is too fine to be sampled without crossing itself; remove slivers and narrow necks",
    )
