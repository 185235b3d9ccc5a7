"""A picture before it has a format: a few kinds of marks in the plane, y upwards, which any writer can paint."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from riot.draw.skin import PLAIN, Skin, Skins
from riot.transform.pose import rotate
from riot.transform.transform import Piece
from riot.types import FloatArray

Box = tuple[float, float, float, float]
"""x0, y0, x1, y1 with x0 < x1 and y0 < y1."""


@dataclass(frozen=True, eq=False)
class Path:
    """(k, 2) points joined by straight lines; a closed path can be filled."""

    points: FloatArray
    pen: str
    closed: bool = True


@dataclass(frozen=True)
class Part:
    """Piece ``piece`` of the scene, its frame turned by ``heading`` (radians), scaled, and moved to (x, y).

    ``side`` says which of its skins shows, if the scene has skins of that side: the front, "p", or "q".
    """

    piece: int
    x: float
    y: float
    heading: float = 0.0
    scale: float = 1.0
    side: str = "p"


@dataclass(frozen=True)
class Dot:
    """A small disc; the radius is in pens, so that it does not shrink with the drawing."""

    x: float
    y: float
    pen: str
    radius: float = 3.0


@dataclass(frozen=True)
class Label:
    """One line of text whose base line starts, is centred or ends at (x, y); the size is in pens."""

    x: float
    y: float
    text: str
    pen: str = "caption"
    size: float = 13.0
    anchor: str = "middle"
    weight: str = "normal"


Mark = Path | Part | Dot | Label


@dataclass(frozen=True, eq=False)
class Scene:
    """Marks, painted in order, within a box.

    Parameters
    ----------
    title : str
        What the picture shows, in words, for those who cannot see it.
    box : Box
        What is visible.
    pen : float
        Width of one pen (about a pixel) in the units of the scene.
    pieces : tuple of Piece
        What the `Part` marks place: drawn once, used often, so that a piece looks the same wherever it lies.
    marks : tuple of Mark
    skins : Skins
        What the pieces look like; of sides without skins every piece has its colour.
    """

    title: str
    box: Box
    pen: float
    pieces: tuple[Piece, ...]
    marks: tuple[Mark, ...]
    skins: Skins = field(default_factory=lambda: PLAIN)

    def skin(self, part: Part) -> Skin | None:
        """What is seen of a part; None for its colour."""
        return self.skins[part.side][part.piece] if part.side in self.skins else None


def moved(marks: Iterable[Mark], x: float, y: float, scale: float = 1.0) -> list[Mark]:
    """The marks scaled about the origin and then shifted by (x, y); labels keep their size, dots at least half."""
    found: list[Mark] = []
    for mark in marks:
        if isinstance(mark, Path):
            found.append(replace(mark, points=mark.points * scale + np.array([x, y])))
        elif isinstance(mark, Part):
            found.append(replace(mark, x=mark.x * scale + x, y=mark.y * scale + y, scale=mark.scale * scale))
        elif isinstance(mark, Dot):
            radius = mark.radius * max(0.5, min(1.0, scale))
            found.append(replace(mark, x=mark.x * scale + x, y=mark.y * scale + y, radius=radius))
        else:
            found.append(replace(mark, x=mark.x * scale + x, y=mark.y * scale + y))
    return found


def placed(part: Part, points: FloatArray) -> FloatArray:
    """(k, 2) points of a piece's frame where the part lies in the scene."""
    found: FloatArray = rotate(points * part.scale, part.heading) + np.array([part.x, part.y])
    return found


def extent(marks: Iterable[Mark], pieces: tuple[Piece, ...]) -> Box:
    """The smallest box around all paths, parts and the centres of dots; labels do not count."""
    clouds = []
    for mark in marks:
        if isinstance(mark, Path):
            clouds.append(mark.points)
        elif isinstance(mark, Part):
            clouds.append(placed(mark, pieces[mark.piece].polygon))
        elif isinstance(mark, Dot):
            clouds.append(np.array([[mark.x, mark.y]]))
    points = np.concatenate(clouds)
    low, high = points.min(axis=0), points.max(axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def swept(points: FloatArray, headings: FloatArray, origins: FloatArray) -> Box:
    """The smallest box around (k, 2) points turned by each of the headings (m,), radians, and moved by its origin."""
    cosines, sines = np.cos(headings)[:, None], np.sin(headings)[:, None]
    x = points[:, 0] * cosines - points[:, 1] * sines + origins[:, :1]
    y = points[:, 0] * sines + points[:, 1] * cosines + origins[:, 1:]
    return float(x.min()), float(y.min()), float(x.max()), float(y.max())


def around(boxes: Iterable[Box], margin: float = 0.0) -> Box:
    """The smallest box around boxes, and a margin."""
    x0, y0, x1, y1 = zip(*boxes, strict=True)
    return min(x0) - margin, min(y0) - margin, max(x1) + margin, max(y1) + margin
