"""Pictures of the puzzle in the hand: assembled and taken apart, as P and as Q, seen from above at a slant. Ours."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import shapely
from PIL import Image, ImageDraw, ImageFont

from riot.draw.files import PictureFormatError
from riot.draw.palette import LIGHT, PIECES, hue
from riot.draw.raster import font_files
from riot.draw.solid import Body, Eye, View, png_of_view, prisms, render, ribbon
from riot.fabricate.export.faces import face, face_colours
from riot.fabricate.export.inlay import InlayTexture
from riot.fabricate.export.paper import MM_PER_INCH, Frame, rings
from riot.fabricate.rings import Ring

if TYPE_CHECKING:
    from riot.draw.solid import ByteArray
    from riot.draw.texture.names import Side
    from riot.draw.texture.paint import Texture
    from riot.fabricate.model import Design
    from riot.types import BoolArray, FloatArray

EYE = Eye(math.radians(-90.0), math.radians(52.0))

APART_SHARE = 0.3
"""Taken apart, every piece moves from the middle by this share of its distance."""

PIN_LIFT = 1.6
"""Taken apart, a pin stands this many thicknesses over the pieces."""

NUMBER_MM = 7.0
"""Diameter of the disc under a piece's number."""

PICTURE_DOTS_PER_INCH = 220.0
PICTURE_MARGIN_MM = 6.0

PIXEL_MM = MM_PER_INCH / PICTURE_DOTS_PER_INCH
METAL = "#9aa3ad"
_DASH_MM, _DASH_WIDTH_MM = 1.25, 0.3


def draw_puzzle(
    design: Design,
    path: str | os.PathLike[str],
    side: Side,
    *,
    apart: bool = False,
    textures: Mapping[Side, Texture] | None = None,
) -> None:
    """Draw the assembled puzzle, or the same taken apart with its pins over the hinges, as a PNG file.

    Pieces have their numbers, unless a texture is on the assembled ones. As P it is seen from the front, with P's
    texture if there is one. As Q it is seen from the back if Q was mirrored to be read there, or if there is a texture
    of Q, which is mirrored there as the outline is; from the front else, in plain colours. The same input gives the
    same bytes. Raises `riot.draw.files.PictureFormatError` for a suffix other than .png.
    """
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise PictureFormatError(f"cannot draw {target.name!r}: use a file name that ends in .png")
    target.write_bytes(png_of_puzzle(puzzle_view(design, side, apart=apart, textures=textures)))


def png_of_puzzle(view: View) -> bytes:
    """A view as a PNG file with a margin."""
    return png_of_view(view, round(PICTURE_MARGIN_MM / PIXEL_MM))


def puzzle_view(
    design: Design, side: Side, *, apart: bool = False, textures: Mapping[Side, Texture] | None = None
) -> View:
    """The picture of `draw_puzzle` before it has a format, without a margin."""
    texture = (textures or {}).get(side)
    back = side == "q" and (texture is not None or design.transform.mirrored_q)
    frames = _frames(design, side, back, APART_SHARE if apart else 0.0)
    bodies = [piece_body(design, i, frame, back, side, texture) for i, frame in enumerate(frames)]
    bodies += _pins(design, frames) if apart else _pushed_in(design, frames, back)
    view = render(bodies, PIXEL_MM, EYE)
    if texture is not None and not apart:
        return view
    middles = {i: middle_of_face(design, i, "q" if back else "p", frame) for i, frame in enumerate(frames)}
    return numbered(view, middles)


def middle_of_face(design: Design, index: int, side: Side, frame: Frame, lift: float = 0.0) -> FloatArray:
    """(3,) the middle of a piece's upper face, mm."""
    middle = shapely.maximum_inscribed_circle(face(design, index, side)).coords[0]
    return np.append(frame.paper(np.array([middle]))[0], design.parameters.height + lift)


