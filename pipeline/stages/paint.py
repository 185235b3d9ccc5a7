"""Images of the pieces of a transform whose inputs are colour pictures (theory §9)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.planning import after_motion
from pipeline.stages.shape_arrays import ErrorRow, attempt
from pipeline.stages.stage import Stage
from pipeline.stages.textures import Pictures, read_textures
from pipeline.store.artifact import AnyArray, Artifact
from riot import draw, transform
from riot.draw.texture.names import SIDES

if TYPE_CHECKING:
    from riot.draw.piece_image import PieceImages


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Pictures) -> Artifact:
    """A transform with its motion, and its pictures → `pack_images` of the sides that have colours, perhaps of none.

    The document has these ``sides``, and in ``refused`` a row for each picture that cannot be a texture: the pieces are
    plain on its side, and this is no error.
    """
    (planned,) = inputs
    puzzle = transform.riot_file.from_json(planned.document["riot"])
    errors: list[ErrorRow] = []

    def paint() -> Artifact:
        textures, refused = read_textures(puzzle, spec)
        images = draw.texture.sample.piece_images(puzzle, textures)
        document = {"sides": sorted(images), "refused": [asdict(refusal) for refusal in refused]}
        return Artifact(pack_images(images), document)

    painted = attempt(0, paint, errors)
    return Artifact({}, {"errors": errors}) if painted is None else painted


def pack_images(images: PieceImages) -> dict[str, AnyArray]:
    """Images as arrays: of side s and piece i ``s-i`` (rows, columns, 3) uint8 and ``s-i-box`` (4,) float64."""
    arrays: dict[str, AnyArray] = {}
    for side, pieces in images.items():
        for i, image in enumerate(pieces):
            arrays[f"{side}-{i}"], arrays[f"{side}-{i}-box"] = image.pixels, np.array(image.box)
    return arrays


def unpack_images(arrays: Mapping[str, AnyArray], pieces: int) -> PieceImages:
    """Undo `pack_images`, for a transform of this number of pieces."""
    return {
        side: tuple(
            draw.piece_image.PieceImage(np.array(arrays[f"{side}-{i}"]), _box(arrays[f"{side}-{i}-box"].tolist()))
            for i in range(pieces)
        )
        for side in SIDES
        if f"{side}-0" in arrays
    }


def _box(values: Sequence[float]) -> tuple[float, float, float, float]:
    x0, y0, x1, y1 = values
    return x0, y0, x1, y1


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each transform that has a motion and an input that may have colours, in order."""
    work = [after_motion(progress, "paint", motion) for motion in progress.work["motion"]]
    return [item for item in work if item.spec is not None]


STAGE = Stage(
    name="paint",
    unit="transforms of colour pictures",
    after=("motion",),
    parameters=(),
    items=items,
    run=run,
    scope="pair",
    known_after="construct",
    wanted=lambda config: config.dataset.kind == "folder",
    bundle=4,
)
