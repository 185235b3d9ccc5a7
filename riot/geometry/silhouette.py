"""Picture, vector outline or polygon → Shape (paper §6; theory: polarity by the border, sub-pixel contour)."""

from __future__ import annotations

import os
import warnings
from pathlib import Path

import numpy as np
import numpy.typing as npt

from riot.errors import SilhouetteError
from riot.geometry import svg_outline
from riot.geometry.contour import find_object, trace_contour
from riot.geometry.outline import SCALES, outline_shape
from riot.geometry.picture import Picture, decode
from riot.geometry.shape import Shape
from riot.parameters import ShapeParameters

_TOLD_CHANGE = 0.01
"""A repair of a polygon that changes this share of its area is told. Ours: less is not seen."""


def read(path: str | os.PathLike[str], parameters: ShapeParameters | None = None) -> Shape:
    """Read the silhouette in a picture or SVG file; the content decides which it is.

    The shape's name is the file's, without suffix. Raises `SilhouetteError` as `read_image` and `read_svg`.

    >>> _ = Path("square.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0H9V9H0z"/></svg>')
    >>> round(read("square.svg").perimeter, 6)
    4.0
    """
    return read_svg(path, parameters) if svg_outline.looks_like_svg(path) else read_image(path, parameters)


def read_image(path: str | os.PathLike[str], parameters: ShapeParameters | None = None) -> Shape:
    """Read the silhouette in a PNG, GIF, BMP, TIFF, JPEG, WebP or AVIF file.

    Where the opacity tells object and page apart the object is the opaque part; otherwise Otsu's threshold separates
    dark from light, or colours from that of the border (`riot.geometry.separation`), and the object is the side with
    less of the picture's border. Holes are filled, and the largest component is kept; ``quality`` says how well that
    went. ``to_source`` maps to pixels of the upright picture, x = column, y = row, integers at pixel centres.

    Raises
    ------
    SilhouetteError
        ``unreadable``, ``not-a-picture``, ``too-large``, ``one-colour``, ``all-border``, ``too-small``,
        ``degenerate``, ``self-crossing``.

    >>> from PIL import Image
    >>> Image.fromarray(np.pad(np.full((40, 40), 255, np.uint8), 10)).save("square.png")
    >>> round(read_image("square.png").perimeter, 1)
    3.9
    """
    chosen = parameters or ShapeParameters()
    try:
        picture = decode(path, chosen.max_pixels)
    except SilhouetteError as error:
        if error.reason == "not-a-picture" and svg_outline.looks_like_svg(path):  # which `read` does not bring here
            raise SilhouetteError(error.reason, f"{path}: an SVG file, which Shape.from_svg reads") from error
        raise
    return picture_shape(picture, Path(path).stem, str(path), chosen)


def read_svg(path: str | os.PathLike[str], parameters: ShapeParameters | None = None) -> Shape:
    """Read the outline of the filled geometry in an SVG file; see `riot.geometry.svg_outline.outline`.

    ``to_source`` maps to the file's user units, y downwards.

    Raises
    ------
    SilhouetteError
        ``unreadable``, ``unsupported``, ``empty``, ``degenerate``, ``self-crossing``, ``too-large``.

    >>> _ = Path("square.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0H9V9H0z"/></svg>')
    >>> read_svg("square.svg").name
    'square'
    """
    chosen = parameters or ShapeParameters()
    try:
        outline = svg_outline.outline(path, chosen)
    except SilhouetteError as error:
        if Path(path).is_file() and not svg_outline.looks_like_svg(path):  # which `read` does not bring here
            raise SilhouetteError(error.reason, f"{path}: no SVG file; Shape.from_image reads pictures") from error
        raise
    name = Path(path).stem
    return outline_shape(outline.points, name, str(path), chosen, y_down=True, quality=outline.quality)


