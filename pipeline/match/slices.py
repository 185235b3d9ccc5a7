"""`riot slices MODEL --in RUN`: search a mined collection for counterparts of a solid's slices."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from pipeline.errors import StartError
from pipeline.match.search import MinedRun, open_mined, trunks_as_mined
from pipeline.match.shapes import read_shapes
from pipeline.store.location import parse_location
from riot.cli import main as cli
from riot.cli.slices import given, slice_model
from riot.geometry.shape import Shape
from riot.scores.index import best_partners
from riot.scores.trunk_stack import stack
from riot.slices.assign import Candidate, Shortlist


def add_collection(commands: cli.Commands) -> None:
    """Add to the command `slices` the options that search a run."""
    parser = commands.choices["slices"]
    parser.add_argument(
        "--in", dest="run_folder", type=Path, metavar="RUN", help="become shapes of a run, as outputs/mpeg7"
    )
    parser.add_argument(
        "--store", type=parse_location, metavar="LOCATION", help="the run's store, if it was moved (DIR or URL)"
    )
    parser.set_defaults(run=run_slices)


def run_slices(chosen: argparse.Namespace) -> int:
    """Run ``riot slices``; returns the exit code, as `riot.cli.slices` documents.

    Raises `StartError` unless either files or a run is given, and as `pipeline.match.search.open_mined` does.
    """
    if (chosen.run_folder is None) == (not chosen.into):
        raise StartError("give the shapes to become either as files (--into A.png,B.png) or as a run (--in RUN)")
    if chosen.run_folder is None:
        return slice_model(chosen, given(chosen.into))
    mined = open_mined(chosen.run_folder, chosen.store)
    return slice_model(chosen, lambda slices, keep: shortlists(mined, slices, keep), mined.config.shape)


def shortlists(mined: MinedRun, slices: Sequence[Shape], keep: int) -> tuple[Shortlist, ...]:
    """The ``keep`` best counterparts of every slice by QCRS among a run's shapes, exact, through its index.

    Raises `StartError` if the run's store is gone or altered.
    """
    index = mined.index(lambda message: print(f"riot: {message}", file=sys.stderr))
    queries = stack([trunks_as_mined(mined, shape) for shape in slices])
    scores = best_partners(index, queries, keep, mined.config.qcrs.sigmas).scores
    numbers = mined.numbers[scores.j].tolist()
    shapes = read_shapes(mined, set(numbers))
    candidates: list[list[Candidate]] = [[] for _ in slices]
    for i, number, score in zip(scores.i.tolist(), numbers, scores.score.tolist(), strict=True):
        candidates[i].append(Candidate(shapes[number], score))
    return tuple(tuple(shortlist) for shortlist in candidates)
