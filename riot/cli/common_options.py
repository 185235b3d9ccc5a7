"""Arguments and options that several commands have. Ours."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from riot.cli.parser import Parser
from riot.parameters import BendParameters

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
