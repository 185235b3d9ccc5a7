"""The colour picture of an input, which tells by transparency, or by a mask beside it, what is object. Ours."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw
from scipy import ndimage

from riot.draw.texture.tuning import CHECK_SIDE, LEAST_OVERLAP, MAX_PICTURE_PIXELS, MIXED_RIM
from riot.errors import RiotError
from riot.geometry.picture import decode, upright
from riot.geometry.silhouette import read

if TYPE_CHECKING:
    from riot.geometry.shape import Shape
    from riot.types import BoolArray, FloatArray

ByteArray = npt.NDArray[np.uint8]


class TextureError(RiotError, ValueError):
    """A picture that cannot be the texture of a shape; ``reason`` is one word: ``no-alpha``, ``other-size`` or
    ``other-shape``."""

    def __init__(self, reason: str, message: str) -> None:
        super().__init__(message)
        self.reason = reason

    def __reduce__(self) -> tuple[type[TextureError], tuple[str, str]]:
        return type(self), (self.reason, str(self))


def load_picture(path: str | os.PathLike[str], shape: Shape, mask: str | os.PathLike[str] | None = None) -> ByteArray:
    """Read the colour picture of a shape: (rows, columns, 3) uint8.

    The object is the opaque part. Of a picture without transparency (a JPEG) it is what ``mask`` has: the picture of
    the same size that the shape was read from. Other pixels get the colour of the object's nearest, so that nothing of
    a background shows at the rim.

    Raises
    ------
    riot.errors.SilhouetteError
        ``unreadable``, ``not-a-picture``, ``too-large``, as `riot.geometry.picture.decode`, of either file.
    TextureError
        ``no-alpha``: the picture does not say by transparency what is object, and there is no mask. ``other-size``: the
        mask has another size than the picture. ``other-shape``: the object is not where the shape's outline is:
        another size than the picture the shape was read from, or another picture.
    """
    where = Path(path)
    transparent = decode(where, MAX_PICTURE_PIXELS).opaque_object
    with Image.open(where) as image:
        rgba = np.asarray(upright(image).convert("RGBA"))
    if transparent:
        kept = rgba[..., 3] >= 128
        _refuse_other(where, kept, shape)
    elif mask is None:
        raise TextureError(
            "no-alpha",
            f"{where}: the picture has no transparent part, so that the object cannot be told from its background; "
            "save it as PNG with a transparent background, or give its mask, a picture of the same size",
        )
    else:
        kept = _masked(where, (rgba.shape[1], rgba.shape[0]), Path(mask), shape)
    nearest = ndimage.distance_transform_edt(~kept, return_distances=False, return_indices=True)
    filled: ByteArray = np.ascontiguousarray(rgba[nearest[0], nearest[1], :3])
    return filled


def _masked(where: Path, size: tuple[int, int], mask: Path, shape: Shape) -> BoolArray:
    """(rows, columns) the object of a mask, which must be the shape's and of this width and height; less its rim."""
    decode(mask, MAX_PICTURE_PIXELS)
    with Image.open(mask) as image:
        mask_size = upright(image).size
    if mask_size != size:
        raise TextureError(
            "other-size",
            f"{where}: the picture is {size[0]} × {size[1]} pixels, its mask {mask} {mask_size[0]} × {mask_size[1]}; "
            "scale one to the size of the other",
        )
    own = read(mask)
    _refuse_other(mask, _drawn(own.source(own.points), size), shape)
    whole = _drawn(shape.source(shape.points), size)
    inner: BoolArray = ndimage.binary_erosion(whole, iterations=MIXED_RIM)
    return inner if inner.any() else whole


def _drawn(outline: FloatArray, size: tuple[int, int]) -> BoolArray:
    """(rows, columns) the pixels within an outline (m, 2), x = column, y = row, of a picture ``size`` wide and high."""
    canvas = Image.new("1", size)
    ImageDraw.Draw(canvas).polygon([(x, y) for x, y in outline.tolist()], fill=1)
    return np.asarray(canvas, dtype=np.bool_)


def _refuse_other(where: Path, opaque: BoolArray, shape: Shape) -> None:
    """Refuse a picture whose object is not the shape at its own position."""
    outline = shape.source(shape.points)
    wanted = np.ptp(outline, axis=0)
    rows, columns = np.flatnonzero(opaque.any(axis=1)), np.flatnonzero(opaque.any(axis=0))
    object_size = (int(np.ptp(columns)) + 1, int(np.ptp(rows)) + 1) if len(rows) else (0, 0)
    factor = max(1, max(opaque.shape) // CHECK_SIDE)
    thin = ndimage.binary_fill_holes(opaque[factor // 2 :: factor, factor // 2 :: factor])
    drawn = _drawn((outline - factor // 2) / factor, (thin.shape[1], thin.shape[0]))
    union = int((thin | drawn).sum())
    if union and int((thin & drawn).sum()) >= LEAST_OVERLAP * union:
        return
    who = shape.name or "the shape"
    raise TextureError(
        "other-shape",
        f"{where}: its object is {object_size[0]} × {object_size[1]} pixels, and {who} was read from one of "
        f"{wanted[0]:.0f} × {wanted[1]:.0f}, or elsewhere in its picture, or of another outline; "
        "give the same picture, with colours, in the same size",
    )
