"""Images of a transform's pieces, as pictures of it show them: textures sampled in the pieces' own frames. Ours."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np
import shapely

from riot.draw.piece_image import PieceImage, PieceImages
from riot.draw.texture.tuning import IMAGE_PIXEL, IMAGE_RIM

if TYPE_CHECKING:
    from riot.draw.texture.names import Side
    from riot.draw.texture.paint import Texture
    from riot.draw.texture.source import ByteArray
    from riot.transform.transform import Transform
    from riot.types import FloatArray


def piece_images(transform: Transform, textures: Mapping[Side, Texture], step: float = IMAGE_PIXEL) -> PieceImages:
    """Every piece's image for the sides that have a texture, in pixels of side ``step`` (unit-area frame).

    P's is what is seen of the pieces from the front, at all moments of the motion; Q's is on their back, and is given
    as Q's own picture has it, not mirrored.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> from riot.draw.texture.paint import pattern_texture
    >>> transform = exact_transform(dudeney())
    >>> len(piece_images(transform, {"p": pattern_texture("bands", transform, "p")}, step=0.05)["p"])
    4
    """
    return {side: _sampled(transform, side, texture, step) for side, texture in textures.items()}


def _sampled(transform: Transform, side: Side, texture: Texture, step: float) -> tuple[PieceImage, ...]:
    pose = transform.pose(0.0 if side == "p" else 1.0)
    images = []
    for i, piece in enumerate(transform.pieces):

        def colours(points: FloatArray, i: int = i) -> ByteArray:
            return texture.colours(i, pose.place(i, points), step)

        region = shapely.Polygon(piece.polygon).buffer(IMAGE_RIM * step)
        images.append(PieceImage(*sample_region(region, step, colours)))
    return tuple(images)


def sample_region(
    region: shapely.Polygon, step: float, colours: Callable[[FloatArray], ByteArray]
) -> tuple[ByteArray, tuple[float, float, float, float]]:
    """A region as a picture: (rows, columns, 3) uint8, first row at the top (y up), and its box x0, y0, x1, y1.

    ``step`` is the side of a pixel, ``colours`` gives (k, 3) those of (k, 2) points; all in the region's own unit.
    Pixels more than one ``step`` outside are white.
    """
    x0, y0, x1, y1 = region.bounds
    columns, rows = int(np.ceil((x1 - x0) / step)), int(np.ceil((y1 - y0) / step))
    x, y = np.meshgrid(x0 + step * (np.arange(columns) + 0.5), y0 + step * (rows - np.arange(rows) - 0.5))
    points = np.column_stack([x.ravel(), y.ravel()])
    near = region.buffer(step)
    shapely.prepare(near)
    inside = shapely.contains_xy(near, points)
    pixels = np.full((rows * columns, 3), 255, dtype=np.uint8)
    pixels[inside] = colours(points[inside])
    return pixels.reshape(rows, columns, 3), (x0, y0, x0 + columns * step, y0 + rows * step)
