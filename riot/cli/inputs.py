"""The two silhouettes of a command: arguments A and B, and the shapes in these files. Ours."""

from __future__ import annotations

import argparse
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

from riot.cli.parser import Parser, UsageError
from riot.geometry.quality import ReadingQuality
from riot.geometry.shape import Shape
from riot.geometry.silhouette import read
from riot.parameters import BendParameters

LONGEST_STEM = 200
"""Bytes of a file's name without suffix: file systems take 255 with it (ours)."""

PICTURE = "a picture (PNG, GIF, BMP, TIFF, JPEG, WebP, AVIF) or an SVG file"


def add_inputs(parser: Parser) -> None:
    """Add A and B to the arguments of a command."""
    parser.add_argument("a", type=Path, metavar="A", help=PICTURE)
    parser.add_argument("b", type=Path, metavar="B", help="another one")


def add_pieces(parser: Parser) -> None:
    """Add the option ``--pieces`` to a command: `riot.construction.plan_search.PieceCounts`."""
    parser.add_argument(
        "--pieces", type=_counts, metavar="N[..M]", help="number of pieces, such as 4 or 3..5 (default: any)"
    )


def add_bend(parser: Parser) -> None:
    """Add the option ``--bend`` to a command: how to bend the inputs first, None for not at all."""
    default = BendParameters.weight
    parser.add_argument(
        "--bend",
        nargs="?",
        type=_bend,
        const=BendParameters(method="elastic"),
        metavar="WEIGHT",
        help="bend both shapes a little before they are cut, so that more of them stays; the greater the weight, the "
        f"less they bend ({default:g} if none is given, off for not at all, which is the default)",
    )


def add_mirror(parser: Parser) -> None:
    """Add the option ``--mirror-q`` to a command."""
    parser.add_argument(
        "--mirror-q",
        nargs="?",
        choices=("yes", "no", "best"),
        const="yes",
        default="no",
        help="cut B's mirror image, so that B is read on the back, when the puzzle is turned over; best: front or "
        "back, whichever is more like B (default: no, B is read on the front)",
    )


def add_force(parser: Parser) -> None:
    """Add the option ``--force`` to a command that writes files: ``replace_files`` of the library."""
    parser.parameter_option(
        "--force", "replace_files", action="store_true", help="replace the files of an older puzzle that are there"
    )


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


def _counts(text: str) -> tuple[int, int]:
    least, dots, most = text.partition("..")
    if not (least.isdecimal() and (most.isdecimal() or not dots)):
        raise argparse.ArgumentTypeError(f"{text!r} is neither a number nor a range such as 4..6")
    counts = int(least), int(most or least)
    if not 3 <= counts[0] <= counts[1]:
        raise argparse.ArgumentTypeError(f"{text!r} is no range of numbers of pieces: there are 3 or more")
    return counts


def _bend(text: str) -> BendParameters | None:
    if text == "off":
        return None
    try:
        weight = float(text)
    except ValueError:
        weight = math.nan
    if not 0.0 <= weight < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is neither a weight, a number of 0 or more, nor off")
    return BendParameters(method="elastic", weight=weight)


def _named(path: Path, other: Path) -> Shape:
    name = path.name if path.stem == other.stem else path.stem
    return read(path).renamed(name)
