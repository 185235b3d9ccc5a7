"""Plain drawings, nothing but filled paths, → the outline of what they fill, without a raster in between (ours).

It keeps corners, which pixels round; the renderer has the last word on whether it is what the drawing shows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
import shapely
from PIL import ImageColor

from riot.errors import SilhouetteError
from riot.geometry.crossings import TangleError, refuse_tangles
from riot.geometry.svg_document import tag_of
from riot.geometry.svg_page import IDENTITY, Affine, Box, Page, affine, composed
from riot.geometry.svg_paths import PathError, rings
from riot.geometry.svg_regions import MAX_POINTS, Colour, filled_region, object_region
from riot.types import FloatArray

_FLATNESS = 1e-4
"""Greatest distance of a chord from its curve, as a share of the page's longer side. Ours: far finer than the
sampling."""

_COARSE = 0.1
"""The same, in units of the drawing, to find how large it is. Ours."""

_MAX_DATA = 500_000
"""Greatest length of all paths together, characters. Ours: longer ones are drawn with limits of time and memory."""

_DRAWN = ("path", "rect", "circle", "ellipse", "polygon", "polyline")
_GEOMETRY = frozenset({"d", "points", "x", "y", "cx", "cy", "r", "rx", "ry", "width", "height"})
_HARMLESS = frozenset({"id", "class", "transform", "version", "viewBox", "preserveAspectRatio", "overflow", "role",
                       "baseProfile", "focusable", "clip-rule", "enable-background", "font-size",
                       "stroke-width", "stroke-miterlimit", "stroke-linejoin", "stroke-linecap"})  # fmt: skip
"""Attributes that change nothing where there is no stroke, text or style sheet."""

_NONE_ONLY = {
    "stroke": ("none",), "opacity": ("1",), "fill-opacity": ("1",), "stroke-opacity": ("1",), "display": ("inline",),
    "visibility": ("visible",), "clip-path": ("none",), "mask": ("none",), "filter": ("none",),
    "stroke-dasharray": ("none",),
}  # fmt: skip
"""Properties that keep a drawing plain with these values alone."""


Polygons = list[shapely.Polygon]


class NotPlain(Exception):
    """A drawing has more than filled paths, or is broken: only the renderer knows what it shows."""


@dataclass(frozen=True)
class _Paint:
    transform: Affine
    view: tuple[float, float]
    colour: Colour | None = (0, 0, 0)
    odd: bool = False


def plain_region(tree: ElementTree.Element, page: Page) -> Polygons:
    """The polygons that the object of a plain drawing fills, in pixels of its page, y downwards.

    Raises `NotPlain`, also where nothing is filled.
    """
    flatness = _FLATNESS * page.side
    try:
        with np.errstate(all="ignore"):  # what overflows is not finite
            filled = list(_filled(tree, _Paint(page.transform, page.view), flatness))
        refuse_tangles([ring for element_rings, _ in filled for ring in element_rings])
        painted = [(filled_region(of, paint.odd), paint.colour or ()) for of, paint in filled]
        region = object_region([(of, colour) for of, colour in painted if not of.is_empty], shapely.box(*page.box))
    except (PathError, TangleError, SilhouetteError, ArithmeticError, ValueError, LookupError) as error:
        raise NotPlain(str(error)) from error
    except shapely.errors.ShapelyError as error:
        raise NotPlain(str(error)) from error
    polygons = [shape for shape in shapely.get_parts(region) if shape.geom_type == "Polygon" and shape.area > 0.0]
    if not polygons:
        raise NotPlain("nothing is filled")
    return polygons


def outer_boundary(region: Polygons) -> FloatArray:
    """Outer boundary, (m, 2), of the polygon that is largest with its holes filled."""
    largest = max(region, key=lambda polygon: float(shapely.Polygon(polygon.exterior).area))
    return np.asarray(largest.exterior.coords, dtype=np.float64)[:-1]


def drawn_box(tree: ElementTree.Element) -> Box:
    """The box around all that a plain drawing without a page fills. Raises `NotPlain`."""
    try:
        with np.errstate(all="ignore"):
            filled = [ring for rings_of, _ in _filled(tree, _Paint(IDENTITY, (0.0, 0.0)), _COARSE) for ring in rings_of]
    except (SilhouetteError, ArithmeticError, ValueError, LookupError) as error:
        raise NotPlain(str(error)) from error
    if not filled:
        raise NotPlain("nothing is filled")
    points = np.concatenate(filled)
    (left, top), (right, bottom) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    if not (left < right and top < bottom):
        raise NotPlain("nothing is filled")
    return left, top, right, bottom


def is_plain(tree: ElementTree.Element) -> bool:
    """Whether a drawing has nothing but filled paths, in groups: what the renderer draws in little time and memory.

    >>> is_plain(ElementTree.fromstring("<svg><path d='M0 0H9V9z'/></svg>"))
    True
    """
    data = sum(len(element.get(name, "")) for element in tree.iter() for name in ("d", "points"))
    return data <= _MAX_DATA and all(_is_plain(element) for element in tree.iter())


def _is_plain(element: ElementTree.Element) -> bool:
    if tag_of(element) not in (*_DRAWN, "g", "svg", "defs"):
        return False
    return all(
        name in _GEOMETRY | _HARMLESS
        or name in ("fill", "fill-rule")
        or value in _NONE_ONLY.get(name, ())
        or name.startswith(("data-", "aria-", "on"))
        for name, value in _properties(element).items()
    )


def _properties(element: ElementTree.Element) -> dict[str, str]:
    """Attributes with those of ``style``, which are stronger, in their places."""
    properties = {name: value.strip() for name, value in element.attrib.items() if name != "style"}
    for declaration in element.get("style", "").split(";"):
        name, colon, value = declaration.partition(":")
        if colon and name.strip() in _GEOMETRY | {"transform"}:
            continue  # the root's size, or what `svg_style` refuses
        if colon:
            properties[name.strip()] = value.strip()
    return properties


def _filled(
    element: ElementTree.Element, paint: _Paint, flatness: float, within: bool = False
) -> Iterator[tuple[list[FloatArray], _Paint]]:
    """The rings, (m, 2) each, of each filled element in document order, with how they are painted."""
    if tag_of(element) == "defs":
        return
    if within and tag_of(element) == "svg":
        raise NotPlain("a drawing in the drawing")
    properties = _properties(element)
    paint = _Paint(
        composed(paint.transform, affine(properties.get("transform", ""))),
        paint.view,
        _colour(properties["fill"], paint.colour) if "fill" in properties else paint.colour,
        properties["fill-rule"] == "evenodd" if "fill-rule" in properties else paint.odd,
    )
    if tag_of(element) in _DRAWN and paint.colour is not None:
        a, b, shift = paint.transform
        size = max(math.hypot(a.real, b.real), math.hypot(a.imag, b.imag))
        moved = [
            ring.real * a + ring.imag * b + shift
            for ring in rings(_path(tag_of(element), properties, paint.view), flatness / max(size, 1e-12))
        ]
        if sum(map(len, moved)) > MAX_POINTS:
            raise NotPlain("too many points")
        if not all(np.isfinite(ring).all() for ring in moved):
            raise NotPlain("a coordinate is not finite")
        if moved:
            yield [np.column_stack([ring.real, ring.imag]) for ring in moved], paint
    for child in element:
        yield from _filled(child, paint, flatness, True)


def _path(tag: str, properties: dict[str, str], view: tuple[float, float]) -> str:
    """The data of the path that draws the same as an element."""
    if tag == "path":
        return properties.get("d", "")
    if tag in ("polygon", "polyline"):
        return f"M{properties['points']}" if properties.get("points") else ""
    lengths = {name: _length(properties.get(name, "0"), of) for name, of in _extents(view)}
    x, y, cx, cy, width, height, r = (lengths[name] for name in ("x", "y", "cx", "cy", "width", "height", "r"))
    rx, ry = (lengths[name if name in properties else other] for name, other in (("rx", "ry"), ("ry", "rx")))
    if tag in ("circle", "ellipse"):
        rx, ry = (r, r) if tag == "circle" else (rx, ry)
        return f"M{cx - rx} {cy}a{rx} {ry} 0 1 1 {2 * rx} 0a{rx} {ry} 0 1 1 {-2 * rx} 0z" if min(rx, ry) > 0 else ""
    if min(width, height) <= 0.0:
        return ""
    rx, ry = min(rx, width / 2.0), min(ry, height / 2.0)
    corners = ((rx, ry), (-rx, ry), (-rx, -ry), (rx, -ry))
    sides = (f"h{width - 2 * rx}", f"v{height - 2 * ry}", f"h{2 * rx - width}", f"v{2 * ry - height}")
    arcs = [f"a{rx} {ry} 0 0 1 {dx} {dy}" for dx, dy in (corners[0], corners[1], corners[2], corners[3])]
    return f"M{x + rx} {y}" + "".join(side + arc for side, arc in zip(sides, arcs, strict=True)) + "z"


def _extents(view: tuple[float, float]) -> Iterator[tuple[str, float]]:
    """What the percentages of lengths are of."""
    yield from ((name, view[0]) for name in ("x", "cx", "width", "rx"))
    yield from ((name, view[1]) for name in ("y", "cy", "height", "ry"))
    yield "r", math.hypot(*view) / math.sqrt(2.0)


def _length(text: str, of: float) -> float:
    return float(text[:-1]) / 100.0 * of if text.endswith("%") else float(text.removesuffix("px"))


def _colour(text: str, inherited: Colour | None) -> Colour | None:
    if text in ("inherit", ""):
        return inherited
    if text in ("none", "transparent"):
        return None
    if text == "currentColor":
        return 0, 0, 0
    colour = ImageColor.getrgb(text)
    if len(colour) == 4 and colour[3] < 255:
        raise NotPlain("a transparent colour")
    return colour[:3]
