"""Read what a person gives: a picture, a vector file or a transform, as bytes that nobody has looked at."""

from __future__ import annotations

import json
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath

from riot.errors import FormatError, SilhouetteError
from riot.geometry.silhouette import read
from riot.transform import shape_document
from riot.transform.riot_file import FORMAT, from_json
from riot.transform.transform import Transform
from studio.session.folder import digest_of
from studio.session.state import State
from studio.work.answer import Answer, kept
from studio.work.textures import has_colours

MAX_NAME = 60


@dataclass(frozen=True)
class ShapeFile:
    """A shape's document, its name, why its outline may be wrong, and whether its picture has several colours."""

    digest: str
    text: bytes
    name: str
    doubts: tuple[str, ...] = ()
    colours: bool = False


def clean_name(name: str) -> str:
    """The name of a shape from a file's name that a browser gave: no folder, no suffix, not long.

    >>> clean_name("C:\\\\pictures\\\\../bat 3.png"), clean_name("")
    ('bat 3', 'shape')
    """
    stem = PurePosixPath(name.replace("\\", "/")).stem
    plain = "".join(character for character in stem if character.isprintable()).strip(". ")
    return plain[:MAX_NAME] or "shape"


def is_transform(data: bytes) -> bool:
    """Whether bytes look like a ``.riot`` file."""
    return data.lstrip()[:1] == b"{" and FORMAT.encode() in data[:200]


def read_shape(data: bytes, name: str) -> ShapeFile:
    """Read a picture or an SVG file by the guarded readers; raises `SilhouetteError` in words that name ``name``."""
    plain = clean_name(name)
    with tempfile.TemporaryDirectory(prefix="riot-studio-") as folder:
        path = Path(folder) / "input"  # the readers look at the content, not at the name
        path.write_bytes(data)
        try:
            shape = read(path).renamed(plain)
        except SilhouetteError as error:
            raise SilhouetteError(error.reason, str(error).replace(str(path), plain)) from None
        colours = has_colours(path, shape)
    doubts = () if shape.quality is None else shape.quality.doubts
    return replace(shape_file(shape_document.to_document(shape)), doubts=doubts, colours=colours)


def shape_file(document: dict[str, object]) -> ShapeFile:
    """A shape's document as it is kept."""
    text = json.dumps(document, ensure_ascii=False, separators=(",", ":")).encode("utf-8")
    return ShapeFile(digest_of(text), text, str(document["name"]))


def open_transform(data: bytes, name: str) -> tuple[Answer, tuple[ShapeFile, ShapeFile]]:
    """The state that a ``.riot`` file is, and its inputs; raises `riot.errors.FormatError`."""
    try:
        transform = from_json(data.decode("utf-8"), clean_name(name))
    except UnicodeDecodeError as error:
        raise FormatError(f"{clean_name(name)} is not a .riot file: it is not UTF-8") from error
    inputs = tuple(shape_file(shape_document.to_document(shape)) for shape in (transform.input_p, transform.input_q))
    made = kept(transform)
    state = State(
        step="open",
        p=inputs[0].digest,
        q=inputs[1].digest,
        weight=1.0 if _is_bent(transform) else None,
        root=made.digest,
        base=made.digest,
        shown=made.digest,
    )
    return Answer(state, made), (inputs[0], inputs[1])


def _is_bent(transform: Transform) -> bool:
    return transform.bend_p is not None or transform.bend_q is not None
