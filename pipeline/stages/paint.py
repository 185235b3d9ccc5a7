"""What the pieces of one transform look like whose inputs are colour pictures: their skins (theory §9)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from pipeline.stages.items import ErrorRow, attempt
from pipeline.stages.textures import Pictures, read_textures
from pipeline.store.artifact import AnyArray, Artifact
from riot.draw.piece_image import PieceImage, PieceImages
from riot.draw.texture.names import SIDES
from riot.draw.texture.sample import piece_images
from riot.transform.riot_file import from_json


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Pictures) -> Artifact:
    """A transform with its motion, and its pictures → `pack_skins` of the sides that have colours, perhaps of none.

    The document has these ``sides``, and ``refused`` a row for each picture that cannot be a texture: no error, its
    side is plain.
    """
    (planned,) = inputs
    transform = from_json(planned.document["riot"])
    errors: list[ErrorRow] = []

    def painted() -> Artifact:
        textures, refused = read_textures(transform, spec)
        skins = piece_images(transform, textures)
        return Artifact(pack_skins(skins), {"sides": sorted(skins), "refused": [asdict(each) for each in refused]})

    made = attempt(0, painted, errors)
    return Artifact({}, {"errors": errors}) if made is None else made


def pack_skins(skins: PieceImages) -> dict[str, AnyArray]:
    """PieceImages as arrays: of side s and piece i ``s-i`` (rows, columns, 3) uint8 and ``s-i-box`` (4,) float64."""
    arrays: dict[str, AnyArray] = {}
    for side, some in skins.items():
        for i, skin in enumerate(some):
            arrays[f"{side}-{i}"], arrays[f"{side}-{i}-box"] = skin.pixels, np.array(skin.box)
    return arrays


def unpack_skins(arrays: Mapping[str, AnyArray], pieces: int) -> PieceImages:
    """What `pack_skins` packed, of a transform of so many pieces."""
    return {
        side: tuple(
            PieceImage(np.array(arrays[f"{side}-{i}"]), _box(arrays[f"{side}-{i}-box"].tolist())) for i in range(pieces)
        )
        for side in SIDES
        if f"{side}-0" in arrays
    }


def _box(values: Sequence[float]) -> tuple[float, float, float, float]:
    x0, y0, x1, y1 = values
    return x0, y0, x1, y1