def mask_shape(mask: npt.ArrayLike, name: str = "", parameters: ShapeParameters | None = None) -> Shape:
    """Make a shape of a (rows, columns) array of booleans or grey values; polarity, errors as `read_image`.

    >>> disc = np.hypot(*np.mgrid[-20:21, -20:21]) < 15
    >>> round(mask_shape(disc, "disc").perimeter, 1)
    3.6
    """
    chosen = parameters or ShapeParameters()
    where = name or "the array"
    try:
        values = np.asarray(mask)
    except ValueError as error:
        raise SilhouetteError("unreadable", f"{where}: a mask is a 2-D array; its rows differ in length") from error
    if values.ndim != 2 or values.size == 0:
        raise SilhouetteError("empty", f"{where}: a mask is a 2-D array with pixels, not {values.shape}")
    if values.dtype.kind not in "biuf" or not np.isfinite(values).all():
        raise SilhouetteError("unreadable", f"{where}: a mask has finite numbers or booleans")
    values = values.astype(np.float64)
    if np.abs(values).max() > SCALES[1] or 0.0 < values.max() - values.min() < SCALES[0]:
        raise SilhouetteError(
            "unreadable", f"{where}: the grey values are beyond {SCALES[0]} … {SCALES[1]}; scale them"
        )
    return picture_shape(Picture(values, False, 1), name, where, chosen)


def polygon_shape(points: npt.ArrayLike, name: str = "", parameters: ShapeParameters | None = None) -> Shape:
    """Make a shape of an (m, 2) closed polygon in either orientation, y upwards.

    It may be (m, 1, 2), as OpenCV has contours, or (m, 3), whose heights are left out. A polygon that crosses itself is
    repaired, with a warning if that changes more than a hundredth of the area.

    The last point may repeat the first. Its vertices stay, up to ``vertex_tolerance``, with midpoints between them;
    ``feature_tolerance=0`` keeps every vertex. ``to_source`` maps to the polygon's own coordinates.

    Raises
    ------
    SilhouetteError
        ``unreadable`` (not numbers), ``degenerate`` (fewer than three distinct points, or no area), ``self-crossing``,
        ``too-large``.

    >>> polygon_shape([(0, 0), (4, 0), (4, 3)], "triangle").perimeter.__round__(3)
    4.899
    """
    where = name or "the polygon"
    try:
        given = np.asarray(points)
        if given.dtype.kind in "cmM":
            raise TypeError(given.dtype)
        array = np.array(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise SilhouetteError("unreadable", f"{where}: a polygon is an (m, 2) array of numbers") from error
    if array.ndim == 3 and array.shape[1:] == (1, 2):
        array = array[:, 0]
    if array.ndim == 2 and array.shape[1] == 3:
        array = array[:, :2]
    if array.ndim != 2 or array.shape[1] != 2 or not np.isfinite(array).all():
        raise SilhouetteError("unreadable", f"{where}: a polygon is an (m, 2) array of finite numbers")
    parameters = parameters or ShapeParameters()
    shape = outline_shape(array, name, where, parameters, parameters.vertex_tolerance, y_down=False)
    if shape.quality is not None and shape.quality.changed >= _TOLD_CHANGE:
        message = f"{where}: the outline crosses itself, and its repair changed {shape.quality.changed:.0%} of the area"
        warnings.warn(message, stacklevel=2)
    return shape


def picture_shape(picture: Picture, name: str, where: str, parameters: ShapeParameters) -> Shape:
    """Make a shape of the object in a decoded picture, which errors call ``where``; errors as `read_image`.

    >>> disc = np.where(np.hypot(*np.mgrid[-20:21, -20:21]) < 15, 255.0, 0.0)
    >>> picture_shape(Picture(disc, False, 1), "disc", "the picture", ShapeParameters()).name
    'disc'
    """
    field, component, quality = find_object(picture, where, parameters)
    contour = trace_contour(field, component, parameters.smoothing, where)
    # A value stands at the centre of its factor × factor pixels.
    contour = contour * picture.factor + (picture.factor - 1) / 2.0
    return outline_shape(contour, name, where, parameters, y_down=True, quality=quality)
