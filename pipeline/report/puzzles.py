"""The section of puzzles that were made of the best transforms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pipeline.report.markup import NOTHING, count, linked, number, section, small, table
from riot.draw.svg import escape

HEAD = (
    "pair", "certificate", "size mm", "parts", "hinges", "volume cm³", "least wall mm", "gap mm, proven", "overlap mm³",
    "in words", "files",
)  # fmt: skip


def puzzles(rows: Sequence[Mapping[str, Any]], links: Mapping[int, str]) -> str:
    """The section of the rows of `pipeline.tables.schemas.FABRICATIONS`; ``links`` lead to ranks."""
    note = (
        "Printable puzzles: every part is verified to be one closed solid, pieces to keep their gap at every moment of "
        "the planned motion, solids not to overlap where they are cut with each other. Clearances come from makers’ "
        "literature, not from our own prints."
    )
    numeric = (False, False, True, True, False, True, True, True, True, False, False)
    body = table(HEAD, [_cells(row, links) for row in rows], numeric, "Puzzles")
    return section("puzzles", "Puzzles", f'<div class="sheet">{body}</div>', note)


def _cells(row: Mapping[str, Any], links: Mapping[int, str]) -> list[str]:
    pair = linked(links, row["rank"], f"{escape(row['name_i'])} ⇄ {escape(row['name_j'])}")
    volume = row["volume"]
    said = [row["message"], *(f"changed {words}" for words in row["changes"] or ()), *(row["warnings"] or ())]
    return [
        f'<div class="pair">{pair}</div>',
        escape(row["status"]),
        number(row["size"], 0),
        count(row["parts"]),
        _hinges(row),
        number(None if volume is None else volume / 1000.0, 1),
        number(row["least_wall"], 2),
        number(row["proven_gap"]),
        small(row["overlap"]),
        f'<div class="long">{escape("; ".join(words for words in said if words))}</div>',
        f'<a href="{escape(row["folder"])}/">folder</a>' if row["folder"] else NOTHING,
    ]


def _hinges(row: Mapping[str, Any]) -> str:
    if row["pin_hinges"] is None:
        return NOTHING
    return f"{row['pin_hinges']} pin" + (f", {row['telescopic_hinges']} telescopic" if row["telescopic_hinges"] else "")
