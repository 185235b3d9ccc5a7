"""A transform as a small picture in a file of its own, light or dark as the reader's system has it. Ours."""

from __future__ import annotations

import math

from riot.draw.palette import DARK, LIGHT, PIECES, hue
from riot.draw.panels import dissection_marks, sketch
from riot.draw.piece_image import NO_IMAGES, PieceImages
from riot.draw.scene import PlacedPiece, Scene, extent, moved
from riot.draw.svg import UNITS, definitions, naming, painted
from riot.transform.transform import Transform

WIDTH, HEIGHT = 264, 132
"""Its natural size, in pixels."""

TOLERANCE = 4e-3
"""Greatest deviation of the simplified outlines, in units of the shape: a quarter of a pixel (ours)."""

_MARGIN = 0.03


def thumb(transform: Transform, images: PieceImages = NO_IMAGES) -> str:
    """The two dissections side by side at one scale, as a whole SVG file.

    Pieces are in their colours, or show their images; the same transform gives the same text.
    """
    drawn = sketch(transform, TOLERANCE)
    halves = [[mark for mark in dissection_marks(drawn, side) if isinstance(mark, PlacedPiece)] for side in "pq"]
    boxes = [extent(placed, drawn.pieces) for placed in halves]
    half = max(max((x1 - x0) / 2, (y1 - y0) / 2) for x0, y0, x1, y1 in boxes) + _MARGIN
    marks = tuple(
        mark
        for centre, placed, (x0, y0, x1, y1) in zip((-half, half), halves, boxes, strict=True)
        for mark in moved(placed, centre - (x0 + x1) / 2, -(y0 + y1) / 2)
    )
    u = math.ceil(half * UNITS)
    prefix = naming(drawn.pieces, images)
    scene = Scene("", (-2 * half, -half, 2 * half, half), 4 * half / WIDTH, drawn.pieces, marks, images)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{-2 * u} {-u} {4 * u} {2 * u}" width="{WIDTH}" '
        f'height="{HEIGHT}"><style>{_style(len(drawn))}</style>{definitions(drawn.pieces, prefix, images)}'
        f"{painted(scene, prefix)}</svg>\n"
    )


def _style(pieces: int) -> str:
    used = sorted({hue(k, pieces) for k in range(pieces)})
    fills = "".join(f".r-piece{k}{{fill:{PIECES[k]}}}" for k in used)
    return (
        f"path{{stroke:{LIGHT['paper']};stroke-width:.8;vector-effect:non-scaling-stroke}}{fills}"
        ".r-seam{display:none}.r-cut{fill:none}"
        f"@media(prefers-color-scheme:dark){{path{{stroke:{DARK['paper']}}}}}"
    )
