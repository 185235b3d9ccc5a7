"""The page of an SVG drawing, the transforms of SVG, and a drawing cut out of its page at any size (ours).

Coordinates of a page are CSS pixels, y downwards; the view box is laid onto the page (SVG 1.1, section 7).
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from xml.etree import ElementTree

NAMESPACE = "http://www.w3.org/2000/svg"

Affine = tuple[complex, complex, complex]
"""Images of the unit vectors, and the shift: z → z.real · a + z.imag · b + shift."""

Box = tuple[float, float, float, float]
"""Left, top, right, bottom."""

IDENTITY: Affine = (1.0 + 0j, 1j, 0j)

_PIXELS = {"": 1.0, "px": 1.0, "pt": 4 / 3, "pc": 16.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "in": 96.0, "em": 16.0}
_LENGTH = re.compile(r"\s*(\+?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*([a-z]*)\s*")
_TRANSFORM = re.compile(r"\s*,?\s*(matrix|translate|scale|rotate|skewX|skewY)\s*\(([^()]*)\)")
_ALIGN = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
_SIZES = (1e-6, 1e9)
"""Least and greatest side of a page and of a view box. Ours: beyond them a renderer's numbers, of 32 bits, fail."""


@dataclass(frozen=True)
class Page:
    """What a viewer shows of a drawing.

    Parameters
    ----------
    box : Box
        In the page's own pixels.
    transform : Affine
        From the drawing's units.
    view : (float, float)
        Width and height in the drawing's units, of which its percentages are.
    """

    box: Box
    transform: Affine = IDENTITY
    view: tuple[float, float] = (0.0, 0.0)

    @property
    def side(self) -> float:
        """The longer side."""
        return max(self.box[2] - self.box[0], self.box[3] - self.box[1])


def page_of(root: ElementTree.Element) -> Page | None:
    """The page that the size and view box of a drawing give; None if it has neither. ValueError for broken ones.

    >>> page_of(ElementTree.fromstring('<svg width="20" viewBox="0 0 100 50"/>')).box
    (0.0, 0.0, 20.0, 10.0)
    """
    view = [float(value) for value in re.split(r"[\s,]+", root.get("viewBox", "").strip()) if value]
    width, height = _length(root.get("width", "")), _length(root.get("height", ""))
    if view and (len(view) != 4 or not all(_SIZES[0] < side < _SIZES[1] for side in view[2:])):
        raise ValueError(f"the view box {root.get('viewBox', '')[:60]!r}")
    if not view:
        return None if width is None or height is None else Page((0.0, 0.0, width, height), IDENTITY, (width, height))
    ratio = view[3] / view[2]
    width = width if width is not None else (height / ratio if height is not None else view[2])
    height = height if height is not None else width * ratio
    x, y = width / view[2], height / view[3]
    align, _, how = root.get("preserveAspectRatio", "").strip().partition(" ")
    placed = re.fullmatch(r"x(Min|Mid|Max)Y(Min|Mid|Max)", align)
    if align != "none":
        x = y = max(x, y) if how.strip() == "slice" else min(x, y)
    across, down = (_ALIGN[place] for place in (placed.groups() if placed else ("Mid", "Mid")))
    shift = complex((width - x * view[2]) * across - x * view[0], (height - y * view[3]) * down - y * view[1])
    return Page((0.0, 0.0, width, height), (complex(x), 1j * y, shift), (view[2], view[3]))


def _length(text: str) -> float | None:
    """A length in pixels; None for a share of what is around the drawing, and for none."""
    match = _LENGTH.fullmatch(text)
    if match is None or match[2] not in _PIXELS:
        return None
    length = float(match[1]) * _PIXELS[match[2]]
    if not _SIZES[0] < length < _SIZES[1]:
        raise ValueError(f"a page of size {text[:60]!r}")
    return length


def cut_out(root: ElementTree.Element, page: Page, window: Box, pixels: int) -> str:
    """The text of a drawing that shows a window of another's page, its longer side so many pixels long.

    >>> root = ElementTree.fromstring('<svg xmlns="http://www.w3.org/2000/svg" width="20" height="9"/>')
    >>> cut_out(root, page_of(root), (0.0, 0.0, 10.0, 5.0), 100).count('width="100"')
    1
    """
    outside = frame(window, pixels)
    left, top, right, bottom = page.box
    inner = ElementTree.Element(root.tag, dict(root.attrib))
    inner.extend(root)
    if window == page.box and not left and not top and int(outside["width"]) * bottom == int(outside["height"]) * right:
        # The same without a clip, which takes as long as the rest.
        inner.attrib.update({"viewBox": outside["viewBox"], **inner.attrib, "width": outside["width"]})
        inner.set("height", outside["height"])
        return ElementTree.tostring(inner, encoding="unicode")
    inner.attrib.update({"x": "0", "y": "0", "width": repr(right), "height": repr(bottom)})
    inner.set("overflow", "visible" if left or top else "hidden")
    outer = ElementTree.Element(f"{{{NAMESPACE}}}svg", outside)
    outer.append(inner)
    return ElementTree.tostring(outer, encoding="unicode")


def frame(window: Box, pixels: int) -> dict[str, str]:
    """Attributes of a drawing that shows a window of a page, its longer side so many pixels long.

    >>> frame((0.0, 0.0, 10.0, 5.0), 100)["height"]
    '50'
    """
    width, height = window[2] - window[0], window[3] - window[1]
    scale = pixels / max(width, height)
    size = {name: str(max(3, round(side * scale))) for name, side in (("width", width), ("height", height))}
    return {**size, "viewBox": f"{window[0]!r} {window[1]!r} {width!r} {height!r}", "preserveAspectRatio": "none"}


def affine(text: str) -> Affine:
    """Parse the value of a ``transform``; ValueError for what is none.

    >>> affine("translate(5) scale(2)")
    ((2+0j), 2j, (5+0j))
    """
    result, text = IDENTITY, " ".join(text.split())
    if _TRANSFORM.sub("", text).strip():
        raise ValueError(f"the transform {text[:60]!r}")
    for name, arguments in _TRANSFORM.findall(text):
        result = composed(result, _step(name, [float(value) for value in re.split(r"[\s,]+", arguments.strip())]))
    return result


def _step(name: str, values: list[float]) -> Affine:
    first, second = values[0], values[1] if len(values) > 1 else None
    if name == "matrix":
        a, b, c, d, e, f = values
        return complex(a, b), complex(c, d), complex(e, f)
    if name == "translate":
        return 1.0 + 0j, 1j, complex(first, second or 0.0)
    if name == "scale":
        return complex(first), 1j * (first if second is None else second), 0j
    if name == "rotate":
        turn = complex(math.cos(math.radians(first)), math.sin(math.radians(first)))
        centre = complex(*values[1:3]) if len(values) == 3 else 0j
        return turn, 1j * turn, centre - turn * centre
    slope = math.tan(math.radians(first))
    return (1.0 + 0j, slope + 1j, 0j) if name == "skewX" else (1.0 + 1j * slope, 1j, 0j)


def composed(outer: Affine, inner: Affine) -> Affine:
    """The map that does ``inner`` first.

    >>> composed((2.0 + 0j, 2j, 0j), (1.0 + 0j, 1j, 1.0 + 0j))
    ((2+0j), 2j, (2+0j))
    """

    def moved(z: complex) -> complex:
        return z.real * outer[0] + z.imag * outer[1]

    return moved(inner[0]), moved(inner[1]), moved(inner[2]) + outer[2]
