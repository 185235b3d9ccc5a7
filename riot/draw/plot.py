"""Scenes as PNG and PDF, through matplotlib's object interface: no window, no global state. Ours."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon
from matplotlib.path import Path as Outline
from matplotlib.text import Text
from matplotlib.transforms import Affine2D

from riot.draw.palette import LIGHT, PENS, colour, hue
from riot.draw.scene import Dot, Label, Part, Path, Scene, placed
from riot.draw.skin import Skin
from riot.transform.transform import Piece
from riot.types import FloatArray

INCHES = 10.0
"""Width of a page."""

POINTS = 72.0
"""Printer's points in an inch: matplotlib's unit of line widths and letters."""

DOTS_PER_INCH = 160

_ANCHORS: dict[str, Any] = {"start": "left", "middle": "center", "end": "right"}


def png(scene: Scene) -> bytes:
    """The scene as a PNG file, 1600 pixels wide."""
    return _written(scene, "png")


def pdf(scene: Scene) -> bytes:
    """The scene as a PDF file of one page, with vector outlines and without a date."""
    return _written(scene, "pdf")


def _written(scene: Scene, kind: str) -> bytes:
    figure = _figure(scene)
    stream = io.BytesIO()
    if kind == "png":
        FigureCanvasAgg(figure).print_figure(
            stream, format="png", dpi=DOTS_PER_INCH, metadata={"Software": None, "Title": scene.title}
        )
    else:
        nothing = {"CreationDate": None, "Creator": None, "Producer": None}
        FigureCanvasPdf(figure).print_figure(stream, format="pdf", metadata=nothing)
    return stream.getvalue()


def _figure(scene: Scene) -> Any:
    x0, y0, x1, y1 = scene.box
    width = x1 - x0
    figure = Figure(figsize=(INCHES, INCHES * (y1 - y0) / width), facecolor=LIGHT["paper"])
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set_autoscale_on(False)
    axes.set_xlim(x0, x1)
    axes.set_ylim(y0, y1)
    pen = scene.pen / width * INCHES * POINTS
    for order, mark in enumerate(scene.marks):
        if isinstance(mark, Path):
            _path(axes, mark.points, mark.pen, mark.closed, pen, order)
        elif isinstance(mark, Part):
            piece = scene.pieces[mark.piece]
            outline, skin = placed(mark, piece.polygon), scene.skin(mark)
            if skin is not None:
                _skin(axes, mark, skin, piece, order)
                _path(axes, outline, "cut", True, pen * mark.scale, order)
                continue
            _path(axes, outline, f"piece{hue(mark.piece, len(scene.pieces))}", True, pen * mark.scale, order)
            seam = placed(mark, np.array([[0.0, 0.0], [piece.length, 0.0]]))
            _path(axes, seam, "seam", False, pen * mark.scale, order)
        elif isinstance(mark, Dot):
            style = _style(mark.pen, pen)
            axes.add_patch(Circle((mark.x, mark.y), mark.radius * scene.pen, zorder=order, **style))
        else:
            _text(axes, mark, pen, order)
    return figure


def _skin(axes: Any, mark: Part, skin: Skin, piece: Piece, order: int) -> None:
    """Paint a piece's skin where the part lies, cut to the piece's outline."""
    x0, y0, x1, y1 = skin.box
    place = Affine2D().scale(mark.scale).rotate(mark.heading).translate(mark.x, mark.y) + axes.transData
    picture = axes.imshow(
        skin.pixels, extent=(x0, x1, y0, y1), interpolation="bilinear", aspect="auto", zorder=order, transform=place
    )
    picture.set_clip_path(Outline(piece.polygon, closed=False), place)


def _path(axes: Any, points: FloatArray, name: str, closed: bool, pen: float, order: int) -> None:
    look = PENS[name]
    if closed:
        axes.add_patch(Polygon(points, closed=True, zorder=order, joinstyle="round", **_style(name, pen)))
        return
    line = Line2D(
        points[:, 0],
        points[:, 1],
        color=colour(look.stroke or "ink", LIGHT),
        linewidth=look.width * pen,
        alpha=look.opacity,
        zorder=order,
        solid_capstyle="round",
    )
    if look.dash:  # matplotlib counts dashes in line widths, a pen in pens
        line.set_linestyle((0.0, tuple(step / look.width for step in look.dash)))
    axes.add_line(line)


def _style(name: str, pen: float) -> dict[str, Any]:
    look = PENS[name]
    return {
        "facecolor": colour(look.fill, LIGHT) if look.fill else "none",
        "edgecolor": colour(look.stroke, LIGHT) if look.stroke else "none",
        "linewidth": look.width * pen if look.stroke else 0.0,
        "alpha": look.opacity if look.opacity < 1.0 else None,
    }


def _text(axes: Any, mark: Label, pen: float, order: int) -> None:
    axes.add_artist(
        Text(
            mark.x,
            mark.y,
            mark.text,
            color=colour(PENS[mark.pen].fill or "ink", LIGHT),
            fontsize=mark.size * pen,
            fontweight=mark.weight,
            horizontalalignment=_ANCHORS[mark.anchor],
            verticalalignment="baseline",
            parse_math=False,
            zorder=order,
        )
    )
