"""Scenes as pages of a PDF file at true size, through matplotlib's PDF writer: no figure, no axes, no date. Ours."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.backends.backend_pdf import PdfFile, RendererPdf
from matplotlib.font_manager import FontProperties
from matplotlib.path import Path
from matplotlib.transforms import Affine2D, TransformedPath

from riot.draw.palette import LIGHT, PAPER_PENS, PENS, colour, hue
from riot.draw.scene import Bitmap, Dot, Label, Line, PlacedPiece, Region, Scene, placed
from riot.draw.tuning import PDF_WIDTH_MM
from riot.types import FloatArray

POINTS_PER_MM = 72.0 / 25.4
"""Printer's points, the unit of a PDF file, in a millimetre."""


_ANCHORS = {"start": 0.0, "middle": 0.5, "end": 1.0}


def pdf_bytes(pages: Sequence[Scene], unit_mm: float | None = None) -> bytes:
    """The scenes as a PDF file of a page each: vector outlines, text that can be searched, the same bytes every time.

    ``unit_mm`` is the length of a scene's unit on paper; without it pages are `PDF_WIDTH_MM` wide.

    Examples
    --------
    >>> pdf_bytes([Scene("", (0.0, 0.0, 210.0, 297.0), 0.2, (), ())], unit_mm=1.0)[:8]
    b'%PDF-1.4'
    """
    stream = io.BytesIO()
    file = PdfFile(stream, metadata={"CreationDate": None, "Creator": None, "Producer": None})
    for scene in pages:
        x0, y0, x1, y1 = scene.box
        points = POINTS_PER_MM * (PDF_WIDTH_MM / (x1 - x0) if unit_mm is None else unit_mm)
        wide, high = (x1 - x0) * points / 72.0, (y1 - y0) * points / 72.0  # inches
        file.newPage(wide, high)
        renderer = RendererPdf(file, 72.0, high, wide)
        page = _Page(scene, renderer, Affine2D().translate(-x0, -y0).scale(points), points * scene.pen)
        for mark in scene.marks:
            page.paint(mark)
        renderer.finalize()
    file.finalize()
    file.close()
    return stream.getvalue()


class _Page:
    """Paints the marks of one scene."""

    def __init__(self, scene: Scene, renderer: Any, to_points: Any, pen: float) -> None:
        self._scene, self._renderer, self._to_points, self._pen = scene, renderer, to_points, pen
        self._flipped: dict[int, Any] = {}

    def paint(self, mark: Any) -> None:
        if isinstance(mark, Region):
            self._path(_closed(mark.rings), mark.pen, self._pen)
        elif isinstance(mark, Line):
            self._path(Path(mark.points), mark.pen, self._pen)
        elif isinstance(mark, PlacedPiece):
            self._piece(mark)
        elif isinstance(mark, Dot):
            self._path(Path.circle((mark.x, mark.y), mark.radius * self._scene.pen), mark.pen, self._pen)
        elif isinstance(mark, Bitmap):
            clip = None if mark.clip is None else TransformedPath(_closed(mark.clip), self._to_points)
            self._bitmap(mark.pixels, mark.box, self._to_points, clip)
        else:
            self._label(mark)

    def _piece(self, mark: PlacedPiece) -> None:
        scene, pen = self._scene, self._pen * mark.scale
        piece, image = scene.pieces[mark.piece], scene.image_of(mark)
        outline = _closed((placed(mark, piece.polygon),))
        if image is None:
            self._path(outline, f"piece{hue(mark.piece, len(scene.pieces))}", pen)
            seam = np.array([[0.0, 0.0], [piece.length, 0.0]])
            self._path(Path(placed(mark, seam)), "seam", pen)
        else:
            sides = Affine2D().scale(-mark.scale if mark.mirror else mark.scale, mark.scale)
            to_points = sides.rotate(mark.heading).translate(mark.x, mark.y) + self._to_points
            self._bitmap(image.pixels, image.box, to_points, TransformedPath(outline, self._to_points))
            self._path(outline, "cut", pen)

    def _path(self, path: Any, name: str, pen: float) -> None:
        look, graphics = PENS.get(name) or PAPER_PENS[name], self._renderer.new_gc()
        graphics.set_joinstyle("round")
        graphics.set_capstyle("round")
        graphics.set_linewidth(look.width * pen if look.stroke else 0.0)
        graphics.set_foreground(colour(look.stroke or "ink", LIGHT))
        graphics.set_alpha(look.opacity)
        if look.dash:
            graphics.set_dashes(0.0, [step * pen for step in look.dash])
        fill = _rgb(colour(look.fill, LIGHT)) if look.fill else None
        self._renderer.draw_path(graphics, path, self._to_points, fill)

    def _bitmap(self, pixels: Any, box: Any, to_points: Any, clip: Any) -> None:
        """Paint pixels into a box, carried by ``to_points``; an image of a PDF file has its first row below."""
        x0, y0, x1, y1 = box
        graphics = self._renderer.new_gc()
        if clip is not None:
            graphics.set_clip_path(clip)
        flipped = self._flipped.setdefault(id(pixels), pixels[::-1])
        self._renderer.draw_image(
            graphics, 0.0, 0.0, flipped, Affine2D().scale(x1 - x0, y1 - y0).translate(x0, y0) + to_points
        )

    def _label(self, mark: Label) -> None:
        font = FontProperties(family="DejaVu Sans", weight=mark.weight, size=mark.size * self._pen)
        graphics = self._renderer.new_gc()
        graphics.set_foreground(colour(PENS[mark.pen].fill or "ink", LIGHT))
        width = self._renderer.get_text_width_height_descent(mark.text, font, False)[0]
        x, y = self._to_points.transform((mark.x, mark.y))
        self._renderer.draw_text(graphics, x - _ANCHORS[mark.anchor] * width, y, mark.text, font, 0.0)


def _closed(rings: Sequence[FloatArray]) -> Any:
    """Rings, with or without their first point again at the end, as one path."""
    return Path.make_compound_path(*(Path(np.concatenate([ring, ring[:1]]), closed=True) for ring in rings))


def _rgb(text: str) -> tuple[float, ...]:
    return tuple(int(text[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
