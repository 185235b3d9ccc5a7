"""A transform's own page in the gallery: its card, how it moves, its puzzle, and where it comes from. Ours."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipeline.report.card import Card
from pipeline.report.gallery import INDEX, SCRIPT, STYLE, page_name
from pipeline.report.markup import document, facts, hidden_definitions, number, section
from pipeline.report.rows import TransformRow
from riot.draw.svg import escape
from riot.motion.planner import motion_of
from riot.transform.history import History
from riot.transform.provenance import describe_history
from riot.transform.transform import Transform


def single(
    shown: Card,
    transform: Transform,
    puzzle: Mapping[str, Any] | None,
    before: TransformRow | None,
    after: TransformRow | None,
) -> str:
    """The page of one card; ``puzzle`` is its row of the table `FABRICATIONS`, the others lead on from here."""
    row = shown.row
    body = (
        f"{hidden_definitions([shown.definitions])}"
        f'<header class="top"><nav aria-label="Gallery">{_step("prev", "← previous", before)}'
        f'<a rel="up" href="{INDEX}">gallery</a>{_step("next", "next →", after)}</nav>'
        f'<p class="kicker">Transform {row.rank}</p><h1>{shown.names}</h1>{shown.worth}</header>\n'
        f'<main><article class="card">{shown.content}</article>\n'
        f"{_motion(row, transform)}{_puzzle(puzzle)}{_history(transform.history)}</main>\n"
        f'<footer><a href="../{escape(row.file)}">{escape(row.file)}</a>: the transform itself, '
        "for <code>riot show</code> and <code>riot print</code>.</footer>\n"
    )
    head = f'<link rel="stylesheet" href="{STYLE}"><script defer src="{SCRIPT}"></script>'
    return document(f"{row.name_p} ⇄ {row.name_q}", head, body)


def _step(rel: str, words: str, row: TransformRow | None) -> str:
    if row is None:
        return ""
    said = f"{row.name_p} and {row.name_q}"
    return f'<a rel="{rel}" href="{page_name(row)}" title="{escape(said)}">{words}</a>'


def _motion(row: TransformRow, transform: Transform) -> str:
    if row.approximate:
        said = "No motion is planned for an approximate transform: its pieces overlap already when it is closed."
        return section("motion", "Motion", f"<p>{said}</p>")
    motion = motion_of(transform)
    told_of = [
        ("the chain", escape(motion.words)),
        ("open hinge", str(motion.open_hinge)),
        ("hinges that lift", ", ".join(map(str, motion.lifted)) or "none"),
        ("how hinges turn", escape(motion.search)),
    ]
    return section("motion", "Motion", f'<div class="sheet">{facts(told_of)}</div>')


def _puzzle(puzzle: Mapping[str, Any] | None) -> str:
    if puzzle is None:
        return ""
    if not puzzle["folder"]:
        return section("puzzle", "Puzzle", f"<p>{escape(puzzle['status'])}: {escape(puzzle['message'])}</p>")
    sizes = [
        ("certificate", escape(puzzle["status"])),
        ("long side", f"{number(puzzle['size'], 0)} mm"),
        ("thickness", f"{number(puzzle['thickness'], 1)} mm"),
        ("parts to print", str(puzzle["parts"])),
        ("least wall", f"{number(puzzle['least_wall'], 2)} mm"),
        ("proven gap", f"{number(puzzle['proven_gap'])} mm"),
        ("files", f'<a href="../{escape(puzzle["folder"])}/">folder</a>'),
    ]
    warnings = "".join(f"<p>{escape(one)}</p>" for one in puzzle["warnings"] or ())
    return section("puzzle", "Puzzle", f'<div class="sheet">{facts(sizes)}{warnings}</div>')


def _history(history: History | None) -> str:
    if history is None:
        return section("history", "Where it comes from", '<p class="empty">The file does not tell.</p>')
    lines = escape("\n".join(describe_history(history)))
    note = "By content: no path, time or host. Equal inputs, code and libraries give an equal history."
    shown = f'<details><summary>pictures, parameters, code and libraries</summary><pre class="scroll">{lines}</pre>'
    return section("history", "Where it comes from", f'<div class="sheet">{shown}</details></div>', note)
