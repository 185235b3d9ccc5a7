"""SVG file → the outline of its filled geometry, without a raster in between (ours).

Filled elements are painted in document order, as a viewer does: each adds its region. If an element covers the whole
view (an icon on a coloured square), it is the background: an element of its colour removes its region.
Strokes, text and embedded pictures are no geometry here; a file that has nothing else raises an error that says so.
"""

from __future__ import annotations

import io
import itertools
import os
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import shapely
import svgelements

from riot.errors import SilhouetteError
from riot.geometry.crossings import TangleError, refuse_tangles
from riot.geometry.limits import PICTURE_BYTES, check_file
from riot.geometry.machine_errors import is_of_machine
from riot.geometry.svg_document import NAMESPACE, load
from riot.geometry.svg_regions import closed_rings, filled_region, fills_even_odd
from riot.types import FloatArray

_BACKGROUND_SHARE = 0.99
"""An element that covers at least this share of the view is its background. Ours."""

_SAME_COLOUR = 0.1
"""Colours whose channels differ by at most this, of 1, are the same. Ours."""

_HEAD_BYTES = 64
"""Bytes that are read to tell an SVG file from a picture. Ours."""

_NO_COLOUR = (-9.0, -9.0, -9.0)
"""The colour of a gradient or pattern: it differs from all colours."""

_FLATNESS = 1e-4
"""Greatest distance of a chord from its curve, as a share of the view's longer side. Ours: far finer than the
sampling."""

_Colour = tuple[float, float, float]


def looks_like_svg(path: str | os.PathLike[str]) -> bool:
    """Whether a file's first bytes are those of XML; its suffix does not count. False when it cannot be opened.

    Raises OSError when the machine fails (`riot.geometry.machine_errors`): otherwise a drawing would count as a
    broken picture.

    >>> from pathlib import Path
    >>> _ = Path("drawing").write_text("<svg/>")
    >>> looks_like_svg("drawing")
    True
    """
    try:
        check_file(Path(path), PICTURE_BYTES)
        with Path(path).open("rb") as file:
            head = file.read(_HEAD_BYTES)
    except (OSError, ValueError) as error:  # ValueError: too many bytes, or a path with a null character
        if is_of_machine(error):
            raise
        return False
    text = head.replace(b"\0", b"").lstrip(b"\xef\xbb\xbf\xff\xfe \t\r\n")  # byte-order marks, UTF-16
    return text.startswith((b"<?xml", b"<svg", b"<!--", b"<!DOCTYPE"))


_BROKEN = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError, RecursionError)
"""Errors that the SVG parser raises on broken content."""


def outline(path: str | os.PathLike[str]) -> FloatArray:
    """Outer boundary, (m, 2), of the largest region that an SVG file fills, in its user units, y downwards.

    Holes are dropped. Orientation and start vertex are arbitrary.

    Raises
    ------
    SilhouetteError
        ``unreadable`` (missing, not XML, no SVG), ``unsupported`` (declarations, references to other files,
        masks), ``too-large``, ``empty`` (nothing filled).

    >>> from pathlib import Path
    >>> _ = Path("square.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0H9V9H0z"/></svg>')
    >>> len(outline("square.svg"))
    4
    """
    where = str(path)
    tree = load(path)
    view = _view_of(tree)
    try:
        document: Any = svgelements.SVG.parse(io.BytesIO(ElementTree.tostring(tree)), reify=True)
        elements = [element for element in document.elements() if isinstance(element, svgelements.Shape)]
        view = view or _bounds(elements)
        visible = [element for element in elements if _visible(element)]
        flatness = _FLATNESS * max(view[2] - view[0], view[3] - view[1])
        rings = closed_rings(visible, flatness)
        refuse_tangles(list(itertools.chain.from_iterable(rings)))
        painted = [
            (filled_region(of, fills_even_odd(element)), _fill(element))
            for element, of in zip(visible, rings, strict=True)
            if of
        ]
        painted = [(region, fill) for region, fill in painted if not region.is_empty]
        region = _object(painted, shapely.box(*view))
    except TangleError as error:
        raise SilhouetteError("too-large", f"{where}: {error}; simplify the drawing, or export it as PNG") from error
    except (*_BROKEN, shapely.errors.ShapelyError) as error:
        raise SilhouetteError("unreadable", f"{where}: broken geometry ({error}); save the file again") from error
    polygons = [shape for shape in shapely.get_parts(region) if shape.geom_type == "Polygon" and shape.area > 0.0]
    if not polygons:
        raise SilhouetteError(
            "empty", f"{where}: nothing is filled; turn strokes and text into paths, or export the drawing as PNG"
        )
    largest = max(polygons, key=lambda polygon: float(shapely.Polygon(polygon.exterior).area))
    return np.asarray(largest.exterior.coords, dtype=np.float64)[:-1]


def _object(painted: list[tuple[Any, _Colour]], view: Any) -> Any:
    """The region of the object: what is painted, less what has the colour of the background."""
    background: _Colour | None = None
    region: Any = shapely.Polygon()
    waiting: list[Any] = []  # unions are cheaper in bulk, and only a background's colour has to keep the order
    for patch, colour in painted:
        if patch.intersection(view).area >= _BACKGROUND_SHARE * view.area and (
            background is None or _same(colour, background)
        ):
            background, region, waiting = colour, shapely.Polygon(), []
        elif background is not None and _same(colour, background):
            region, waiting = shapely.union_all([region, *waiting]).difference(patch), []
        else:
            waiting.append(patch)
    region = shapely.union_all([region, *waiting])
    # A square that fills the view on purpose has nothing painted over it.
    if region.is_empty and background is not None:
        return shapely.union_all([patch for patch, _ in painted])
    return region


def _view_of(tree: ElementTree.Element) -> tuple[float, float, float, float] | None:
    """The view box in the coordinates that `svgelements` gives: the box is laid onto (0, 0)–(width, height)."""
    root: Any = svgelements.SVG.parse(
        io.BytesIO(ElementTree.tostring(ElementTree.Element(f"{{{NAMESPACE}}}svg", tree.attrib)))
    )
    declared = root.viewbox is not None or ("width" in tree.attrib and "height" in tree.attrib)
    if not declared or not root.width or not root.height:
        return None
    return 0.0, 0.0, float(root.width), float(root.height)


def _bounds(elements: list[Any]) -> tuple[float, float, float, float]:
    boxes = np.array([box for box in (element.bbox() for element in elements) if box is not None])
    if not len(boxes):
        return 0.0, 0.0, 1.0, 1.0
    (x0, y0), (x1, y1) = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    return float(x0), float(y0), float(x1), float(y1)


def _visible(element: Any) -> bool:
    values = element.values
    if str(values.get("visibility", "visible")).strip() in ("hidden", "collapse"):
        return False
    if str(values.get("fill", "black")).strip() in ("none", "transparent"):
        return False
    if element.fill is not None and element.fill.value is not None and element.fill.alpha == 0:
        return False
    return all(_number(values.get(key)) > 0.0 for key in ("opacity", "fill-opacity"))


def _number(value: object) -> float:
    text = str(1.0 if value is None else value).strip()
    return float(text[:-1]) / 100.0 if text.endswith("%") else float(text)


def _fill(element: Any) -> _Colour:
    colour = element.fill
    if colour is None or colour.value is None:
        return _NO_COLOUR
    return colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0


def _same(first: _Colour, second: _Colour) -> bool:
    return max(abs(a - b) for a, b in zip(first, second, strict=True)) <= _SAME_COLOUR
