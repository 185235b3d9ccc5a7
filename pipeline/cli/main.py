"""The command ``riot``: the commands of `riot.cli.main`, and ``match`` and ``slices`` over a mined collection.

Exit codes of ``match``: 0 partners found, 1 none (a shape without trunks, or none that fits), 2 could not be done.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)
from pipeline.match.search import MatchResult, MinedRun, Query, match, open_mined, read_query
from pipeline.match.slices import add_collection
from pipeline.store.location import parse_location
from riot.cli import main as cli
from riot.kernels.warm import warm_all

FOUND, NOTHING = 0, 1
PIPED_WIDTH = 140
FORMAT, VERSION = "riot-match", 1


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns its exit code."""
    return cli.main(arguments, [_add_match, add_collection])


def run_match(chosen: argparse.Namespace) -> int:
    """Run ``riot match``: prints the partners as a table or JSON on standard output, all else on standard error."""
    clock = _Clock()
    warm_all(_say)
    clock.lap("kernels ready")
    mined = open_mined(chosen.run_folder, chosen.store)
    clock.lap("run read and checked")
    query = read_query(mined, chosen.a)
    clock.lap("shape read, trunks found")
    index = mined.index(_say)
    clock.lap("index loaded")
    result = match(mined, index, query, chosen.top)
    clock.lap("searched")
    _remark(mined, query, result)
    if chosen.json:
        print(json.dumps(document(mined, query, result), indent=1, ensure_ascii=False))
    elif len(result.scores.j):
        _print_table(mined, query, result)
    if chosen.timings:
        clock.show()
    return FOUND if len(result.scores.j) else NOTHING


def rows(mined: MinedRun, result: MatchResult) -> list[dict[str, Any]]:
    """A row for each partner, best first: its number, name and class, the score, and the trunks that give it.

    Vertex k of the query's ``trunk`` corresponds to vertex ``(shift − k) mod n`` of ``partner_trunk``, which is a
    number in the run's table of trunks.
    """
    scores = result.scores
    columns = (scores.j, scores.score, scores.n, scores.trunk_i, scores.trunk_j, scores.shift)
    return [
        {
            "rank": rank,
            "shape": shape,
            "name": mined.names[shape],
            "class": mined.classes[shape],
            "qcrs": score,
            "n": n,
            "trunk": trunk,
            "partner_trunk": partner_trunk,
            "shift": shift,
        }
        for rank, (shape, score, n, trunk, partner_trunk, shift) in enumerate(
            zip(*(column.tolist() for column in columns), strict=True), start=1
        )
    ]


def document(mined: MinedRun, query: Query, result: MatchResult) -> dict[str, Any]:
    """The result as JSON values; ``trunk_vertices`` are indices into the points of the query's shape."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "query": {
            "name": query.name,
            "digest": query.digest,
            "trunks": len(query.trunks),
            "itself": None if result.itself is None else mined.names[result.itself],
        },
        "collection": {"dataset": mined.dataset, "folder": str(mined.folder), "shapes": len(mined.names)},
        "compared": result.compared,
        "partners": [{**row, "trunk_vertices": query.trunks.of(row["trunk"]).tolist()} for row in rows(mined, result)],
    }


def _print_table(mined: MinedRun, query: Query, result: MatchResult) -> None:
    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=PIPED_WIDTH)
    title = f"{query.name}: best of the {len(mined.names):,} shapes of {mined.dataset}"
    table = Table(title=title, title_justify="left")
    for name in ("rank", "shape", "class", "QCRS", "n", "trunks"):
        table.add_column(name, justify="left" if name in ("shape", "class") else "right")
    for row in rows(mined, result):
        trunks = f"{row['trunk']} ~ {row['partner_trunk']}"
        table.add_row(str(row["rank"]), row["name"], row["class"], f"{row['qcrs']:.4f}", str(row["n"]), trunks)
    console.print(table, markup=False)


def _remark(mined: MinedRun, query: Query, result: MatchResult) -> None:
    if result.itself is not None:
        _say(f"the same file is in the collection, as {mined.names[result.itself]}, and is left out")
    if mined.unknown:
        _say(f"the trunks of {mined.unknown} shapes failed (errors.parquet tells why): they cannot be partners")
    if len(query.trunks) == 0:
        _say(f"{query.name} has no trunk: no convex polygon on its outline that a reversible transform could hinge at")
    elif len(result.scores.j) == 0:
        _say(f"{query.name} has {len(query.trunks)} trunks, and no shape of the collection has one that fits")


class _Clock:
    """Wall-clock seconds between the steps of a command."""

    def __init__(self) -> None:
        self._last = time.perf_counter()
        self._laps: list[tuple[str, float]] = []

    def lap(self, name: str) -> None:
        now = time.perf_counter()
        self._laps.append((name, now - self._last))
        self._last = now

    def show(self) -> None:
        for name, seconds in self._laps:
            print(f"{1e3 * seconds:10.1f} ms  {name}", file=sys.stderr)


def _say(text: str) -> None:
    print(f"riot: {text}", file=sys.stderr)


def _add_match(commands: cli.Commands) -> None:
    parser = commands.add_parser("match", help="find the best partners of a silhouette in a mined collection")
    parser.add_argument("a", type=Path, metavar="A", help="a picture (PNG, GIF, BMP, TIFF, JPEG) or an SVG file")
    parser.add_argument(
        "--in", dest="run_folder", type=Path, required=True, metavar="RUN", help="folder of a run, as outputs/mpeg7"
    )
    parser.add_argument("--top", type=_count, default=10, metavar="K", help="how many partners (default: 10)")
    parser.add_argument(
        "--store", type=parse_location, metavar="LOCATION", help="the run's store, if it was moved (DIR or URL)"
    )
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    parser.add_argument("--timings", action="store_true", help="print how long each step took, on standard error")
    parser.set_defaults(run=run_match)


def _count(text: str) -> int:
    number = int(text) if text.isascii() and text.isdigit() else 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number above 0")
    return number


if __name__ == "__main__":
    sys.exit(main())
