"""What the pieces of one transform look like whose inputs are colour pictures: their skins (theory §9)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pipeline.artifact import AnyArray, Artifact
from pipeline.item import Item
from pipeline.work.ingest import check_unchanged
from pipeline.work.items import ErrorRow, attempt
from riot.draw.skin import Skin, Skins
from riot.riotfile import from_json
from riot.texture.names import SIDES, Side
from riot.texture.paint import PictureTexture, picture_texture
from riot.texture.skins import make_skins
from riot.texture.source import TextureError
from riot.transform import Transform

Spec = tuple[Item | None, Item | None]
"""The pictures of P and of Q; None for one without colours."""

LEAST_CONTRAST = 8.0
"""A picture whose colours differ less from their mean (root mean square, of 255) is a silhouette in one colour."""


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Spec) -> Artifact:
    """A transform with its motion, and its pictures → `pack_skins` of the sides that have colours, perhaps of none."""
    (planned,) = inputs
    for item in spec:
        if item is not None:
            check_unchanged(item)
    transform = from_json(planned.document["riot"])
    errors: list[ErrorRow] = []
    skins = attempt(0, lambda: make_skins(transform, _textures(transform, spec)), errors)
    return Artifact({}, {"errors": errors}) if skins is None else Artifact(pack_skins(skins), {"sides": sorted(skins)})


def _textures(transform: Transform, spec: Spec) -> Mapping[Side, PictureTexture]:
    found = {}
    for side, item in zip(SIDES, spec, strict=True):
        if item is None:
            continue
        try:
            texture = picture_texture(item.source, transform, side)
        except TextureError:  # opaque all over, or in parts of which the silhouette is one: no texture, and no error
            continue
        if float(texture.pixels.reshape(-1, 3).std(axis=0).max()) >= LEAST_CONTRAST:
            found[side] = texture
    return found


def pack_skins(skins: Skins) -> dict[str, AnyArray]:
    """Skins as arrays: of side s and piece i ``s-i`` (rows, columns, 3) uint8 and ``s-i-box`` (4,) float64."""
    arrays: dict[str, AnyArray] = {}
    for side, some in skins.items():
        for i, skin in enumerate(some):
            arrays[f"{side}-{i}"], arrays[f"{side}-{i}-box"] = skin.pixels, np.array(skin.box)
    return arrays


def unpack_skins(arrays: Mapping[str, AnyArray], pieces: int) -> Skins:
    """What `pack_skins` packed, of a transform of so many pieces."""
    return {
        side: tuple(
            Skin(np.array(arrays[f"{side}-{i}"]), _box(arrays[f"{side}-{i}-box"].tolist())) for i in range(pieces)
        )
        for side in SIDES
        if f"{side}-0" in arrays
    }


def _box(values: Sequence[float]) -> tuple[float, float, float, float]:
    x0, y0, x1, y1 = values
    return x0, y0, x1, y1
