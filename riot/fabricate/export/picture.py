"""Pictures of the puzzle in the hand: assembled and taken apart, as P and as Q, seen from above at a slant. Ours.

The solids' layers are painted from the lowest up, in each layer first the walls, the farthest first, then the upper
faces. In a parallel view from above nothing of a lower layer can hide a part of a higher one, so that this is exact.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import shapely
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_hex, to_rgb
from shapely.geometry.polygon import orient

from riot.draw.files import PictureFormatError
from riot.draw.palette import LIGHT, PIECES, hue
from riot.fabricate.export.paper import MM_PER_INCH, Frame, Page, new_page, png_bytes
from riot.fabricate.export.sheets import face, painted
from riot.fabricate.model import polygons
from riot.fabricate.telescope import Ring

if TYPE_CHECKING:
    from riot.draw.texture.names import Side
    from riot.draw.texture.paint import Texture
    from riot.fabricate.model import Design
    from riot.types import FloatArray

ELEVATION = math.radians(52.0)
"""Of the eye over the plane."""

APART = 0.3
"""Taken apart, every piece moves from the middle by this share of its distance."""

RAISED = 1.6
"""Taken apart, a pin stands this many thicknesses over the pieces."""

DOTS_PER_INCH = 220.0
MARGIN_MM = 6.0

_LINE_MM = 0.25
_METAL = "#9aa3ad"
_THIN = 0.02


@dataclass(frozen=True, eq=False)
class Body:
    """A solid in the picture: layers (low, high, region on the plane), mm, lowest first, and its colour."""

    layers: tuple[tuple[float, float, shapely.Geometry], ...]
    colour: str


def draw_puzzle(
    design: Design,
    path: str | os.PathLike[str],
    side: Side,
    *,
    apart: bool = False,
    textures: Mapping[Side, Texture] | None = None,
) -> None:
    """Draw the assembled puzzle, or the same taken apart with its pins over the hinges, as a PNG file.

    As P it is seen from the front, with P's texture if there is one. As Q it is seen from the back if there is a
    texture of Q, which is mirrored there as the outline is; from the front else, in plain colours. The same input gives
    the same bytes. Raises `riot.draw.files.PictureFormatError` for a suffix other than .png.
    """
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise PictureFormatError(f"cannot draw {target.name!r}: use a file name that ends in .png")
    target.write_bytes(png_bytes(puzzle_page(design, side, apart=apart, textures=textures), DOTS_PER_INCH))


def puzzle_page(
    design: Design, side: Side, *, apart: bool = False, textures: Mapping[Side, Texture] | None = None
) -> Page:
    """The picture of `draw_puzzle` before it has a format."""
    texture = (textures or {}).get(side)
    back = side == "q" and texture is not None
    frames = _frames(design, side, back, APART if apart else 0.0)
    bodies = [_body(design, i, frame, back) for i, frame in enumerate(frames)]
    low, high = _extent(bodies)
    raised = (RAISED + 1.0) * design.parameters.height * math.cos(ELEVATION) if apart else 0.0
    width, height = (high - low + 2 * MARGIN_MM + np.array([0.0, raised])).tolist()
    page = new_page(width, height)
    shift = MARGIN_MM - low
    # Everything is moved so that the picture starts at the page's corner.
    move = Frame(0.0, float(shift[0]), float(shift[1]) / math.sin(ELEVATION))
    moved = [
        Body(tuple((bottom, top, move.region(region)) for bottom, top, region in body.layers), body.colour)
        for body in bodies
    ]
    placed = [Frame(frame.angle, frame.x + _signed(move.x, frame), frame.y + move.y, frame.mirror) for frame in frames]
    _paint(page, moved)
    if texture is not None:
        for i, frame in enumerate(placed):
            _face(page, design, texture, side, i, frame)
    if apart:
        _pins(page, design, placed)
    return page


def _signed(x: float, frame: Frame) -> float:
    return x if frame.mirror is None else -x


def _frames(design: Design, side: Side, back: bool, apart: float) -> list[Frame]:
    """Where the pieces lie: closed as P or Q, seen from the front or the back, moved from their middle."""
    pose = design.transform.pose(0.0 if side == "p" else 1.0)
    origins = design.scale * pose.origins
    outlines = [
        Frame(float(heading), float(x), float(y)).region(shapely.Polygon(piece.outline))
        for piece, heading, (x, y) in zip(design.pieces, pose.headings, origins, strict=True)
    ]
    middle = shapely.get_coordinates(shapely.union_all(outlines).centroid)[0]
    frames = []
    for outline, heading, origin in zip(outlines, pose.headings, origins, strict=True):
        x, y = origin + apart * (shapely.get_coordinates(outline.centroid)[0] - middle)
        frames.append(Frame(float(heading), float(x), float(y), 0.0 if back else None))
    return frames


def _body(design: Design, index: int, frame: Frame, back: bool) -> Body:
    height = design.parameters.height
    layers = [(slab.low, slab.high, frame.region(slab.section)) for slab in design.pieces[index].slabs]
    if back:
        layers = [(height - high, height - low, region) for low, high, region in reversed(layers)]
    return Body(tuple(layers), PIECES[hue(index, len(design.pieces))])


def _screen(points: FloatArray, z: float) -> FloatArray:
    """(k, 2) points of the plane at a height, as seen; mm."""
    return np.column_stack([points[:, 0], points[:, 1] * math.sin(ELEVATION) + z * math.cos(ELEVATION)])


def _seen(region: shapely.Geometry, z: float) -> shapely.Geometry:
    return shapely.transform(region, lambda points: _screen(points, z))


def _extent(bodies: list[Body]) -> tuple[FloatArray, FloatArray]:
    bounds = np.array([_seen(region, z).bounds for body in bodies for *zs, region in body.layers for z in zs])
    return bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0)


def _paint(page: Page, bodies: list[Body]) -> None:
    levels = sorted({z for body in bodies for low, high, _ in body.layers for z in (low, high)})
    for bottom, top in pairwise(levels):
        cut = [(body, region) for body in bodies for low, high, region in body.layers if low <= bottom and top <= high]
        quads, colours, far = [], [], []
        for body, region in cut:
            for start, end in _near_edges(region):
                quads.append(np.concatenate([_screen(np.array([start, end]), z) for z in (bottom, top)])[[0, 1, 3, 2]])
                colours.append(_shaded(body.colour, start, end))
                far.append(start[1] + end[1])
        order = np.argsort(-np.array(far), kind="stable")
        walls = [quads[k] for k in order], [colours[k] for k in order]
        page.axes.add_collection(
            PolyCollection(walls[0], facecolors=walls[1], edgecolors=walls[1], linewidths=0.3, zorder=1), autolim=False
        )
        for body, region in cut:
            above = [higher for low, high, higher in body.layers if low <= top < high]
            bare = not above or shapely.area(shapely.difference(region, above[0])) > _THIN * shapely.area(region)
            patch = page.region(_seen(region, top), body.colour, _darker(body.colour, 0.55) if bare else None, _LINE_MM)
            patch.set_zorder(1)


def _near_edges(region: shapely.Geometry) -> list[tuple[FloatArray, FloatArray]]:
    """Edges whose wall faces the eye."""
    found = []
    for part in polygons(region):
        turned = orient(part)
        for ring in (turned.exterior, *turned.interiors):
            points = shapely.get_coordinates(ring)
            found += [(a, b) for a, b in pairwise(points) if b[0] > a[0]]
    return found


def _shaded(colour: str, start: FloatArray, end: FloatArray) -> str:
    """A wall's colour: darker the more it turns from the light, which comes from the left in front."""
    step = (end - start) / np.hypot(*(end - start))
    normal = np.array([step[1], -step[0]])
    return _darker(colour, 0.52 + 0.26 * float(normal @ np.array([-0.6, -0.8])))


