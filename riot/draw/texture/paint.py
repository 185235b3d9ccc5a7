"""Textures: the colour of every point of an assembled shape, from a picture, a pattern or plain (theory §9).

P's texture is on the pieces' front, Q's on their back. Turned over, the assembled Q is seen mirrored, outline and
texture alike: what is glued or printed on the back is drawn mirrored. Ours.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np
import shapely
from PIL import Image, ImageColor
from scipy import ndimage

from riot.draw.palette import PIECES, hue
from riot.draw.texture.names import PATTERNS, SIDES, Pattern, Side
from riot.draw.texture.source import ByteArray, load_picture
from riot.draw.texture.tuning import BANDS_CELL, PATTERN_WIDTH
from riot.draw.texture.warp import Warp, warp_side

if TYPE_CHECKING:
    from riot.geometry.shape import Shape
    from riot.transform.transform import Transform
    from riot.types import FloatArray


_TINTS = {"p": ("#f2c14e", "#d1495b"), "q": ("#9bd1c6", "#2e6f95")}


class Texture(Protocol):
    """The colour of every point of an assembled shape."""

    def colours(self, piece: int, xy: FloatArray, step: float) -> ByteArray:
        """(k, 3) red, green, blue at (k, 2) points of the assembled shape, in the shape's frame (unit area, y up).

        ``piece`` is the piece on which they lie; ``step`` the distance of neighbouring points, for smoothing: finer
        detail than that is averaged.
        """
        ...


@dataclass(frozen=True)
class PlainTexture:
    """One colour a piece, the same as in all pictures of the transform, for ``count`` pieces."""

    count: int

    def colours(self, piece: int, xy: FloatArray, step: float) -> ByteArray:
        """See `Texture`."""
        colour = ImageColor.getrgb(PIECES[hue(piece, self.count)])[:3]
        return np.broadcast_to(np.array(colour, dtype=np.uint8), (len(xy), 3))


@dataclass(frozen=True, eq=False)
class PatternTexture:
    """A pattern in two tints: bands along the outline, stripes, or checks.

    Parameters
    ----------
    pattern : Pattern
    outline : (m, 2) float64
        Of the assembled shape.
    tints : two "#rrggbb"
    """

    pattern: Pattern
    outline: FloatArray
    tints: tuple[str, str]

    def colours(self, piece: int, xy: FloatArray, step: float) -> ByteArray:
        """See `Texture`."""
        if self.pattern == "bands":
            waves = self._depth(xy) / PATTERN_WIDTH
        elif self.pattern == "stripes":
            waves = (xy[:, 0] + xy[:, 1]) / (np.sqrt(2.0) * PATTERN_WIDTH)
        else:
            across, along = (_soft(xy[:, axis] / PATTERN_WIDTH, step) for axis in (0, 1))
            return self._mixed(across * along + (1.0 - across) * (1.0 - along))
        return self._mixed(_soft(waves, step))

    def _mixed(self, share: FloatArray) -> ByteArray:
        first, second = (np.array(ImageColor.getrgb(tint)[:3], dtype=np.float64) for tint in self.tints)
        return np.rint(first + share[:, None] * (second - first)).astype(np.uint8)

    def _depth(self, xy: FloatArray) -> FloatArray:
        """Distance from the outline, on a raster fine enough for smooth bands."""
        low, cell, raster = self._raster
        at = (xy - low) / cell
        depth: FloatArray = ndimage.map_coordinates(raster, [at[:, 1], at[:, 0]], order=1, mode="nearest")
        return depth

    @cached_property
    def _raster(self) -> tuple[FloatArray, float, FloatArray]:
        cell = BANDS_CELL
        low = self.outline.min(axis=0) - 2 * cell
        columns, rows = np.ceil((self.outline.max(axis=0) - low) / cell + 3).astype(int)
        x, y = np.meshgrid(low[0] + cell * np.arange(columns), low[1] + cell * np.arange(rows))
        inside = shapely.contains_xy(_prepared(self.outline), np.column_stack([x.ravel(), y.ravel()]))
        depth = ndimage.distance_transform_edt(inside.reshape(x.shape)) * cell
        return low, cell, ndimage.gaussian_filter(depth, 2.0)


@dataclass(frozen=True, eq=False)
class PictureTexture:
    """A picture of the input, carried into the pieces by a warp.

    Parameters
    ----------
    pixels : (rows, columns, 3) uint8
        The picture; beyond the object the colours of its rim go on (`load_picture`).
    shape : Shape
        The input, which knows its position in the picture.
    warp : Warp
        From the assembled shape to the input.
    """

    pixels: ByteArray
    shape: Shape
    warp: Warp

    def colours(self, piece: int, xy: FloatArray, step: float) -> ByteArray:
        """See `Texture`."""
        at = self.shape.source(self.warp(xy))
        scale = float(np.sqrt(abs(np.linalg.det(self.shape.to_source[:, :2]))))
        factor = max(1, int(step * scale))
        pixels = self._reduced(factor)
        # Of a reduced picture a value stands in the middle of its block.
        rows, columns = ((at[:, axis] - (factor - 1) / 2.0) / factor for axis in (1, 0))
        channels = [
            ndimage.map_coordinates(pixels[..., k], [rows, columns], output=np.float64, order=1, mode="nearest")
            for k in range(3)
        ]
        return np.rint(np.stack(channels, axis=1)).astype(np.uint8)

    def _reduced(self, factor: int) -> ByteArray:
        return np.asarray(Image.fromarray(self.pixels).reduce(factor)) if factor > 1 else self.pixels


def find_textures(
    transform: Transform,
    pictures: Mapping[Side, str | os.PathLike[str]],
    masks: Mapping[Side, str | os.PathLike[str]] | None = None,
    pattern: Pattern | None = None,
) -> dict[Side, Texture]:
    """The textures of a transform's sides: from a colour picture where one is given, from a pattern else, or none.

    ``masks`` are for pictures without transparency (`riot.draw.texture.source.load_picture`). Errors as
    `picture_texture` and `pattern_texture`.
    """
    masks = masks or {}
    textures: dict[Side, Texture] = {}
    for side in SIDES:
        if side in pictures:
            textures[side] = picture_texture(pictures[side], transform, side, masks.get(side))
        elif pattern is not None:
            textures[side] = pattern_texture(pattern, transform, side)
    return textures


def picture_texture(
    path: str | os.PathLike[str], transform: Transform, side: Side, mask: str | os.PathLike[str] | None = None
) -> PictureTexture:
    """The texture of the assembled P (side "p") or Q ("q") from a colour picture of the input.

    Raises `riot.draw.texture.source.TextureError` and `riot.errors.SilhouetteError` as
    `riot.draw.texture.source.load_picture`, `riot.draw.texture.warp.WarpError` for a transform without certificate.
    """
    shape = transform.input_p if side == "p" else transform.input_q
    return PictureTexture(load_picture(path, shape, mask), shape, warp_side(transform, side))


def pattern_texture(pattern: Pattern, transform: Transform, side: Side) -> PatternTexture:
    """A generated texture of the assembled P (side "p") or Q ("q"), in the side's tints; ValueError for no pattern.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> texture = pattern_texture("stripes", exact_transform(dudeney()), "p")
    >>> texture.colours(0, np.zeros((1, 2)), 0.01).shape
    (1, 3)
    """
    if pattern not in PATTERNS:
        raise ValueError(f"there is no pattern {pattern!r}: choose {', '.join(PATTERNS)}")
    outline = transform.outline_p() if side == "p" else transform.outline_q()
    return PatternTexture(pattern, outline, _TINTS[side])


def _soft(waves: FloatArray, step: float) -> FloatArray:
    """0 on even waves, 1 on odd ones, blended over one ``step`` between them."""
    edge = max(step / PATTERN_WIDTH, 1e-9)
    distance = np.abs(np.mod(waves, 2.0) - 1.0)  # 1 in the middle of an even pair's joint, 0 of the odd one's
    share: FloatArray = np.clip((0.5 - distance) / edge + 0.5, 0.0, 1.0)
    return share


def _prepared(outline: FloatArray) -> shapely.Polygon:
    region = shapely.Polygon(outline)
    shapely.prepare(region)
    return region
