"""The colour pictures of a pair as textures of its transform, for the stages that show and print them (theory §9)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.datasets.item import Item
from pipeline.stages.ingest import check_unchanged
from riot import draw
from riot.draw.texture.names import SIDES, Side
from riot.errors import SilhouetteError

if TYPE_CHECKING:
    from riot.draw.texture.paint import PictureTexture
    from riot.transform.transform import Transform

Pictures = tuple[Item | None, Item | None]
"""The pictures of P and of Q; None for one without colours."""

LEAST_CONTRAST = 8.0
"""Root mean square distance of a picture's colours from their mean, of 255, below which it counts as a silhouette in
one colour (ours: compression noise is less)."""


@dataclass(frozen=True)
class Refusal:
    """A colour picture that cannot be a texture: its side, and the reason and message of the error."""

    side: Side
    reason: str
    message: str


def read_textures(transform: Transform, pictures: Pictures) -> tuple[Mapping[Side, PictureTexture], list[Refusal]]:
    """The textures of the sides that have colours, and the refused pictures; a silhouette in one colour is neither.

    Raises RuntimeError for a file that changed since the run was planned.
    """
    textures: dict[Side, PictureTexture] = {}
    refused = []
    for side, item in zip(SIDES, pictures, strict=True):
        if item is None:
            continue
        check_unchanged(item)
        try:
            texture = draw.texture.paint.picture_texture(item.source, transform, side)
        except (draw.texture.source.TextureError, SilhouetteError) as error:
            # The stored message must not depend on the collection's folder.
            refused.append(Refusal(side, error.reason, str(error).replace(str(Path(item.source)), item.name)))
            continue
        if float(texture.pixels.reshape(-1, 3).std(axis=0).max()) >= LEAST_CONTRAST:
            textures[side] = texture
    return textures, refused