def numbered(view: View, middles: Mapping[int, FloatArray], size_mm: float = NUMBER_MM) -> View:
    """The picture with the number of every piece, of which ``middles`` has the index, at a point (3,)."""
    picture = Image.fromarray(view.pixels)
    draw, radius = ImageDraw.Draw(picture), 0.5 * size_mm * view.pixels.shape[1] / view.width
    font = ImageFont.truetype(font_files()[1], 1.1 * radius)
    for index, (x, y) in zip(middles, view.pixel(np.array(list(middles.values())), EYE).tolist(), strict=True):
        draw.ellipse((x - radius, y - radius, x + radius, y + radius), LIGHT["paper"], LIGHT["ink"], 2)
        draw.text((x, y), str(index + 1), LIGHT["ink"], font, anchor="mm")
    return replace(view, pixels=np.asarray(picture))


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


def piece_body(
    design: Design, index: int, frame: Frame, back: bool, side: Side, texture: Texture | None, lift: float = 0.0
) -> Body:
    """A piece with its texture, if there is one, on the upper face; knuckles keep the piece's colour."""
    height = design.parameters.height
    layers = [(slab.low, slab.high, rings(frame.region(slab.section))) for slab in design.pieces[index].slabs]
    if back:
        layers = [(height - high, height - low, base) for low, high, base in layers]
    layers = [(low + lift, high + lift, base) for low, high, base in layers]
    top = None
    if texture is not None:
        region = frame.region(face(design, index, side))
        shapely.prepare(region)
        colours = face_colours(design, texture, side, index, frame, PIXEL_MM)

        def top(points: FloatArray) -> tuple[BoolArray, ByteArray]:
            covered: BoolArray = shapely.contains_xy(region, points)
            return covered, colours(points[covered])

    colour = PIECES[hue(index, len(design.pieces))]
    if isinstance(texture, InlayTexture) and texture.drawing.base:
        colour = texture.drawing.base
    return Body(*prisms(layers), colour, top)


def _pushed_in(design: Design, frames: list[Frame], back: bool) -> list[Body]:
    """The pins in their hinges."""
    bodies, height = [], design.parameters.height
    for piece, frame in zip(design.pieces, frames, strict=True):
        if piece.start.kind == "pin" and design.pivot is not None and design.pins:
            (axis,) = frame.paper(np.array([[piece.start.x, piece.start.y]]))
            layers = tubes(design.pivot.profile, axis)
            if back:
                layers = [(height - high, height - low, base) for low, high, base in layers]
            bodies.append(Body(*prisms(layers), METAL))
    return bodies


def tubes(profile: Sequence[Ring], axis: FloatArray) -> list[tuple[float, float, tuple[FloatArray, ...]]]:
    """Rings around an axis as layers: from z, to z, and the base."""
    middle = shapely.Point(axis)
    return [
        (ring.low, ring.high, rings(middle.buffer(ring.radius).difference(middle.buffer(ring.hole))))
        for ring in profile
    ]


def _pins(design: Design, frames: list[Frame]) -> list[Body]:
    """A pin over every pin hinge, a sleeve over every telescopic one, and dashes from it to the two pieces it joins."""
    height = design.parameters.height
    low = PIN_LIFT * height
    bodies = []
    for index, piece in enumerate(design.pieces):
        if piece.start.kind == "open" or design.placement is not None:
            continue
        before = design.pieces[index - 1]
        (start,) = frames[index].paper(np.array([[piece.start.x, piece.start.y]]))
        (end,) = frames[index - 1].paper(np.array([[before.end.x, before.end.y]]))
        middle = 0.5 * (start + end)
        for hinge in (start, end):
            bodies += dashes(np.append(hinge, height), np.append(middle, low))
        profile: tuple[Ring, ...] = () if design.pivot is None else design.pivot.profile
        if piece.start.kind == "telescopic" and design.telescope is not None:
            profile = design.telescope.sleeve
        layers = [(low + bottom, low + top, base) for bottom, top, base in tubes(profile, middle)]
        bodies.append(Body(*prisms(layers), METAL))
    return bodies


def dashes(start: FloatArray, end: FloatArray) -> list[Body]:
    """A dashed line between two points (3,)."""
    count = max(1, round(float(np.hypot(*EYE.view(np.array([end - start]))[0, :2])) / (2.0 * _DASH_MM)))
    shares = np.arange(count)[:, None] + np.array([0.2, 0.8])
    ends = start + shares[..., None] / count * (end - start)
    return [ribbon(first, last, _DASH_WIDTH_MM, EYE, LIGHT["muted"]) for first, last in ends]
