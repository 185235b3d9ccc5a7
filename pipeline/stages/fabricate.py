"""The puzzle of one transform: its files, and what the tables say of it (paper §4.4)."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.stages.items import ErrorRow, attempt
from pipeline.stages.textures import Pictures, read_textures
from pipeline.store.artifact import AnyArray, Artifact
from riot.draw.texture.names import Side
from riot.draw.texture.paint import Texture
from riot.errors import FabricationError
from riot.fabricate.certificate import Built, build, fix
from riot.fabricate.export.paperwork import SHEETS, write_paperwork
from riot.fabricate.export.solids import write_puzzle
from riot.parameters import FabricationParameters
from riot.transform.riot_file import from_json
from riot.transform.transform import Transform


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Pictures | None) -> Artifact:
    """A transform with its motion → the puzzle's files by name, (bytes,) uint8 each, and a document.

    The document has what the columns of `pipeline.tables.schemas.FABRICATIONS` say of a puzzle.

    ``spec``: the colour pictures of its shapes, for the texture sheets among the paperwork; one that cannot be a
    texture is told in the warnings. A puzzle that cannot be made, or fails its certificate, has no files and a reason:
    it is no error.
    """
    (planned,), (sizes, mend, paper) = inputs, parameters
    errors: list[ErrorRow] = []

    def made() -> Artifact:
        try:
            return _made(from_json(planned.document["riot"]), sizes, mend, paper, spec or (None, None))
        except FabricationError as error:
            said = {"status": "refused", "reason": error.reason, "message": str(error)}
            return Artifact({}, {**said, **_asked(sizes)})

    result = attempt(0, made, errors)
    return result if result is not None else Artifact({}, {"errors": errors})


def _made(transform: Transform, sizes: FabricationParameters, mend: bool, paper: bool, pictures: Pictures) -> Artifact:
    puzzle = (fix if mend else build)(transform, sizes)
    if not puzzle.certificate.passed:
        said = {"status": "failed", "reason": "uncertified", "message": "; ".join(puzzle.certificate.failures)}
        return Artifact({}, {**said, **_measured(puzzle)})
    textures, refused = read_textures(transform, pictures) if paper else ({}, [])
    files = _files(puzzle, paper, textures)  # may still find that a part is larger than the bed
    measured = _measured(puzzle)
    measured["warnings"] += [f"no {SHEETS[each.side]}: {each.message}" for each in refused]
    return Artifact(files, {"status": "certified", "reason": "", "message": "", **measured})


def _files(puzzle: Built, paper: bool, textures: Mapping[Side, Texture]) -> dict[str, AnyArray]:
    def paperwork(where: Path) -> None:
        write_paperwork(puzzle.design, where, textures, dxf=False)

    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "puzzle"
        paths = write_puzzle(puzzle.design, puzzle.parts, puzzle.certificate, folder, [paperwork] if paper else [])
        return {path.relative_to(folder).as_posix(): np.frombuffer(path.read_bytes(), dtype=np.uint8) for path in paths}


def _asked(sizes: FabricationParameters) -> dict[str, Any]:
    return {"size": sizes.size_mm, "thickness": sizes.height, "pin": sizes.pin_mm}


def _measured(puzzle: Built) -> dict[str, Any]:
    made, certificate = puzzle.design, puzzle.certificate
    pieces = [check for check in certificate.parts if not math.isnan(check.wall)]
    motion = certificate.motion
    return {
        **_asked(made.parameters),
        "changes": list(puzzle.changes),
        "parts": sum(check.count for check in certificate.parts),
        "components": max(check.components for check in certificate.parts),
        "volume": math.fsum(check.volume for check in pieces),
        "least_wall": certificate.wall,
        "least_gap": motion.gap if math.isfinite(motion.gap) else None,
        "proven_gap": motion.floor if motion.proven else None,
        "overlap": motion.overlap,
        "poses": motion.poses,
        "pin_hinges": sum(pin.count for pin in made.pins),
        "telescopic_hinges": made.sleeves,
        "warnings": list(made.warnings),
    }
