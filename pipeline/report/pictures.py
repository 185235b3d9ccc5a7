"""A transform as pictures in files of their own: small and still, swinging, and for a link's preview. Ours.

SVG files are light or dark as the reader's system has it; the same transform gives the same bytes.
"""

from __future__ import annotations

import math

import numpy as np

from riot.draw.animate import swing_of
from riot.draw.palette import DARK, LIGHT, PIECES, hue
from riot.draw.panels import dissection_marks, sketch
from riot.draw.piece_image import NO_IMAGES, PieceImages
from riot.draw.raster import png_bytes
from riot.draw.scene import Mark, PlacedPiece, Scene, extent, moved
from riot.draw.svg import CLOSING, definitions, fragment, naming, painted
from riot.draw.svg_style import page_colours, page_style
from riot.draw.svg_text import UNITS, path_data
from riot.errors import needs_extra
from riot.geometry.polyline import simplify
from riot.transform.transform import Transform
from riot.types import FloatArray

with needs_extra("mine"):
    from markupsafe import Markup

WIDTH, HEIGHT = 264, 132
"""Natural size of a small picture, in pixels."""

PREVIEW = (600, 315)
"""Size of a link's picture, in pixels: the proportions that the Open Graph protocol's readers show whole."""

TOLERANCE = 4e-3
"""Greatest deviation of the simplified outlines, in units of the shape: a quarter of a pixel of a small picture."""

_MARGIN = 0.03


def thumb(transform: Transform, images: PieceImages = NO_IMAGES) -> str:
    """The two dissections side by side at one scale, as a whole SVG file.

    Pieces are in their colours, or show their images.
    """
    drawn = sketch(transform, TOLERANCE)
    half, marks = _side_by_side(drawn)
    u = math.ceil(half * UNITS)
    prefix = naming(drawn.pieces, images)
    scene = Scene("", (-2 * half, -half, 2 * half, half), 4 * half / WIDTH, drawn.pieces, marks, images)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{-2 * u} {-u} {4 * u} {2 * u}" width="{WIDTH}" '
        f'height="{HEIGHT}"><style>{_style(len(drawn))}</style>{definitions(drawn.pieces, prefix, images)}'
        f"{painted(scene, prefix)}{CLOSING}"
    )


def swing(transform: Transform, images: PieceImages = NO_IMAGES) -> str:
    """The motion from P to Q and back, as a whole SVG file that swings wherever it is shown.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> swing(exact_transform(dudeney())).count("prefers-color-scheme")
    1
    """
    prefix = naming(sketch(transform).pieces, images)
    moving = swing_of(transform, prefix, images)
    scene = moving.scene
    colours = f":root{{{page_colours(LIGHT)}}}@media(prefers-color-scheme:dark){{:root{{{page_colours(DARK)}}}}}"
    style = f"<style>{colours}{page_style()}.r-still,.r-seam{{display:none}}</style>"
    body = fragment(scene, prefix, style + definitions(scene.pieces, prefix, images) + moving.body)
    return body.replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" ', 1) + "\n"


def silhouettes(transform: Transform) -> tuple[Markup, Markup]:
    """The two inputs as they were given, before any bending: SVG elements in the colour of the text around them.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> silhouettes(exact_transform(dudeney()))[0][:4]
    Markup('<svg')
    """
    p, q = transform.bend_p, transform.bend_q
    shapes = transform.p if p is None else p.shape, transform.q if q is None else q.shape
    return silhouette(shapes[0].points), silhouette(shapes[1].points)


def silhouette(outline: FloatArray) -> Markup:
    """An outline, (m, 2), as an SVG element in the colour of the text around it.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> silhouette(exact_transform(dudeney()).q.points).count("<path")
    1
    """
    points = outline[simplify(outline, TOLERANCE)]
    (x0, y0), (x1, y1) = np.floor(points.min(axis=0) * UNITS), np.ceil(points.max(axis=0) * UNITS)
    view = f"{x0:.0f} {-y1:.0f} {x1 - x0:.0f} {y1 - y0:.0f}"
    return Markup(f'<svg class="silhouette" viewBox="{view}" aria-hidden="true"><path d="{path_data(points)}"/></svg>')


def preview(transform: Transform, images: PieceImages = NO_IMAGES) -> bytes:
    """The two dissections side by side, as a PNG file of the size `PREVIEW`.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> preview(exact_transform(dudeney()))[1:4]
    b'PNG'
    """
    drawn = sketch(transform, TOLERANCE)
    half, marks = _side_by_side(drawn)
    width, height = PREVIEW
    x = 2 * half + _MARGIN
    y = x * height / width
    scene = Scene("", (-x, -y, x, y), 2 * x / width, drawn.pieces, marks, images)
    return png_bytes(scene, width)


def _side_by_side(drawn: Transform) -> tuple[float, tuple[Mark, ...]]:
    """The marks of both dissections, and half of the side of a square that either of them fits."""
    halves = [[mark for mark in dissection_marks(drawn, side) if isinstance(mark, PlacedPiece)] for side in "pq"]
    boxes = [extent(placed, drawn.pieces) for placed in halves]
    half = max(max((x1 - x0) / 2, (y1 - y0) / 2) for x0, y0, x1, y1 in boxes) + _MARGIN
    return half, tuple(
        mark
        for centre, placed, (x0, y0, x1, y1) in zip((-half, half), halves, boxes, strict=True)
        for mark in moved(placed, centre - (x0 + x1) / 2, -(y0 + y1) / 2)
    )


def _style(pieces: int) -> str:
    used = sorted({hue(k, pieces) for k in range(pieces)})
    fills = "".join(f".r-piece{k}{{fill:{PIECES[k]}}}" for k in used)
    return (
        f"path{{stroke:{LIGHT['paper']};stroke-width:.8;vector-effect:non-scaling-stroke}}{fills}"
        ".r-seam{display:none}.r-cut{fill:none}"
        f"@media(prefers-color-scheme:dark){{path{{stroke:{DARK['paper']}}}}}"
    )
