"""The command `riot match A --in RUN`: the best partners of a silhouette in a mined collection. Ours."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import Any

from pipeline.match.search import MatchResult, MinedRun, Query, match, open_mined, read_query
from pipeline.store.location import parse_location
from riot.cli.common_options import PICTURE
from riot.cli.output import Output
from riot.cli.parser import EXIT_CODES, REFUSED, Parser
from riot.cli.table import Table
from riot.kernels.warm import compile_used

FOUND, NOTHING = 0, 1


def add_options(parser: Parser) -> None:
    """See `riot.cli.command.CommandModule`."""
    parser.add_argument("a", type=Path, metavar="A", help=PICTURE)
    parser.add_argument(
        "--in", dest="run_folder", type=Path, required=True, metavar="RUN", help="folder of a run, as outputs/mpeg7"
    )
    parser.add_argument("--top", type=_count, default=10, metavar="K", help="how many partners (default: 10)")
    parser.add_argument(
        "--store", type=parse_location, metavar="LOCATION", help="the run's store, if it was moved (DIR or URL)"
    )
    parser.flags["store=LOCATION"] = "--store LOCATION"
    parser.add_argument("--timings", action="store_true", help="print how long each step took, on standard error")
    parser.exit_codes = {
        FOUND: "There are partners.",
        NOTHING: "There are none: a shape without trunks, or none that fits.",
        REFUSED: EXIT_CODES[REFUSED],
    }


def run(chosen: argparse.Namespace, output: Output) -> int:
    """See `riot.cli.command.CommandModule`."""
    clock = _Clock()
    compile_used(output.note, __name__)
    clock.lap("kernels ready")
    mined = open_mined(chosen.run_folder, chosen.store)
    clock.lap("run read and checked")
    query = read_query(mined, chosen.a)
    clock.lap("shape read, trunks found")
    index = mined.index(output.note)
    clock.lap("index loaded")
    result = match(mined, index, query, chosen.top)
    clock.lap("searched")
    _remark(mined, query, result, output)
    shown = [_table(mined, query, result)] if len(result.scores.j) else []
    output.facts(document(mined, query, result), *shown)
    if chosen.timings or chosen.verbose:
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


def _table(mined: MinedRun, query: Query, result: MatchResult) -> Table:
    title = f"{query.name}: best of the {len(mined.names):,} shapes of {mined.dataset}"
    partners = [
        (
            str(row["rank"]),
            row["name"],
            row["class"],
            f"{row['qcrs']:.4f}",
            str(row["n"]),
            f"{row['trunk']} ~ {row['partner_trunk']}",
        )
        for row in rows(mined, result)
    ]
    return Table(("rank", "shape", "class", "QCRS", "n", "trunks"), partners, title, left=("shape", "class"))


def _remark(mined: MinedRun, query: Query, result: MatchResult, output: Output) -> None:
    if result.itself is not None:
        output.note(f"the same file is in the collection, as {mined.names[result.itself]}, and is left out")
    if mined.unknown:
        output.note(f"the trunks of {mined.unknown} shapes failed (errors.parquet tells why): they cannot be partners")
    if len(query.trunks) == 0:
        output.note(
            f"{query.name} has no trunk: no convex polygon on its outline that a reversible transform could hinge at"
        )
    elif len(result.scores.j) == 0:
        output.note(f"{query.name} has {len(query.trunks)} trunks, and no shape of the collection has one that fits")


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


def _count(text: str) -> int:
    number = int(text) if text.isascii() and text.isdigit() else 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number above 0")
    return number
