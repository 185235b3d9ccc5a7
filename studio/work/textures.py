"""Pieces in the colours of the pictures that were given, where these have several. Ours."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from msgspec import Struct, json
from PIL import Image, ImageDraw, UnidentifiedImageError

from riot.draw.piece_image import PieceImage
from riot.draw.svg import data_url
from riot.draw.texture.paint import find_textures
from riot.draw.texture.sample import piece_images
from riot.draw.texture.source import TextureError
from riot.draw.texture.warp import WarpError
from riot.errors import SilhouetteError
from riot.geometry.picture import upright
from riot.geometry.shape import Shape
from studio.messages import Side
from studio.work.material import Files, transform

LOOKED_AT = 128
"""Pixels: a picture is looked at for colours in so small a size."""

SPREAD = 12.0
"""Standard deviation of a channel, of 255, from which an object has several colours: above noise and mixed rims."""


class Texture(Struct, frozen=True):
    """An image and the box that it fills in its piece's frame, y up."""

    href: str
    box: tuple[float, float, float, float]


def has_colours(path: Path, shape: Shape) -> bool:
    """Whether the object of a picture has several colours; a drawing in vectors is none of its pictures."""
    try:
        with Image.open(path) as opened:
            image = upright(opened).convert("RGB")
    except (UnidentifiedImageError, OSError):
        return False
    factor = max(1, max(image.size) // LOOKED_AT)
    small = image.reduce(factor)
    inside = Image.new("1", small.size)
    # Two pixels of outline are left out: there the object's colour is mixed with the background's.
    drawing, outline = (
        ImageDraw.Draw(inside),
        [(x / factor, y / factor) for x, y in shape.source(shape.points).tolist()],
    )
    drawing.polygon(outline, fill=1)
    drawing.line([*outline, outline[0]], fill=0, width=5)
    colours = np.asarray(small)[np.asarray(inside, dtype=np.bool_)]
    return len(colours) > 0 and float(colours.std(axis=0).max()) >= SPREAD


def textures(files: Files, digest: str, pictures: Mapping[Side, bytes]) -> bytes:
    """`Texture` of every piece of a transform, as JSON by side: "p" is their front, "q" their back as Q is drawn.

    A side whose picture cannot be carried into the pieces is left out.
    """
    shown, found = transform(files, digest), dict[str, list[Texture]]()
    with tempfile.TemporaryDirectory(prefix="riot-studio-") as folder:
        for side, data in pictures.items():
            path = Path(folder) / side
            path.write_bytes(data)
            try:
                images = piece_images(shown, find_textures(shown, {side: path}, {side: path}))
            except (TextureError, WarpError, SilhouetteError):
                continue
            found[side] = [_texture(image) for image in images[side]]
    return json.encode(found)


def _texture(image: PieceImage) -> Texture:
    x0, y0, x1, y1 = (round(float(value), 5) for value in image.box)
    return Texture(data_url(image.pixels, "JPEG"), (x0, y0, x1, y1))
