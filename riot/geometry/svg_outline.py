"""SVG file → the outline of what a viewer shows (ours).

The drawing is rendered, and its picture read as any picture. Where it is nothing but filled paths, and what they fill
is what the picture shows, the outline of the paths is taken in place of the pixels', for its corners.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from PIL import Image

from riot.errors import SilhouetteError
from riot.geometry.contour import find_object, trace_contour
from riot.geometry.limits import PICTURE_BYTES, check_file
from riot.geometry.machine_errors import is_of_machine
from riot.geometry.picture import grey_picture
from riot.geometry.quality import ALL_SIDES, ReadingQuality
from riot.geometry.svg_document import HEAD_BYTES, begins_like_svg, load
from riot.geometry.svg_page import NAMESPACE, Box, Page, cut_out, frame, page_of
from riot.geometry.svg_plain import NotPlain, Polygons, drawn_box, is_plain, outer_boundary, plain_region
from riot.geometry.svg_render import RenderError, TooCostly, render
from riot.parameters import ShapeParameters
from riot.types import BoolArray, FloatArray

_COARSE = 256
"""Longer side, pixels, of the picture that shows where the object is, and whether the paths' outline is right. Ours."""

_FINE = 1536
"""Longer side, pixels, of the picture whose outline is taken: right to 2e-4 L_c (benchmarks/reading.py). Ours."""

_SMALL = 0.5
"""An object that takes less of the picture's longer side is looked at more closely. Ours."""

_MARGIN = 0.05
"""What is shown around it, as a share of its size. Ours."""

_AGREEMENT = 0.9995
"""Least IoU of what the paths fill with what is rendered. Ours."""

_QUARTER = 0.3
"""By how much the share of a pixel may differ between a curve and its chords: resvg tries four lines of a pixel, and
draws curves with chords of its own. Ours."""


@dataclass(frozen=True)
class DrawnOutline:
    """The outline of a drawing.

    Parameters
    ----------
    points : (m, 2) float64
        In CSS pixels of the page, y downwards; orientation and start vertex are arbitrary.
    rendered : bool
        Taken from the rendered picture, not from the paths.
    quality : ReadingQuality
        How well the object was told from the page in the rendered picture.
    """

    points: FloatArray
    rendered: bool
    quality: ReadingQuality


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
            return begins_like_svg(file.read(HEAD_BYTES))
    except (OSError, ValueError) as error:  # ValueError: too many bytes, or a path with a null character
        if is_of_machine(error):
            raise
        return False


def outline(path: str | os.PathLike[str], parameters: ShapeParameters | None = None) -> DrawnOutline:
    """Outer boundary of the largest object that a viewer shows of an SVG file; holes are dropped.

    Raises
    ------
    SilhouetteError
        ``unreadable`` (missing, not XML, no SVG, broken), ``unsupported`` (entities, references to other files,
        text, what is not drawn as in a browser), ``too-large``, ``empty`` (nothing drawn), and as
        `riot.geometry.contour.find_object`.
    OSError, MemoryError
        The machine failed: nothing is known of the file.

    >>> from pathlib import Path
    >>> _ = Path("square.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0H9V9H0z"/></svg>')
    >>> len(outline("square.svg").points)
    4
    """
    where = str(path)
    tree = load(path)
    chosen = replace(parameters or ShapeParameters(), min_pixels=1)
    plain = is_plain(tree)
    page = _page(tree, plain, where)

    def shown(window: Box, pixels: int) -> Image.Image:
        return _rendered(cut_out(tree, page, window, pixels), not plain, where)

    def looked_at(pixels: int) -> _Seen:
        """The object; if it is small on the page, at a size of its own."""
        seen = _seen(shown(page.box, pixels), page.box, where, chosen)
        window = _around(seen, page.box)
        small = max(window[2] - window[0], window[3] - window[1]) < _SMALL * page.side
        return _seen(shown(window, pixels), window, where, chosen) if small and seen.by_opacity else seen

    if plain:
        try:
            paths = plain_region(tree, page)
        except NotPlain:
            pass
        else:
            seen = looked_at(_COARSE)
            drawn = _seen(_rendered(_drawing(paths, seen.window, _COARSE), False, where), seen.window, where, chosen)
            if _agreement(drawn.share, seen.share) >= _AGREEMENT:
                return DrawnOutline(outer_boundary(paths), False, seen.quality)
    seen = looked_at(_FINE)
    return DrawnOutline(_traced(seen, where), True, seen.quality)


