"""The files that `riot make` writes of a transform: itself, pictures, an animation, films. Ours."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from riot.draw.animate import animate_svg
from riot.draw.figure import draw_transform
from riot.draw.film import write_film
from riot.draw.piece_image import PieceImages
from riot.draw.strip import draw_strip
from riot.transform.riot_file import save
from riot.transform.transform import Transform

SUFFIXES = (".riot", ".svg", ".png", ".strip.svg", ".strip.png", ".swing.svg")
"""Of the files that are always written."""


def write_transform(transform: Transform, stem: Path, films: Sequence[str], images: PieceImages) -> Iterator[Path]:
    """Write the files of a transform, ``stem`` and a suffix each; yields each path when it is written."""

    def swing(path: Path) -> None:
        path.write_text(animate_svg(transform, images), encoding="utf-8")

    writers: list[Callable[[Path], None]] = [
        lambda path: save(transform, path),
        *[lambda path: draw_transform(transform, path, images)] * 2,
        *[lambda path: draw_strip(transform, path, images)] * 2,
        swing,
        *[lambda path: write_film(transform, path, images=images)] * len(films),
    ]
    for suffix, write in zip((*SUFFIXES, *films), writers, strict=True):
        path = stem.with_name(f"{stem.name}{suffix}")
        write(path)
        yield path
