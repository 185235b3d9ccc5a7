"""Texture: the colour of every place of a made shape, from a picture of the input, a pattern or plain (theory §9).

P's texture is on the pieces' front, Q's on their back. Turned over, the assembled Q is seen mirrored, outline and
texture alike: what is glued or printed on the back is drawn mirrored. Ours.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Protocol, get_args

import numpy as np
import numpy.typing as npt
import shapely
from PIL import Image, ImageColor, ImageDraw
from scipy import ndimage

from riot.draw.palette import PIECES, hue
from riot.errors import RiotError
from riot.fabricate.warp import Side, Warp, warp_side
from riot.picture import decode

if TYPE_CHECKING:
    from riot.shape import BoolArray, FloatArray, Shape
    from riot.transform import Transform

ByteArray = npt.NDArray[np.uint8]

Pattern = Literal["bands", "stripes", "checks"]
PATTERNS: tuple[Pattern, ...] = get_args(Pattern)

PATTERN_WIDTH = 0.06
"""Of a band, stripe or check, in the unit-area frame."""

MAX_PIXELS = 64_000_000
"""A picture with more pixels is refused."""

LEAST_MATCH = 0.9
"""Least IoU of a picture's opaque part, holes filled, with the shape's outline."""

_TINTS = {"p": ("#f2c14e", "#d1495b"), "q": ("#9bd1c6", "#2e6f95")}
_CHECK_SIDE = 1024


class TextureError(RiotError, ValueError):
    """A picture that cannot be the texture of a shape; ``reason`` is one word: ``no-alpha`` or ``other-shape``."""

    def __init__(self, reason: str, message: str) -> None:
        super().__init__(message)
        self.reason = reason

    def __reduce__(self) -> tuple[type[TextureError], tuple[str, str]]:
        return type(self), (self.reason, str(self))


class Texture(Protocol):
    """The colour of every place of a made shape."""

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
        found: FloatArray = ndimage.map_coordinates(raster, [at[:, 1], at[:, 0]], order=1, mode="nearest")
        return found

    @cached_property
    def _raster(self) -> tuple[FloatArray, float, FloatArray]:
        cell = PATTERN_WIDTH / 16.0
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
        The input, which knows its place in the picture.
    warp : Warp
        From the made shape to the input.
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
        found = [
            ndimage.map_coordinates(pixels[..., k], [rows, columns], output=np.float64, order=1, mode="nearest")
            for k in range(3)
        ]
        return np.rint(np.stack(found, axis=1)).astype(np.uint8)

    def _reduced(self, factor: int) -> ByteArray:
        return np.asarray(Image.fromarray(self.pixels).reduce(factor)) if factor > 1 else self.pixels


def picture_texture(path: str | os.PathLike[str], transform: Transform, side: Side) -> PictureTexture:
    """The texture of the assembled P (side "p") or Q ("q") from a colour picture of the input.

    Raises `TextureError` and `riot.errors.SilhouetteError` as `load_picture`, `riot.fabricate.warp.WarpError` for a
    transform without certificate.
    """
    shape = transform.p if side == "p" else transform.q
    return PictureTexture(load_picture(path, shape), shape, warp_side(transform, side))


def pattern_texture(pattern: Pattern, transform: Transform, side: Side) -> PatternTexture:
    """A generated texture of the assembled P (side "p") or Q ("q"), in the side's tints; ValueError for no pattern."""
    if pattern not in PATTERNS:
        raise ValueError(f"there is no pattern {pattern!r}: choose {', '.join(PATTERNS)}")
    outline = transform.outline_p() if side == "p" else transform.outline_q()
    return PatternTexture(pattern, outline, _TINTS[side])


def load_picture(path: str | os.PathLike[str], shape: Shape) -> ByteArray:
    """Read the colour picture of a shape: (rows, columns, 3) uint8.

    Transparent pixels get the colour of the nearest opaque one, so that nothing of a background shows at the rim.

    Raises
    ------
    riot.errors.SilhouetteError
        ``unreadable``, ``not-a-picture``, ``too-large``, as `riot.picture.decode`.
    TextureError
        ``no-alpha``: the picture does not say by transparency what is object. ``other-shape``: its opaque part is not
        where the shape's outline is: another size than the picture the shape was read from, or another picture.
    """
    where = Path(path)
    if not decode(where, MAX_PIXELS).opaque_object:
        raise TextureError(
            "no-alpha",
            f"{where}: the picture has no transparent part, so that the object cannot be told from its background; "
            "save it as PNG with a transparent background",
        )
    with Image.open(where) as image:
        rgba = np.asarray(image.convert("RGBA"))
    opaque = rgba[..., 3] >= 128
    _refuse_other(where, opaque, shape)
    nearest = ndimage.distance_transform_edt(~opaque, return_distances=False, return_indices=True)
    filled: ByteArray = np.ascontiguousarray(rgba[nearest[0], nearest[1], :3])
    return filled


def _refuse_other(where: Path, opaque: BoolArray, shape: Shape) -> None:
    """Refuse a picture whose opaque part is not the shape in its own place."""
    outline = shape.source(shape.points)
    wanted = np.ptp(outline, axis=0)
    rows, columns = np.flatnonzero(opaque.any(axis=1)), np.flatnonzero(opaque.any(axis=0))
    found = (int(np.ptp(columns)) + 1, int(np.ptp(rows)) + 1) if len(rows) else (0, 0)
    factor = max(1, max(opaque.shape) // _CHECK_SIDE)
    thin = ndimage.binary_fill_holes(opaque[factor // 2 :: factor, factor // 2 :: factor])
    canvas = Image.new("1", (thin.shape[1], thin.shape[0]))
    ImageDraw.Draw(canvas).polygon([(x, y) for x, y in ((outline - factor // 2) / factor).tolist()], fill=1)
    drawn = np.asarray(canvas, dtype=np.bool_)
    union = int((thin | drawn).sum())
    if union and int((thin & drawn).sum()) >= LEAST_MATCH * union:
        return
    who = shape.name or "the shape"
    raise TextureError(
        "other-shape",
        f"{where}: its object is {found[0]} × {found[1]} pixels, and {who} was read from one of "
        f"{wanted[0]:.0f} × {wanted[1]:.0f}, or elsewhere in its picture, or of another outline; "
        "give the same picture, with colours, in the same size",
    )


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
