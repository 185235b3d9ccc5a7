"""Shape: one simple closed polygon of unit area, counter-clockwise, centroid at the origin (paper §4, §6).

A shape is data; `riot.geometry.silhouette` reads it from pictures, vector files and polygons.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from riot.content import ByContent, count
from riot.errors import SilhouetteError
from riot.geometry.quality import ReadingQuality
from riot.types import BoolArray, FloatArray

UNIT_AREA_TOLERANCE = 1e-6
"""Greatest difference of a shape's area from 1. Ours: far above rounding."""


@dataclass(frozen=True, eq=False)
class Shape(ByContent):
    """A silhouette as a polygon: unit area, counter-clockwise, centroid at the origin, y upwards.

    Parameters
    ----------
    points : (m, 2) float64
        Boundary points, each once (the last joins the first). Feature points and points between them, closer
        than ``L_c / spacing``; the first is chosen by geometry, not by the input's start vertex.
    feature : (m,) bool
        True at the main feature points (Douglas–Peucker), False at the points inserted between them.
    name : str
        For messages, tables and pictures.
    to_source : (2, 3) float64
        Affine map from the shape's frame to the source's coordinates (pixels as x = column, y = row; or the
        polygon's own): ``source = to_source[:, :2] @ point + to_source[:, 2]``.
    quality : ReadingQuality, optional
        How well it was read from its source; None if it was not, or that is not known. It is no part of the content:
        shapes that differ by it alone are equal.

    Raises
    ------
    SilhouetteError
        ``degenerate``: arrays of other shapes or types, or an area other than 1. `from_polygon` takes any polygon.
    """

    points: FloatArray
    feature: BoolArray
    name: str = ""
    to_source: FloatArray = field(default_factory=lambda: np.eye(2, 3))
    quality: ReadingQuality | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        """Refuse what no function of the library would understand."""
        points = self.points
        if not isinstance(points, np.ndarray) or points.ndim != 2 or points.shape[1] != 2 or len(points) < 3:
            raise SilhouetteError(
                "degenerate", f"{self._who}: points is an (m, 2) array, m ≥ 3; use Shape.from_polygon"
            )
        if points.dtype != np.float64 or not np.isfinite(points).all():
            raise SilhouetteError("degenerate", f"{self._who}: points are finite float64; use Shape.from_polygon")
        if np.shape(self.feature) != points.shape[:1] or np.shape(self.to_source) != (2, 3):
            raise SilhouetteError(
                "degenerate", f"{self._who}: feature is ({len(points)},) and to_source (2, 3); use Shape.from_polygon"
            )
        x, y = points.T
        area = 0.5 * float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
        if not abs(area - 1.0) < UNIT_AREA_TOLERANCE:
            raise SilhouetteError(
                "degenerate",
                f"{self._who}: the points enclose {area:.6g}, not 1 counter-clockwise; use Shape.from_polygon",
            )

    def __repr__(self) -> str:
        return f"Shape({self.name!r}, {count(len(self.points), 'point')})"

    @property
    def _who(self) -> str:
        return self.name or "the shape"

    @property
    def perimeter(self) -> float:
        """Length of the boundary, in the unit-area frame."""
        return float(np.linalg.norm(np.roll(self.points, -1, axis=0) - self.points, axis=1).sum())

    def source(self, xy: npt.ArrayLike) -> FloatArray:
        """Map (k, 2) points of the shape's frame to the source's coordinates.

        >>> house.source([[0.0, 0.0]]).round(3)  # the centroid, in the polygon's own coordinates
        array([[2.   , 2.042]])
        """
        return np.asarray(xy, dtype=np.float64) @ self.to_source[:, :2].T + self.to_source[:, 2]

    def from_source(self, xy: npt.ArrayLike) -> FloatArray:
        """Map (k, 2) points of the source's coordinates (pixels, or the polygon's own) to the shape's frame.

        >>> house.from_source(house.source([[0.1, 0.2]])).round(3)
        array([[0.1, 0.2]])
        """
        inverse = np.linalg.inv(self.to_source[:, :2])
        return (np.asarray(xy, dtype=np.float64) - self.to_source[:, 2]) @ inverse.T

    def renamed(self, name: str) -> Shape:
        """The same shape under another name.

        >>> house.renamed("home").name
        'home'
        """
        return replace(self, name=name)

    def mirrored(self) -> Shape:
        """The mirror image, about the vertical through the centroid; ``to_source`` still leads to the same source.

        >>> bool((house.mirrored().source([[-0.1, 0.2]]) == house.source([[0.1, 0.2]])).all())
        True
        """
        return replace(
            self,
            points=np.roll(self.points[::-1] * [-1.0, 1.0], 1, axis=0),
            feature=np.roll(self.feature[::-1], 1),
            to_source=self.to_source * [-1.0, 1.0, 1.0],
        )
