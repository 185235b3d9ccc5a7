"""A run's files of textures: the images of the pieces whose inputs are colour pictures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pipeline.errors import PayloadError
from pipeline.stages.paint import unpack_images
from pipeline.store.artifact import Artifact, decode, encode
from pipeline.store.store import write_atomically
from pipeline.tables.outputs import new_place, replace_folder
from pipeline.tables.results import Results, Row
from riot.draw.piece_image import NO_IMAGES, PieceImages

FOLDER, SUFFIX = "skins", ".skins"


def write_textures(results: Results, transforms: Sequence[Row], folder: Path) -> list[Path]:
    """Write ``skins/<pair>.skins`` for each transform that has images of its pieces; returns the files.

    ``transforms`` are the rows of that table, with file. Files are in the form of `pipeline.store.artifact`, named as
    the transforms'; those of an earlier run are replaced.
    """
    temporary = new_place(folder)
    temporary.mkdir()
    of_pair = {(row["i"], row["j"]): row for row in transforms}
    files = []
    for item in results.work.get("paint", ()):
        artifact = results.artifact(item)
        if artifact is not None and artifact.arrays:
            p, q = (int(results.numbers[position]) for position in item.members)
            name = Path(of_pair[p, q]["file"]).stem + SUFFIX
            write_atomically(temporary / name, encode(Artifact(artifact.arrays)))
            files.append(folder / FOLDER / name)
    replace_folder(temporary, folder / FOLDER)
    return files


def read_textures(folder: Path, transform_file: str, pieces: int) -> PieceImages:
    """The images of a transform of so many pieces in a run's folder; none if there is no whole file of them."""
    try:
        arrays = decode((folder / FOLDER / (Path(transform_file).stem + SUFFIX)).read_bytes()).arrays
        return unpack_images(arrays, pieces)
    except (OSError, PayloadError, KeyError):
        return NO_IMAGES
