"""The two silhouettes of a command: arguments A and B, and the shapes in these files. Ours."""

from __future__ import annotations

from pathlib import Path

from riot.cli.parser import Parser
from riot.geometry.shape import Shape
from riot.geometry.silhouette import read

PICTURE = "a picture (PNG, GIF, BMP, TIFF, JPEG) or an SVG file"


def add_inputs(parser: Parser) -> None:
    """Add A and B to the arguments of a command."""
    parser.add_argument("a", type=Path, metavar="A", help=PICTURE)
    parser.add_argument("b", type=Path, metavar="B", help="another one")


def read_inputs(path_a: Path, path_b: Path) -> tuple[Shape, Shape]:
    """The two shapes, named so that they can be told apart; raises `riot.errors.SilhouetteError`, OSError."""
    return _named(path_a, path_b), _named(path_b, path_a)


def _named(path: Path, other: Path) -> Shape:
    name = path.name if path.stem == other.stem else path.stem
    return read(path).renamed(name)
