"""SVG file → the outline of its filled geometry, without a raster in between (ours).

Filled elements are painted in document order, as a viewer would: each adds its region. If one covers the whole
view (an icon on a coloured square), it is the background: what has its colour takes away instead.
Strokes, text and embedded pictures are no geometry here, and files that need them are told so.
"""

from __future__ import annotations

import io
import itertools
import math
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
from riot.types import FloatArray

_FLATNESS = 1e-4
"""Curves are replaced by chords within this share of the view's longer side."""

_WHOLE = 0.99
"""An element that covers this share of the view, at least, is its background."""

_SAME_COLOUR = 0.1
"""Colours nearer than this share of black-to-white are the same."""

_MAX_POINTS = 200_000
"""Vertices of a drawing once its curves are flattened."""

_MAX_TURNS = 200_000_000
"""Faces times vertices of one element whose windings are counted."""

_AT_ONCE = 2_000_000
"""Of these, so many are held at a time."""

_Colour = tuple[float, float, float]


def looks_like_svg(path: str | os.PathLike[str]) -> bool:
    """Whether a file's first bytes are those of XML; its suffix does not count. False when it cannot be opened.

    Raises OSError when the machine fails (`riot.geometry.machine_errors`): else a drawing would be taken for a
    picture that is none.
    """
    try:
        check_file(Path(path), PICTURE_BYTES)
        with Path(path).open("rb") as file:
            head = file.read(64)
    except (OSError, ValueError) as error:  # ValueError: too many bytes, or a path with a null character
        if is_of_machine(error):
            raise
        return False
    text = head.replace(b"\0", b"").lstrip(b"\xef\xbb\xbf\xff\xfe \t\r\n")  # byte-order marks, UTF-16
    return text.startswith((b"<?xml", b"<svg", b"<!--", b"<!DOCTYPE"))


_BROKEN = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError, RecursionError)
"""What the parser of SVG ends in when it is given nonsense."""


def outline(path: str | os.PathLike[str]) -> FloatArray:
    """Outer boundary, (m, 2), of the largest region that an SVG file fills, in its user units, y downwards.

    Holes are dropped. Orientation and start vertex are arbitrary.

    Raises
    ------
    SilhouetteError
        ``unreadable`` (missing, not XML, no SVG), ``unsupported`` (declarations, references to other files,
        masks), ``too-large``, ``empty`` (nothing filled).
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
        rings = _rings(visible, flatness)
        refuse_tangles(list(itertools.chain.from_iterable(rings)))
        painted = [
            (_region(of, _odd(element)), _fill(element)) for element, of in zip(visible, rings, strict=True) if of
        ]
        painted = [(region, fill) for region, fill in painted if not region.is_empty]
        region = _object(painted, shapely.box(*view))
    except TangleError as error:
        raise SilhouetteError("too-large", f"{where}: {error}; simplify the drawing, or export it as PNG") from error
    except (*_BROKEN, shapely.errors.ShapelyError) as error:
        raise SilhouetteError("unreadable", f"{where}: broken geometry ({error}); save the file again") from error
    parts = [part for part in shapely.get_parts(region) if part.geom_type == "Polygon" and part.area > 0.0]
    if not parts:
        raise SilhouetteError(
            "empty", f"{where}: nothing is filled; turn strokes and text into paths, or export the drawing as PNG"
        )
    largest = max(parts, key=lambda part: float(shapely.Polygon(part.exterior).area))
    return np.asarray(largest.exterior.coords, dtype=np.float64)[:-1]


def _object(painted: list[tuple[Any, _Colour]], view: Any) -> Any:
    background: _Colour | None = None
    region: Any = shapely.Polygon()
    waiting: list[Any] = []  # unions are cheaper in bulk, and only a background's colour has to keep the order
    for patch, colour in painted:
        if patch.intersection(view).area >= _WHOLE * view.area and (background is None or _same(colour, background)):
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
    if colour is None or colour.value is None:  # a gradient or pattern: a colour like no other
        return (-9.0, -9.0, -9.0)
    return colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0


def _same(one: _Colour, other: _Colour) -> bool:
    return max(abs(a - b) for a, b in zip(one, other, strict=True)) <= _SAME_COLOUR


def _rings(elements: list[Any], flatness: float) -> list[list[FloatArray]]:
    """The closed rings of each element, curves flattened, of three vertices at least."""
    found: list[list[FloatArray]] = []
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
        found.append(rings)
    return found


def _odd(element: Any) -> bool:
    return str(element.values.get("fill-rule", "nonzero")).strip() == "evenodd"


def _region(rings: list[FloatArray], odd: bool) -> Any:
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
    if len(inner) * sum(map(len, rings)) > _MAX_TURNS:
        raise TangleError(f"one element has {len(inner)} faces")
    turns = sum(_winding(ring, inner) for ring in rings)
    return shapely.union_all([face for face, n in zip(faces, turns, strict=True) if (n % 2 if odd else n)])


def _winding(ring: FloatArray, places: FloatArray) -> Any:
    """How often a closed ring, (m, 2), winds around each of (k, 2) places that are not on it: (k,) int64."""
    step = max(1, _AT_ONCE // len(ring))
    return np.concatenate([_turns(ring, places[start : start + step]) for start in range(0, len(places), step)])


def _turns(ring: FloatArray, places: FloatArray) -> Any:
    x, y = places[:, 0, None], places[:, 1, None]
    x0, y0 = ring[:, 0], ring[:, 1]
    x1, y1 = np.roll(x0, -1), np.roll(y0, -1)
    side = (x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)
    up = (y0 <= y) & (y1 > y) & (side > 0.0)
    down = (y0 > y) & (y1 <= y) & (side < 0.0)
    return up.sum(axis=1) - down.sum(axis=1)


def _ring(subpath: Any, flatness: float, room: int) -> FloatArray:
    """Vertices, (m, 2), of a subpath with curves flattened; `TangleError` when they are more than ``room``."""
    pieces: list[FloatArray] = []
    for segment in subpath:
        if segment.end is None:
            continue
        room -= len(pieces[-1]) if pieces else 0
        if room <= 0:
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
    steps = min(1000, max(1, math.ceil(math.sqrt(bend / (8.0 * flatness)))))
    t = (np.arange(1, steps + 1) / steps)[:, None]
    level = [np.broadcast_to(c, (steps, 2)) for c in controls]
    while len(level) > 1:  # de Casteljau
        level = [(1.0 - t) * a + t * b for a, b in itertools.pairwise(level)]
    return np.asarray(level[0], dtype=np.float64)
