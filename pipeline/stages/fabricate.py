"""The puzzle of a transform: its files, and its row in the table of fabrications (paper §4.4)."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.choose import best_certified
from pipeline.stages.planning import after_motion
from pipeline.stages.shape_arrays import ErrorRow, attempt
from pipeline.stages.stage import Column, Stage, TableColumns
from pipeline.stages.textures import Pictures, read_textures
from pipeline.store.artifact import AnyArray, Artifact
from riot import fabricate, transform
from riot.draw.texture.names import Side
from riot.errors import FabricationError
from riot.parameters import FabricationParameters

if TYPE_CHECKING:
    from riot.draw.texture.paint import Texture
    from riot.fabricate.certificate import BuiltPuzzle
    from riot.transform.transform import Transform


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Pictures | None) -> Artifact:
    """A transform with its motion → the puzzle's files by name, (bytes,) uint8 each, and a document.

    The document has the columns that ``STAGE`` adds to the table of fabrications. ``spec`` are the colour pictures of
    the shapes, for the texture sheets among the paperwork; the warnings list those that cannot be textures. A puzzle
    that cannot be made, or fails its certificate, is no error: it has no files, and a reason.
    """
    (planned,), (sizes, mend, paper) = inputs, parameters
    errors: list[ErrorRow] = []

    def make() -> Artifact:
        try:
            source = transform.riot_file.from_json(planned.document["riot"])
            return _made(source, sizes, mend, paper, spec or (None, None))
        except FabricationError as error:
            status = {"status": "refused", "reason": error.reason, "message": str(error)}
            return Artifact({}, {**status, **_asked(sizes)})

    result = attempt(0, make, errors)
    return result if result is not None else Artifact({}, {"errors": errors})


def _made(source: Transform, sizes: FabricationParameters, mend: bool, paper: bool, pictures: Pictures) -> Artifact:
    certificate = fabricate.certificate
    puzzle = (certificate.fix if mend else certificate.build)(source, sizes)
    if not puzzle.certificate.passed:
        status = {"status": "failed", "reason": "uncertified", "message": "; ".join(puzzle.certificate.failures)}
        return Artifact({}, {**status, **_measured(puzzle)})
    textures, refused = read_textures(source, pictures) if paper else ({}, [])
    files = _files(puzzle, paper, textures)  # raises if a part is larger than the bed
    measured = _measured(puzzle)
    sheets = fabricate.export.paperwork.SHEETS
    measured["warnings"] += [f"no {sheets[refusal.side]}: {refusal.message}" for refusal in refused]
    return Artifact(files, {"status": "certified", "reason": "", "message": "", **measured})


def _files(puzzle: BuiltPuzzle, paper: bool, textures: Mapping[Side, Texture]) -> dict[str, AnyArray]:
    def paperwork(where: Path) -> None:
        fabricate.export.paperwork.write_paperwork(puzzle.design, where, textures, dxf=False)

    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "puzzle"
        write = fabricate.export.solids.write_puzzle
        paths = write(puzzle.design, puzzle.parts, puzzle.certificate, folder, [paperwork] if paper else [])
        return {path.relative_to(folder).as_posix(): np.frombuffer(path.read_bytes(), dtype=np.uint8) for path in paths}


def _asked(sizes: FabricationParameters) -> dict[str, Any]:
    return {"size": sizes.size_mm, "thickness": sizes.height, "pin": sizes.pin_mm}


def _measured(puzzle: BuiltPuzzle) -> dict[str, Any]:
    design, certificate = puzzle.design, puzzle.certificate
    pieces = [check for check in certificate.parts if not math.isnan(check.wall)]
    motion = certificate.motion
    return {
        **_asked(design.parameters),
        "changes": list(puzzle.changes),
        "parts": sum(check.count for check in certificate.parts),
        "components": max(check.components for check in certificate.parts),
        "volume": math.fsum(check.volume for check in pieces),
        "least_wall": certificate.wall,
        "least_gap": motion.gap if math.isfinite(motion.gap) else None,
        "proven_gap": motion.floor if motion.proven else None,
        "overlap": motion.overlap,
        "poses": motion.poses,
        "pin_hinges": sum(piece.start.kind == "pin" for piece in design.pieces),
        "telescopic_hinges": design.sleeves,
        "warnings": list(design.warnings),
    }


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each of the best certified transforms; with paperwork, from their pictures too."""
    motions = {item.members: item for item in progress.work["motion"]}
    best = [motions[item.members] for item in best_certified(progress, progress.config.fabricate.top)]
    if not progress.config.fabricate.paper:
        return [progress.recipes["fabricate"].after(motion) for motion in best]
    return [after_motion(progress, "fabricate", motion) for motion in best]


MM, MM3 = "mm", "mm3"

STAGE = Stage(
    name="fabricate",
    unit="best transforms",
    after=("motion", "paint"),
    parameters=("fabricate.sizes", "fabricate.fix", "fabricate.paper"),
    items=items,
    run=run,
    scope="pair",
    known_after="construct",
    wanted=lambda config: config.fabricate.top > 0,
    at_most=lambda config: min(config.fabricate.top, config.select.top),
    tables=(
        TableColumns(
            "fabrications",
            (
                Column(
                    "status", "string", "certified, failed (a check of its certificate), or refused (cannot be made)"
                ),
                Column("reason", "string", "why it failed or was refused, one word"),
                Column("message", "string", "why, in words, and which parameter would mend it"),
            ),
            lambda artifact: artifact.document,
            after="class_j",
        ),
        TableColumns(
            "fabrications",
            (
                Column("size", "float64", "long side of the larger shape", MM),
                Column("thickness", "float64", "of the pieces, in whole layers of the printer", MM),
                Column("pin", "float64", "diameter of the pins", MM),
                Column("changes", "list<string>", "parameters that were changed to make it (fabricate.fix)"),
                Column("parts", "int16", "parts to print, pins and sleeves among them", "count"),
                Column("components", "int16", "greatest number of connected solids in one part: 1", "count"),
                Column("volume", "float64", "of all pieces, pins and sleeves aside", MM3),
                Column("least_wall", "float64", "least width of a piece's layer where much hangs on it", MM),
                Column(
                    "least_gap", "float64", "least gap of two pieces found among samples of the motion; null = none", MM
                ),
                Column(
                    "proven_gap", "float64", "what pieces keep apart at every moment, proven; null = not proven", MM
                ),
                Column("overlap", "float64", "greatest volume of two parts in common, at the poses cut", MM3),
                Column("poses", "int16", "poses of the motion at which the solids were cut with each other", "count"),
                Column("pin_hinges", "int8", "hinges with a pin", "count"),
                Column("telescopic_hinges", "int8", "hinges that lift", "count"),
                Column("warnings", "list<string>", "what is weak or lost"),
            ),
            lambda artifact: artifact.document,
            "Puzzles of the best transforms (paper §4.4), made as `fabricate` asks; none with fabricate.top=0.",
        ),
    ),
)
