"""A picture before it has a format: a few kinds of marks in the plane, y upwards, which SVG, PNG and PDF all show."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from riot.draw.piece_image import NO_IMAGES, PieceImage, PieceImages
from riot.transform.pose import rotate
from riot.transform.transform import Piece
from riot.types import FloatArray

Box = tuple[float, float, float, float]
"""x0, y0, x1, y1 with x0 < x1 and y0 < y1."""


@dataclass(frozen=True, eq=False)
class Region:
    """Polygons with holes: (k, 2) rings, outer ones counter-clockwise and holes clockwise."""

    rings: tuple[FloatArray, ...]
    pen: str


@dataclass(frozen=True, eq=False)
class Line:
    """(k, 2) points joined by straight lines."""

    points: FloatArray
    pen: str


@dataclass(frozen=True)
class PlacedPiece:
    """Piece ``piece`` of the scene, its frame turned by ``heading`` (radians), scaled, and moved to (x, y).

    ``side`` says which of its images shows, if the scene has images of that side: the front, "p", or "q". A piece that
    is seen from the back, ``mirror``, has its frame mirrored (x to −x) before it is turned.
    """

    piece: int
    x: float
    y: float
    heading: float = 0.0
    scale: float = 1.0
    side: str = "p"
    mirror: bool = False


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


@dataclass(frozen=True, eq=False)
class Bitmap:
    """A picture, (rows, columns, 3) uint8, first row on top, that fills a box; only what is in ``clip`` shows.

    ``clip`` has rings as `Region`; None shows all.
    """

    pixels: npt.NDArray[np.uint8]
    box: Box
    clip: tuple[FloatArray, ...] | None = None


Mark = Region | Line | PlacedPiece | Dot | Label | Bitmap


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
        What the `PlacedPiece` marks place: drawn once, used often, so that a piece looks the same wherever it lies.
    marks : tuple of Mark
    images : PieceImages
        What the pieces look like; of sides without images every piece has its colour.

    Examples
    --------
    >>> import numpy as np
    >>> triangle = Region((np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]]),), "silhouette")
    >>> scene = Scene("a triangle", (0.0, 0.0, 2.0, 1.0), 0.01, (), (triangle,))
    >>> extent(moved(scene.marks, 1.0, 0.0, 2.0), scene.pieces)
    (1.0, 0.0, 5.0, 2.0)
    """

    title: str
    box: Box
    pen: float
    pieces: tuple[Piece, ...]
    marks: tuple[Mark, ...]
    images: PieceImages = field(default_factory=lambda: NO_IMAGES)

    def image_of(self, placed_piece: PlacedPiece) -> PieceImage | None:
        """What is seen of a piece; None for its colour."""
        side, piece = placed_piece.side, placed_piece.piece
        return self.images[side][piece] if side in self.images else None


def moved(marks: Iterable[Mark], x: float, y: float, scale: float = 1.0) -> list[Mark]:
    """The marks scaled about the origin and then shifted by (x, y); labels keep their size, dots at least half.

    >>> moved([Dot(1.0, 2.0, "hinge")], 10.0, 0.0, 2.0)[0].x
    12.0
    """
    shift = np.array([x, y])
    result: list[Mark] = []
    for mark in marks:
        if isinstance(mark, Region):
            result.append(replace(mark, rings=tuple(ring * scale + shift for ring in mark.rings)))
        elif isinstance(mark, Line):
            result.append(replace(mark, points=mark.points * scale + shift))
        elif isinstance(mark, Bitmap):
            x0, y0, x1, y1 = mark.box
            box = (x0 * scale + x, y0 * scale + y, x1 * scale + x, y1 * scale + y)
            clip = None if mark.clip is None else tuple(ring * scale + shift for ring in mark.clip)
            result.append(replace(mark, box=box, clip=clip))
        elif isinstance(mark, PlacedPiece):
            result.append(replace(mark, x=mark.x * scale + x, y=mark.y * scale + y, scale=mark.scale * scale))
        elif isinstance(mark, Dot):
            radius = mark.radius * max(0.5, min(1.0, scale))
            result.append(replace(mark, x=mark.x * scale + x, y=mark.y * scale + y, radius=radius))
        else:
            result.append(replace(mark, x=mark.x * scale + x, y=mark.y * scale + y))
    return result