@dataclass(frozen=True)
class _Seen:
    """What a picture of a window of the page shows: the object's share of each pixel, and its largest component."""

    share: FloatArray
    component: BoolArray
    quality: ReadingQuality
    window: Box
    by_opacity: bool
    """The object is what is opaque; one that is told by its colour needs all of the background around it."""


def _page(tree: ElementTree.Element, plain: bool, where: str) -> Page:
    try:
        page = page_of(tree)
        if page is None and not plain:
            raise SilhouetteError(
                "unsupported", f"{where}: the drawing does not say how large it is; give <svg> a viewBox"
            )
        return page or Page(drawn_box(tree))
    except (ValueError, OverflowError) as error:
        if isinstance(error, SilhouetteError):
            raise
        raise SilhouetteError("unreadable", f"{where}: {error}; save the file again, or mend it") from error
    except NotPlain as error:
        raise SilhouetteError("empty", f"{where}: {error}; export the drawing as PNG") from error


def _rendered(text: str, apart: bool, where: str) -> Image.Image:
    try:
        return render(text, apart)
    except TooCostly as error:
        raise SilhouetteError("too-large", f"{where}: {error}; simplify the drawing, or export it as PNG") from error
    except RenderError as error:
        raise SilhouetteError("unreadable", f"{where}: {error}; save the file again") from error


def _seen(image: Image.Image, window: Box, where: str, parameters: ShapeParameters) -> _Seen:
    opacity = np.asarray(image.getchannel("A"))
    least, most = int(opacity.min()), int(opacity.max())
    if most == 0:
        raise SilhouetteError("empty", f"{where}: the drawing shows nothing on its page; mend it, or delete the file")
    picture = grey_picture(image)
    try:
        share, component, quality = find_object(picture, where, parameters)
    except SilhouetteError as error:
        if error.reason != "one-colour" or least < most:
            raise
        component = np.ones((image.height, image.width), dtype=np.bool_)  # the page is full
        full = ReadingQuality(covered=1.0, sides=ALL_SIDES)
        return _Seen(component.astype(np.float64), component, full, window, False)
    return _Seen(share, component, quality, window, picture.opaque_object)


def _traced(seen: _Seen, where: str) -> FloatArray:
    left, top, right, bottom = seen.window
    if seen.component.all():
        return np.array([[left, top], [right, top], [right, bottom], [left, bottom]], dtype=np.float64)
    contour = trace_contour(seen.share, seen.component, 0.0, where) + 0.5  # from pixels' centres to their corners
    rows, columns = seen.share.shape
    contour *= np.array([(right - left) / columns, (bottom - top) / rows])
    return np.asarray(contour + np.array([left, top]))


def _around(seen: _Seen, page: Box) -> Box:
    rows, columns = seen.share.shape
    scale = np.array([(page[2] - page[0]) / columns, (page[3] - page[1]) / rows])
    row, column = np.flatnonzero(seen.component.any(axis=1)), np.flatnonzero(seen.component.any(axis=0))
    low = np.array([column[0], row[0]]) * scale + page[:2]
    high = np.array([column[-1] + 1, row[-1] + 1]) * scale + page[:2]
    margin = _MARGIN * float((high - low).max()) + float(scale.max())
    (left, top), (right, bottom) = (low - margin).tolist(), (high + margin).tolist()
    return max(left, page[0]), max(top, page[1]), min(right, page[2]), min(bottom, page[3])


def _drawing(region: Polygons, window: Box, pixels: int) -> str:
    root = ElementTree.Element(f"{{{NAMESPACE}}}svg", frame(window, pixels))
    rings = [ring for polygon in region for ring in (polygon.exterior, *polygon.interiors)]
    data = "".join(f"M{' '.join(f'{x!r} {y!r}' for x, y in ring.coords)}z" for ring in rings)
    ElementTree.SubElement(root, f"{{{NAMESPACE}}}path", {"d": data, "fill-rule": "evenodd"})
    return ElementTree.tostring(root, encoding="unicode")


def _agreement(first: FloatArray, second: FloatArray) -> float:
    """IoU of two shares of pixels, less what the renderer alone may have made of the same outline."""
    differs = np.maximum(np.abs(first - second) - _QUARTER, 0.0)
    return 1.0 - float(differs.sum() / np.maximum(first, second).sum())
