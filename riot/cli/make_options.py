"""What may be wished for of `riot make`: its options. Ours."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from riot.cli.common_options import add_bend, add_force, add_inputs, add_mirror, add_pieces
from riot.cli.parser import EXIT_CODES, Parser, UsageError
from riot.construction.plan_search import PieceCounts
from riot.draw.texture.names import SIDES, Side
from riot.parameters import BendParameters

POOR = 4
"""Exit code: files are written, but a shape is less like its input than was asked for, or an outline is doubtful."""

MIN_IOU = 0.85
"""Ours: below it most of what makes a silhouette recognisable is lost; half of the class pairs of MPEG-7 reach more."""


@dataclass(frozen=True)
class Wishes:
    """What else to do than the usual: films by suffix (.gif, .mp4), the trunk pair by rank, pins, the method, bends."""

    films: tuple[str, ...] = ()
    rank: int | None = None
    pins: Path | None = None
    method: Literal["exact", "laplacian"] = "exact"
    pieces: PieceCounts | None = None
    pictures: Mapping[Side, Path] | None = None
    """Colour pictures of P and Q, of the same size as the inputs: what the pieces show."""
    bend: BendParameters | None = None
    stiff: Path | None = None
    replace_files: bool = False
    mirror_q: Literal["yes", "no", "best"] = "no"


def add_options(parser: Parser) -> None:
    """See `riot.cli.command.CommandModule`."""
    add_inputs(parser)
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="where results go")
    parser.add_argument("--rank", type=int, metavar="K", help="use the trunk pair of this rank of `riot trunks`")
    add_force(parser)
    add_mirror(parser)
    add_pieces(parser)
    add_bend(parser)
    parser.add_argument(
        "--stiff", type=Path, metavar="FILE", help="regions of the shapes that --bend bends less (JSON)"
    )
    parser.add_argument("--pins", type=Path, metavar="FILE", help="keep or redraw stretches of the outlines (JSON)")
    parser.add_argument(
        "--method", choices=("exact", "laplacian"), default="exact", help="laplacian: the paper's, not exact"
    )
    parser.add_argument(
        "--min-iou",
        type=_ratio,
        default=MIN_IOU,
        metavar="IOU",
        help="likeness that both shapes must have, as they are bent if they are: below it the exit code is 4, and the "
        "files are written all the same (default: %(default)s)",
    )
    parser.add_argument("--gif", action="store_true", help="film the motion as an animated GIF too")
    parser.add_argument("--mp4", action="store_true", help="film it as an MP4 too (needs ffmpeg, or the extra 'film')")
    for side, name in zip(SIDES, "AB", strict=True):
        parser.add_argument(
            f"--texture-{side}",
            type=Path,
            metavar="PICTURE",
            help=f"show {name}'s colours on the pieces, from a picture of its size ({name} itself, if it has colours)",
        )
    parser.exit_codes = {
        **EXIT_CODES,
        POOR: "Done, but a shape is less like its input than --min-iou asks, or its outline may be wrong.",
    }


def wishes_of(chosen: argparse.Namespace) -> Wishes:
    """What the options ask for; raises `riot.cli.parser.UsageError` for options that do not go together."""
    films = tuple(f".{kind}" for kind in ("gif", "mp4") if getattr(chosen, kind))
    pictures = {side: path for side in SIDES if (path := getattr(chosen, f"texture_{side}"))}
    if chosen.stiff is not None and chosen.bend is None:
        raise UsageError("--stiff FILE says what bends less: give --bend, too")
    return Wishes(
        films=films,
        rank=chosen.rank,
        pins=chosen.pins,
        method=chosen.method,
        pieces=chosen.pieces,
        pictures=pictures,
        bend=chosen.bend,
        stiff=chosen.stiff,
        replace_files=chosen.replace_files,
        mirror_q=chosen.mirror_q,
    )


def _ratio(text: str) -> float:
    try:
        ratio = float(text)
    except ValueError:
        ratio = math.nan
    if not 0.0 <= ratio <= 1.0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number from 0 to 1")
    return ratio
