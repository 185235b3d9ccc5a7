"""The two silhouettes of a command, from the files A and B. Ours."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

from riot.cli.parser import UsageError
from riot.geometry.quality import ReadingQuality
from riot.geometry.shape import Shape
from riot.geometry.silhouette import read

LONGEST_STEM = 200
"""Bytes of a file's name without suffix: file systems take 255 with it (ours)."""


def read_inputs(path_a: Path, path_b: Path) -> tuple[Shape, Shape]:
    """The two shapes, named so that they can be told apart.

    Raises `riot.errors.SilhouetteError`, OSError, and `UsageError` for a name that is no text: no file could have it.
    """
    for path in (path_a, path_b):
        try:
            str(path).encode()
        except UnicodeEncodeError as error:
            shown = str(path).encode(errors="backslashreplace").decode()
            raise UsageError(f"{shown}: the name is no text (UTF-8); rename the file") from error
    return _named(path_a, path_b), _named(path_b, path_a)


def pair_stem(path_a: Path, path_b: Path) -> str:
    """The name, without suffix, of the files of a pair; long names are cut.

    >>> pair_stem(Path("cat.png"), Path("dog.svg"))
    'cat--dog'
    """
    stems = [path_a.stem, path_b.stem]
    if len("--".join(stems).encode()) > LONGEST_STEM:
        stems = [stem.encode()[: LONGEST_STEM // 2 - 1].decode(errors="ignore") for stem in stems]
    return "--".join(stems)


def quality_facts(quality: ReadingQuality) -> dict[str, Any]:
    """How well an outline was read, for a JSON document."""
    return {**asdict(quality), "doubts": quality.doubts}


def _named(path: Path, other: Path) -> Shape:
    name = path.name if path.stem == other.stem else path.stem
    return read(path).renamed(name)
