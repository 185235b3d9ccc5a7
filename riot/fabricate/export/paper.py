"""Paper: scenes measured in millimetres from the lower left corner, and how pieces lie on them. Ours."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import shapely
from shapely.geometry.polygon import orient

from riot.draw.scene import Dot, Label, Mark, Region, Scene
from riot.fabricate.model import polygons
from riot.transform.pose import rotate

if TYPE_CHECKING:
    from riot.types import FloatArray

MM_PER_INCH = 25.4

PEN_MM = 0.2
"""One pen on paper."""


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
        return self._seen(rotate(points, self.angle) + np.array([self.x, self.y]))

    def piece(self, points: FloatArray) -> FloatArray:
        """Map (k, 2) points of the paper to the piece's frame."""
        in_frame: FloatArray = rotate(self._seen(points) - np.array([self.x, self.y]), -self.angle)
        return in_frame

    def region(self, region: shapely.Geometry) -> shapely.Geometry:
        """A region of the piece's frame on the paper."""
        return shapely.normalize(shapely.transform(region, self.paper))

    def _seen(self, points: FloatArray) -> FloatArray:
        return points if self.mirror is None else np.column_stack([self.mirror - points[:, 0], points[:, 1]])


def sheet(title: str, width: float, height: float, marks: Iterable[Mark]) -> Scene:
    """A page of so many mm."""
    return Scene(title, (0.0, 0.0, width, height), PEN_MM, (), tuple(marks))


def rings(region: shapely.Geometry) -> tuple[FloatArray, ...]:
    """The rings of a region of polygons, outer ones counter-clockwise and holes clockwise, each point once.

    Examples
    --------
    >>> import shapely
    >>> [len(ring) for ring in rings(shapely.box(0.0, 0.0, 9.0, 9.0) - shapely.box(1.0, 1.0, 2.0, 2.0))]
    [4, 4]
    """
    oriented = (orient(polygon) for polygon in polygons(region))
    return tuple(
        shapely.get_coordinates(ring)[:-1] for polygon in oriented for ring in (polygon.exterior, *polygon.interiors)
    )


def region_mark(region: shapely.Geometry, pen: str) -> Region:
    """A region in mm as a mark."""
    return Region(rings(region), pen)


def text(
    x: float,
    y: float,
    words: str,
    size_mm: float = 3.2,
    pen: str = "caption",
    anchor: str = "start",
    weight: str = "normal",
) -> Label:
    """A line whose base line starts (or has its middle or end: ``anchor``) at (x, y)."""
    return Label(x, y, words, pen, size_mm / PEN_MM, anchor, weight)


def disc(x: float, y: float, pen: str, radius_mm: float) -> Dot:
    """A disc."""
    return Dot(x, y, pen, radius_mm / PEN_MM)


def number_marks(x: float, y: float, number: int, size_mm: float) -> list[Mark]:
    """A number in the middle of a light disc at (x, y)."""
    return [
        disc(x, y, "open", 0.85 * size_mm),
        text(x, y - 0.36 * size_mm, str(number), size_mm, anchor="middle", weight="bold"),
    ]
