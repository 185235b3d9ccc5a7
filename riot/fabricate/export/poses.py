"""Poses of the flat pieces on paper. Ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import shapely
import shapely.ops

from riot.draw.keyframes import painting_order
from riot.draw.palette import hue
from riot.draw.scene import Mark, Region
from riot.fabricate.export.paper import Frame, disc, number_marks
from riot.transform.pose import Pose

if TYPE_CHECKING:
    from riot.fabricate.model import Design, PieceDesign
    from riot.types import FloatArray


def closed(design: Design, t: float) -> list[Frame]:
    """The pieces closed as P (t = 0) or Q (1), as the hand sees them: Q from the back if it was mirrored for that."""
    frames = frames_of(design, design.transform.pose(t))
    back = t == 1.0 and design.transform.mirrored_q
    return [replace(frame, mirror=0.0) for frame in frames] if back else frames


def chain(design: Design) -> list[Frame]:
    """The chain laid out straight from the open hinge."""
    n, x = len(design.pieces), 0.0
    frames = [Frame(0.0, 0.0, 0.0)] * n
    for k in range(n):
        i = (design.motion.open_hinge + k) % n
        frames[i] = Frame(0.0, x, 0.0)
        x += design.pieces[i].length
    return frames


def frames_of(design: Design, pose: Pose) -> list[Frame]:
    """How the pieces lie in a pose, in mm."""
    origins = (design.scale * pose.origins).tolist()
    return [Frame(heading, x, y) for heading, (x, y) in zip(pose.headings.tolist(), origins, strict=True)]


def _box(frames: Sequence[Frame], design: Design) -> FloatArray:
    """(2, 2) lower left and upper right corner of the pieces."""
    points = np.concatenate([frame.paper(piece.outline) for frame, piece in zip(frames, design.pieces, strict=True)])
    return np.stack([points.min(axis=0), points.max(axis=0)])


def size_of(frames: Sequence[Frame], design: Design) -> FloatArray:
    """Width and height of the pieces, mm."""
    low, high = _box(frames, design)
    size: FloatArray = high - low
    return size


def fit(frames: Sequence[Frame], design: Design, width: float, height: float) -> float:
    """The scale, at most 1, at which the pieces fit."""
    wide, high = size_of(frames, design).tolist()
    return min(1.0, width / float(wide), height / float(high))


def ratio(scale: float) -> str:
    """A scale in words."""
    return "true size" if scale == 1.0 else f"scale 1 : {1.0 / scale:.3g}"


def drawn(
    design: Design,
    frames: Sequence[Frame],
    scale: float,
    x: float,
    y: float,
    *,
    numbers: bool = False,
    hinges: bool = False,
) -> list[Mark]:
    """The pieces about (x, y), higher planes of the motion over lower ones."""
    n = len(design.pieces)
    shift = np.array([x, y]) - scale * _box(frames, design).mean(axis=0)
    marks: list[Mark] = [
        Region((scale * frames[i].paper(design.pieces[i].outline) + shift,), f"piece{hue(i, n)}")
        for i in painting_order(design.motion)
    ]
    if hinges:
        marks += _hinges(design, frames, scale, shift)
    if numbers:
        for i, piece in enumerate(design.pieces):
            middle = shapely.maximum_inscribed_circle(shapely.Polygon(piece.outline)).coords[0]
            ((at_x, at_y),) = (scale * frames[i].paper(np.array([middle])) + shift).tolist()
            marks += number_marks(at_x, at_y, i + 1, 2.8)
    return marks


def _on_piece(piece: PieceDesign, x: float, frame: Frame, is_open: bool) -> FloatArray:
    """A hinge at x of a piece's edge on paper; an open one, whose narrow corner is cut away, where the piece is."""
    point = shapely.Point(x, 0.0)
    if is_open:
        point = shapely.ops.nearest_points(shapely.Polygon(piece.outline), point)[0]
    on_paper: FloatArray = frame.paper(shapely.get_coordinates(point))[0]
    return on_paper


def _hinges(design: Design, frames: Sequence[Frame], scale: float, shift: FloatArray) -> list[Mark]:
    n, first = len(design.pieces), design.motion.open_hinge
    radius = max(0.6, 0.5 * scale * design.parameters.pin_mm)
    marks: list[Mark] = []
    for i, (piece, frame) in enumerate(zip(design.pieces, frames, strict=True)):
        start = scale * _on_piece(piece, 0.0, frame, i == first) + shift
        marks.append(disc(float(start[0]), float(start[1]), "open" if i == first else "hinge", radius))
        if piece.start.kind == "telescopic":
            marks.append(disc(float(start[0]), float(start[1]), "open", 0.5 * radius))
        if (i + 1) % n == first:
            end = scale * _on_piece(piece, piece.length, frame, True) + shift
            marks.append(disc(float(end[0]), float(end[1]), "open", radius))
    return marks