def mirrored(marks: Iterable[Mark], x: float = 0.0) -> list[Mark]:
    """The marks as they are seen from the back, turned over about the vertical at x.

    >>> mirrored([Dot(1.0, 2.0, "hinge")], 2.0)[0].x
    3.0
    """
    result: list[Mark] = []
    for mark in marks:
        if isinstance(mark, Region):
            result.append(replace(mark, rings=tuple(_flipped(ring, x)[::-1] for ring in mark.rings)))
        elif isinstance(mark, Line):
            result.append(replace(mark, points=_flipped(mark.points, x)))
        elif isinstance(mark, Bitmap):
            x0, y0, x1, y1 = mark.box
            clip = None if mark.clip is None else tuple(_flipped(ring, x)[::-1] for ring in mark.clip)
            result.append(replace(mark, pixels=mark.pixels[:, ::-1], box=(2 * x - x1, y0, 2 * x - x0, y1), clip=clip))
        elif isinstance(mark, PlacedPiece):
            result.append(replace(mark, x=2 * x - mark.x, heading=-mark.heading, mirror=not mark.mirror))
        else:
            result.append(replace(mark, x=2 * x - mark.x))
    return result


def _flipped(points: FloatArray, x: float) -> FloatArray:
    flipped: FloatArray = points * [-1.0, 1.0] + [2 * x, 0.0]
    return flipped


def placed(piece: PlacedPiece, points: FloatArray) -> FloatArray:
    """(k, 2) points of a piece's frame where the piece lies in the scene.

    >>> placed(PlacedPiece(0, 1.0, 0.0, 0.0), np.array([[1.0, 2.0]])).tolist()
    [[2.0, 2.0]]
    """
    sides = np.array([-piece.scale if piece.mirror else piece.scale, piece.scale])
    in_scene: FloatArray = rotate(points * sides, piece.heading) + np.array([piece.x, piece.y])
    return in_scene


def extent(marks: Iterable[Mark], pieces: tuple[Piece, ...]) -> Box:
    """The smallest box around all marks; of dots the centres count, labels do not.

    >>> extent([Dot(1.0, 2.0, "hinge"), Dot(3.0, -1.0, "hinge")], ())
    (1.0, -1.0, 3.0, 2.0)
    """
    clouds: list[FloatArray] = []
    for mark in marks:
        if isinstance(mark, Region):
            clouds += mark.rings
        elif isinstance(mark, Line):
            clouds.append(mark.points)
        elif isinstance(mark, Bitmap):
            clouds.append(np.array(mark.box).reshape(2, 2))
        elif isinstance(mark, PlacedPiece):
            clouds.append(placed(mark, pieces[mark.piece].polygon))
        elif isinstance(mark, Dot):
            clouds.append(np.array([[mark.x, mark.y]]))
    points = np.concatenate(clouds)
    low, high = points.min(axis=0), points.max(axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def swept(points: FloatArray, headings: FloatArray, origins: FloatArray) -> Box:
    """The smallest box around (k, 2) points turned by each of the headings (m,), radians, and moved by its origin.

    >>> swept(np.array([[1.0, 0.0], [2.0, 0.0]]), np.array([0.0]), np.array([[5.0, 0.0]]))
    (6.0, 0.0, 7.0, 0.0)
    """
    cosines, sines = np.cos(headings)[:, None], np.sin(headings)[:, None]
    x = points[:, 0] * cosines - points[:, 1] * sines + origins[:, :1]
    y = points[:, 0] * sines + points[:, 1] * cosines + origins[:, 1:]
    return float(x.min()), float(y.min()), float(x.max()), float(y.max())


def around(boxes: Iterable[Box], margin: float = 0.0) -> Box:
    """The smallest box around boxes, and a margin.

    >>> around([(0.0, 0.0, 1.0, 1.0), (2.0, 0.0, 3.0, 0.5)], 0.5)
    (-0.5, -0.5, 3.5, 1.5)
    """
    x0, y0, x1, y1 = zip(*boxes, strict=True)
    return min(x0) - margin, min(y0) - margin, max(x1) + margin, max(y1) + margin
