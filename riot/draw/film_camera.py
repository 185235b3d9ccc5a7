"""The camera of a film: pictures of the motion, all in one frame. Ours.

Pillow paints them, several pixels for one: ten times as fast as to write SVG, paint it, and pack it as PNG.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

from riot.draw.keyframes import eased, keyframes, motion_marks, swept_box
from riot.draw.palette import LIGHT, PENS, Pen, colour, hue
from riot.draw.panels import shown_from_back, sketch
from riot.draw.piece_image import PieceImage, PieceImages
from riot.draw.scene import Dot, Line, PlacedPiece, Scene, extent, mirrored, placed
from riot.draw.tuning import FILM_MARGIN_PENS, FILM_SUPERSAMPLING, MOTION_PENS, SWEPT_MARGIN, WAY_FRAMES
from riot.motion.planner import motion_of
from riot.transform.pose import rotate
from riot.transform.transform import Transform
from riot.types import FloatArray

Points = list[tuple[float, float]]


class Camera:
    """Takes pictures of ``size`` (width, height), whose height in pixels is a multiple of ``multiple``."""

    def __init__(self, transform: Transform, width: int, multiple: int, images: PieceImages) -> None:
        self._drawn, self.motion = sketch(transform), motion_of(transform)
        x0, y0, x1, y1 = swept_box(self._drawn, keyframes(self.motion, eased(WAY_FRAMES)), margin=SWEPT_MARGIN)
        pixel = (x1 - x0) / width
        height = multiple * max(1, round((y1 - y0) / pixel / multiple))
        box = (x0, y1 - height * pixel, x1, y1)
        self.size = width, height
        self.turns = shown_from_back(self._drawn, images)
        """Whether the puzzle is turned over at the end, because the hand sees Q on its back."""
        self._scene = Scene("", box, (x1 - x0) / MOTION_PENS, self._drawn.pieces, (), images)

    def picture(self, t: float) -> Image.Image:
        """Time t of the motion, from 0 to 1."""
        marks = tuple(motion_marks(self._drawn, self.motion, t))
        return paint(replace(self._scene, marks=marks), self.size)

    def turning(self, share: float) -> Image.Image:
        """The puzzle as Q while it is turned over: the front at share 0, edge-on at a half, the back at 1."""
        closed = motion_marks(self._drawn, self.motion, 1.0)
        x0, _, x1, _ = extent(closed, self._scene.pieces)
        middle, squeeze = 0.5 * (x0 + x1), abs(math.cos(math.pi * share))
        if share > 0.5:
            sides = (replace(mark, side="q") if isinstance(mark, PlacedPiece) else mark for mark in closed)
            closed = mirrored(sides, middle)
        picture = paint(replace(self._scene, marks=tuple(closed)), self.size)
        left, _, right, _ = self._scene.box
        column = (middle - left) / (right - left) * self.size[0]
        stretch = 1.0 / max(squeeze, 1e-3)
        shift = column * (1.0 - stretch)
        return picture.transform(
            self.size, Image.Transform.AFFINE, (stretch, 0.0, shift, 0.0, 1.0, 0.0),
            Image.Resampling.BILINEAR, fillcolor=LIGHT["paper"],
        )  # fmt: skip


def paint(scene: Scene, size: tuple[int, int]) -> Image.Image:
    """Pieces, lines and dots of a scene in a picture of ``size``; other marks are left out.

    >>> paint(Scene("", (0.0, 0.0, 2.0, 1.0), 0.1, (), (Dot(1.0, 0.5, "hinge"),)), (8, 4)).getpixel((4, 2))
    (35, 38, 43)
    """
    picture = Image.new("RGB", size, LIGHT["paper"])
    x0, _, x1, y1 = scene.box
    scale = size[0] / (x1 - x0)
    left, top, right, low = _touched(scene, scale, size)
    if right <= left or low <= top:
        return picture
    canvas = Image.new("RGB", (FILM_SUPERSAMPLING * (right - left), FILM_SUPERSAMPLING * (low - top)), LIGHT["paper"])
    corner = np.array([x0 + left / scale, y1 - top / scale])
    painter = _Painter(scene, canvas, ImageDraw.Draw(canvas), corner, FILM_SUPERSAMPLING * scale)
    for mark in scene.marks:
        if isinstance(mark, PlacedPiece):
            painter.piece(mark)
        elif isinstance(mark, Dot):
            painter.dot(mark)
        elif isinstance(mark, Line):
            painter.line(mark.points, PENS[mark.pen])
    picture.paste(canvas.reduce(FILM_SUPERSAMPLING), (left, top))
    return picture


def _touched(scene: Scene, scale: float, size: tuple[int, int]) -> tuple[int, int, int, int]:
    """The pixels that marks may touch: the others stay paper, and need no painting."""
    left, low, right, high = extent(scene.marks, scene.pieces)
    margin = FILM_MARGIN_PENS * scene.pen
    x0, _, _, y1 = scene.box
    return (
        max(0, math.floor((left - margin - x0) * scale)),
        max(0, math.floor((y1 - high - margin) * scale)),
        min(size[0], math.ceil((right + margin - x0) * scale)),
        min(size[1], math.ceil((y1 - low + margin) * scale)),
    )


@dataclass(frozen=True, eq=False)
class _Painter:
    """Paints on a canvas whose upper left corner is ``corner`` of the scene, ``scale`` pixels for a unit."""

    scene: Scene
    canvas: Image.Image
    draw: ImageDraw.ImageDraw
    corner: FloatArray
    scale: float

    def piece(self, mark: PlacedPiece) -> None:
        scene = self.scene
        piece, image = scene.pieces[mark.piece], scene.image_of(mark)
        outline = placed(mark, piece.polygon)
        if image is None:
            look = PENS[f"piece{hue(mark.piece, len(scene.pieces))}"]
            self.draw.polygon(self._pixels(outline), fill=colour(look.fill or "paper", LIGHT))
            self.line(np.append(outline, outline[:1], axis=0), look, mark.scale)
            self.line(placed(mark, np.array([[0.0, 0.0], [piece.length, 0.0]])), PENS["seam"], mark.scale)
        else:
            self._image(mark, image, self._pixels(outline))
            self.line(np.append(outline, outline[:1], axis=0), PENS["cut"], mark.scale)

    def dot(self, mark: Dot) -> None:
        look, ((x, y),) = PENS[mark.pen], self._pixels(np.array([[mark.x, mark.y]]))
        edge = self._width(look, 1.0) if look.stroke else 0
        reach = mark.radius * self.scene.pen * self.scale + 0.5 * edge
        box = (x - reach, y - reach, x + reach, y + reach)
        self.draw.ellipse(box, colour(look.fill or "paper", LIGHT), colour(look.stroke or "paper", LIGHT), edge)

    def line(self, points: FloatArray, look: Pen, scale: float = 1.0) -> None:
        width, ink = self._width(look, scale), colour(look.stroke or "ink", LIGHT)
        if not look.dash:
            self.draw.line(self._pixels(points), ink, width, joint="curve")
            return
        on, off = (step * scale * self.scene.pen for step in look.dash)
        for start, end in pairwise(points):
            length = float(np.hypot(*(end - start)))
            begins = np.arange(0.0, length, on + off)
            along = (end - start) / length if length else end - start
            for first, last in zip(begins, np.minimum(begins + on, length), strict=True):
                self.draw.line(self._pixels(start + np.outer([first, last], along)), ink, width)

    def _image(self, mark: PlacedPiece, image: PieceImage, outline: Points) -> None:
        """The piece's image, turned and cut to its outline."""
        x, y = zip(*outline, strict=True)
        left, top = max(0, math.floor(min(x))), max(0, math.floor(min(y)))
        right, low = min(self.canvas.width, math.ceil(max(x))), min(self.canvas.height, math.ceil(max(y)))
        if right <= left or low <= top:
            return
        # Pillow asks where in the image each pixel is: from three pixels that follows for all.
        corners = np.array([[left, top], [left + 1.0, top], [left, top + 1.0]]) / [self.scale, -self.scale]
        sides = np.array([-mark.scale if mark.mirror else mark.scale, mark.scale])
        in_piece = rotate(corners + self.corner - [mark.x, mark.y], -mark.heading) / sides
        x0, y0, x1, y1 = image.box
        rows, columns = image.pixels.shape[:2]
        at = (in_piece - [x0, y1]) * [columns / (x1 - x0), -rows / (y1 - y0)]
        (a, d), (b, e) = (at[1] - at[0]).tolist(), (at[2] - at[0]).tolist()
        c, f = at[0].tolist()
        source = Image.fromarray(np.ascontiguousarray(image.pixels))
        shown = source.transform(
            (right - left, low - top), Image.Transform.AFFINE, (a, b, c, d, e, f), Image.Resampling.BILINEAR
        )
        mask = Image.new("1", shown.size)
        ImageDraw.Draw(mask).polygon([(px - left, py - top) for px, py in outline], fill=1)
        self.canvas.paste(shown, (left, top), mask)

    def _pixels(self, points: FloatArray) -> Points:
        at: npt.NDArray[np.float64] = (points - self.corner) * [self.scale, -self.scale]
        return [(x, y) for x, y in at.tolist()]

    def _width(self, look: Pen, scale: float) -> int:
        return max(1, round(look.width * scale * self.scene.pen * self.scale))
