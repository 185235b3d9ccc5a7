"""The command `riot slices`, which also takes shapes to become from a mined collection: ``--in RUN``. Ours."""

from __future__ import annotations

import argparse
from pathlib import Path

from pipeline import cli  # what searches a run is loaded for --in only: it stands on the tables
from pipeline.errors import StartError
from pipeline.store.location import parse_location
from riot.cli import slices
from riot.cli.output import Output
from riot.cli.parser import Parser


def add_options(parser: Parser) -> None:
    """See `riot.cli.command.CommandModule`."""
    slices.add_options(parser)
    parser.add_argument(
        "--in", dest="run_folder", type=Path, metavar="RUN", help="become shapes of a run, as outputs/mpeg7"
    )
    parser.add_argument(
        "--store", type=parse_location, metavar="LOCATION", help="the run's store, if it was moved (DIR or URL)"
    )
    parser.flags["store=LOCATION"] = "--store LOCATION"


def run(chosen: argparse.Namespace, output: Output) -> int:
    """See `riot.cli.command.CommandModule`.

    Raises `StartError` unless either files or a run is given, and as `pipeline.match.search.open_mined` does.
    """
    if (chosen.run_folder is None) == (not chosen.into):
        raise StartError("give the shapes to become either as files (--into A.png,B.png) or as a run (--in RUN)")
    if chosen.run_folder is None:
        return slices.slice_model(chosen, output, slices.given(chosen.into))
    search, sampling = cli.mined_shapes.search_run(chosen.run_folder, chosen.store, output.note)
    return slices.slice_model(chosen, output, search, sampling)
