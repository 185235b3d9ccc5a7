"""Paper: pages measured in millimetres, painted through matplotlib without a window, a date or global state. Ours."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import shapely
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.text import Text

from riot.draw.palette import LIGHT
from riot.fabricate.model import polygons
from riot.transform.pose import rotate

if TYPE_CHECKING:
    from riot.draw.texture.source import ByteArray
    from riot.types import FloatArray

MM_PER_INCH = 25.4
Anchor = Literal["left", "center", "right"]

POINT_MM = MM_PER_INCH / 72.0
"""A printer's point, the unit of letters, in mm."""


@dataclass(frozen=True)
class Frame:
    """How a piece's frame (mm) lies on paper: turned by ``angle`` (radians), moved by (x, y), and then, if ``mirror``
    is a number, mirrored about the upright line at half of it: the page's width mirrors a page."""

    angle: float
    x: float
    y: float
    mirror: float | None = None

    def paper(self, points: FloatArray) -> FloatArray:
        """Map (k, 2) points of the piece's frame to the paper."""
        found: FloatArray = rotate(points, self.angle) + np.array([self.x, self.y])
        return self._seen(found)

    def piece(self, points: FloatArray) -> FloatArray:
        """Map (k, 2) points of the paper to the piece's frame."""
        found: FloatArray = rotate(self._seen(points) - np.array([self.x, self.y]), -self.angle)
        return found

    def region(self, region: shapely.Geometry) -> shapely.Geometry:
        """A region of the piece's frame on the paper."""
        return shapely.normalize(shapely.transform(region, self.paper))

    def _seen(self, points: FloatArray) -> FloatArray:
        return points if self.mirror is None else np.column_stack([self.mirror - points[:, 0], points[:, 1]])


@dataclass(frozen=True)
class Page:
    """A page to paint on: a matplotlib figure and its axes, which count mm from the lower left corner."""

    figure: Any
    axes: Any
    width: float
    height: float

    def region(self, region: shapely.Geometry, fill: str | None, line: str | None = None, width_mm: float = 0.2) -> Any:
        """Paint a region in mm, with its holes; returns matplotlib's patch."""
        patch = PathPatch(
            _path(region),
            facecolor=fill or "none",
            edgecolor=line or "none",
            linewidth=width_mm / POINT_MM if line else 0.0,
            joinstyle="round",
        )
        self.axes.add_artist(patch)  # add_patch would measure it, in vain
        return patch

    def line(self, points: FloatArray, colour: str, width_mm: float = 0.2, dashed: bool = False) -> None:
        """Paint a polyline, (k, 2) in mm."""
        self.axes.plot(
            points[:, 0],
            points[:, 1],
            color=colour,
            linewidth=width_mm / POINT_MM,
            solid_capstyle="round",
            linestyle=(0.0, (3.0, 2.0)) if dashed else "solid",
        )

    def disc(self, x: float, y: float, radius: float, fill: str, line: str | None = None) -> None:
        """Paint a disc in mm."""
        self.region(shapely.Point(x, y).buffer(radius), fill, line)

    def image(self, pixels: ByteArray, box: tuple[float, float, float, float], within: shapely.Geometry) -> None:
        """Paint a picture, its first row at the top, into the box (x0, y0, x1, y1) as far as it is in a region; mm."""
        x0, y0, x1, y1 = box
        picture = self.axes.imshow(pixels, extent=(x0, x1, y0, y1), interpolation="none", aspect="auto", zorder=1)
        picture.set_clip_path(_path(within), self.axes.transData)

    def text(
        self,
        x: float,
        y: float,
        words: str,
        size_mm: float = 3.2,
        colour: str = "ink",
        anchor: Anchor = "left",
        weight: str = "normal",
    ) -> None:
        """Write a line whose base line starts (or has its middle or end: ``anchor``) at (x, y)."""
        self.axes.add_artist(
            Text(
                x,
                y,
                words,
                color=LIGHT[colour],
                fontsize=size_mm / POINT_MM,
                fontweight=weight,
                horizontalalignment=anchor,
                verticalalignment="baseline",
                parse_math=False,
                zorder=5,
            )
        )

    def label(self, x: float, y: float, words: str, size_mm: float = 3.2) -> None:
        """Write a word in the middle of a light disc at (x, y)."""
        self.region(shapely.Point(x, y).buffer(0.85 * size_mm), LIGHT["paper"], LIGHT["ink"], 0.15).set_zorder(4)
        self.text(x, y - 0.36 * size_mm, words, size_mm, anchor="center", weight="bold")


def new_page(width: float, height: float) -> Page:
    """An empty page of so many mm."""
    figure = Figure(figsize=(width / MM_PER_INCH, height / MM_PER_INCH), facecolor=LIGHT["paper"])
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set_autoscale_on(False)
    axes.set_xlim(0.0, width)
    axes.set_ylim(0.0, height)
    return Page(figure, axes, width, height)


def pdf_bytes(pages: Sequence[Page]) -> bytes:
    """The pages as a PDF file without a date."""
    stream = io.BytesIO()
    with PdfPages(stream, metadata={"CreationDate": None, "Creator": None, "Producer": None}) as pdf:
        for page in pages:
            pdf.savefig(page.figure)
    return stream.getvalue()


def png_bytes(page: Page, dots_per_inch: float) -> bytes:
    """A page as a PNG file."""
    stream = io.BytesIO()
    FigureCanvasAgg(page.figure).print_figure(stream, format="png", dpi=dots_per_inch, metadata={"Software": None})
    return stream.getvalue()


def _path(region: shapely.Geometry) -> Path:
    rings = [ring for part in polygons(region) for ring in (part.exterior, *part.interiors)]
    paths = [Path(shapely.get_coordinates(ring), closed=True) for ring in rings]
    if not paths:
        return Path(np.empty((0, 2)))
    found: Path = Path.make_compound_path(*paths)
    return found
