"""The command `riot check FOLDER`: a contact sheet of all outlines on their pictures, the doubtful ones first. Ours."""

from __future__ import annotations

import argparse
from pathlib import Path

from pipeline.datasets.collection import DUPLICATE, DatasetConfig, collect
from pipeline.datasets.reading import open_item
from pipeline.report.check import Refused, Tile, sheet, tile
from pipeline.store.store import write_atomically
from riot.cli.common_options import add_force
from riot.cli.inputs import quality_facts
from riot.cli.output import Output
from riot.cli.parser import DONE, EXIT_CODES, Parser
from riot.errors import SilhouetteError
from riot.fabricate.export.folder import check_files
from riot.kernels.warm import compile_used

DOUBTFUL = 4
"""Exit code: the sheet is written, and a person should look at it."""


def add_options(parser: Parser) -> None:
    """See `riot.cli.command.CommandModule`."""
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="pictures and SVG files; sub-folders count")
    parser.add_argument(
        "-o", "--output", type=Path, default=Path("check.html"), metavar="FILE", help="the page (default: %(default)s)"
    )
    add_force(parser)
    parser.exit_codes = {
        **EXIT_CODES,
        DOUBTFUL: "The page is written, and an outline may be wrong, or a file cannot be read.",
    }


def run(chosen: argparse.Namespace, output: Output) -> int:
    """See `riot.cli.command.CommandModule`; raises `pipeline.datasets.collection.DatasetError` if there is nothing."""
    check_files([chosen.output], replace_files=chosen.replace_files)
    collection = collect(DatasetConfig(name="check", kind="folder", root=str(chosen.folder)))
    compile_used(output.note, __name__)
    tiles: list[Tile] = []
    refused = [Refused(row.name, row.message) for row in collection.rejected if row.reason != DUPLICATE]
    for item in collection.items:
        try:
            tiles.append(tile(item.name, item.source, open_item(item)))
        except SilhouetteError as error:
            refused.append(Refused(item.name, str(error)))
    chosen.output.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(chosen.output, sheet(chosen.folder.resolve().name, tiles, refused).encode())
    doubtful = [one for one in tiles if one.quality.doubtful]
    output.show(
        f"{len(tiles)} read, {len(doubtful)} doubtful, {len(refused)} refused",
        *(f"{one.name}: {doubt}" for one in doubtful for doubt in one.quality.doubts),
        *(f"{one.name}: {one.message}" for one in refused),
        str(chosen.output),
    )
    shapes = [{"name": one.name, "reading": quality_facts(one.quality)} for one in tiles]
    errors = [{"name": one.name, "message": one.message} for one in refused]
    output.document({"shapes": shapes, "refused": errors, "page": chosen.output})
    return DOUBTFUL if doubtful or refused else DONE