def _darker(colour: str, share: float) -> str:
    return str(to_hex([share * part for part in to_rgb(colour)]))


def _face(page: Page, design: Design, texture: Texture, side: Side, index: int, frame: Frame) -> None:
    """Paint the texture on the upper face of a piece; knuckles keep the piece's colour."""
    region, top = frame.region(face(design, index, side)), design.parameters.height
    step = MM_PER_INCH / DOTS_PER_INCH
    pixels, (x0, y0, x1, y1) = painted(design, texture, side, index, frame, region, step)
    (left, low), (right, high) = _screen(np.array([[x0, y0], [x1, y1]]), top)
    page.image(pixels, (left, low, right, high), _seen(region, top))
    page.region(_seen(region, top), None, LIGHT["ink"], 0.15).set_zorder(2)


def _pins(page: Page, design: Design, frames: list[Frame]) -> None:
    """A pin over every pin hinge, a sleeve over every telescopic one, and dashes from it to the two pieces it joins."""
    height, pin = design.parameters.height, design.parameters.pin_mm
    bodies = []
    for index, piece in enumerate(design.pieces):
        if piece.start.kind == "open":
            continue
        before = design.pieces[index - 1]
        ends = np.concatenate(
            [
                frames[index].paper(np.array([[piece.start.x, piece.start.y]])),
                frames[index - 1].paper(np.array([[before.end.x, before.end.y]])),
            ]
        )
        middle = ends.mean(axis=0)
        low = RAISED * height
        for end in ends:
            way = np.concatenate([_screen(end[None], height), _screen(middle[None], low)])
            page.line(way, LIGHT["muted"], 0.25, dashed=True)
        axis = shapely.Point(middle)
        rings: tuple[Ring, ...] = (Ring(0.0, height, 0.5 * pin),)
        if piece.start.kind == "telescopic" and design.telescope is not None:
            rings = design.telescope.sleeve
        layers = [
            (low + ring.low, low + ring.high, axis.buffer(ring.radius).difference(axis.buffer(ring.hole)))
            for ring in rings
        ]
        bodies.append(Body(tuple(layers), _METAL))
    if bodies:
        over = len(page.axes.patches), len(page.axes.collections)
        _paint(page, bodies)
        for patch in (*page.axes.patches[over[0] :], *page.axes.collections[over[1] :]):
            patch.set_zorder(3)
