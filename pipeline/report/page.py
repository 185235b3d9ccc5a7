"""The report as a page: sections in the order of the method, then the gallery."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pipeline.report.beside import beside
from pipeline.report.card import Card
from pipeline.report.gallery import INDEX
from pipeline.report.histogram import figure
from pipeline.report.markup import (
    NOTHING,
    SHOWN_PAIRS,
    count,
    document,
    hidden_definitions,
    linked,
    number,
    seconds,
    section,
    small,
    table,
)
from pipeline.report.puzzles import puzzles
from pipeline.report.rows import Run, TransformRow
from pipeline.report.style import style_sheet
from pipeline.tables.messages import remarks, several
from pipeline.tables.record import GALLERY, STUDY
from riot.draw.svg import escape

SHOWN_ERRORS = 200
"""The page shows no more rows of errors; the table has them all."""

SHOWN_CARDS = 100
"""The page shows no more transforms; the gallery has them all."""


def page(run: Run, cards: Sequence[Card], lost: Sequence[tuple[TransformRow, str]], gallery: Mapping[int, str]) -> str:
    """The whole HTML text; ``lost`` are transforms whose file could not be read, with the reason.

    ``cards`` are the best `SHOWN_CARDS`; ``gallery`` leads from the ranks of all that could be read to
    their pages.
    """
    name = dataset_name(run)
    links = {**gallery, **{one.row.rank: f"#t{one.row.rank}" for one in cards}}
    compared = "" if run.comparison is None else beside(run.comparison, links)
    printed = puzzles(run.fabrications, links) if run.fabrications else ""
    body = (
        f"{hidden_definitions(one.definitions for one in cards)}"
        f"{_top(run, name)}<main>\n{_gallery(run, cards, len(gallery))}{_best(run, links)}{printed}{compared}"
        f"{_scores(run)}{_timings(run)}{_rejected(run, lost)}{_errors(run)}{_settings(run)}</main>\n"
        "<footer>Written from the tables beside this page; it needs no network and no script. "
        f'What they tell of the scores: <a href="{STUDY}/index.html">studies</a>.</footer>\n'
    )
    return document(f"{name} · reversible transforms", f"<style>{style_sheet()}</style>", body)


def dataset_name(run: Run) -> str:
    """The name of the run's collection."""
    dataset = run.facts.get("dataset", run.folder.name)
    if isinstance(dataset, Mapping):
        dataset = dataset.get("name", run.folder.name)
    return str(dataset)


def _top(run: Run, name: str) -> str:
    best = number(max((row.iou for row in run.made), default=None))
    took = sum(float(row["seconds"] or 0.0) for row in run.timings)
    tiles = [
        (f"shapes in {several(run.classes, 'class', 'classes')}" if run.classes else "shapes", count(run.shapes)),
        ("pairs scored" if run.search is None else f"of {count(run.search.pairs)} pairs kept", count(run.pairs)),
        ("pairs selected", count(run.selected)),
        (
            ("exact and approximate transforms", f"{count(len(run.certified))} · {count(len(run.approximate))}")
            if run.approximate
            else ("exact transforms", count(len(run.certified)))
        ),
        ("rejected", count(len(run.rejected))),
        ("errors", count(len(run.errors))),
        ("best IoU", best),
        ("time of all stages", seconds(took)),
    ]
    links = [
        ("gallery", "Gallery"), ("best", "Best pairs"),
        *([("puzzles", "Puzzles")] if run.fabrications else []),
        *([("beside", "Beside the paper’s method")] if run.comparison is not None else []),
        ("scores", "Scores"), ("time", "Time"), ("rejected", "Rejected"), ("errors", "Errors"),
        ("settings", "Settings"),
    ]  # fmt: skip
    contents = "".join(f'<a href="#{anchor}">{title}</a>' for anchor, title in links)
    cells = "".join(f"<div><dt>{escape(what)}</dt><dd>{value}</dd></div>" for what, value in tiles)
    return (
        '<header class="top"><p class="kicker">Reversible transforms</p>'
        f"<h1>{escape(name)}</h1>"
        '<p class="lead">Pairs of silhouettes that are the same chain of hinged pieces, folded one way and the other. '
        "A piece keeps its colour in every picture of its transform.</p>"
        f'<nav aria-label="Sections">{contents}</nav>'
        f'<dl class="tiles">{cells}</dl>{_remarks(run)}</header>\n'
    )


def _remarks(run: Run) -> str:
    said = remarks(run.counts, run.policy)
    if run.search is not None:
        said.append(run.search.remark(run.pairs))
    return "".join(f'<p class="remark">{escape(one)}</p>' for one in said)


def _gallery(run: Run, cards: Sequence[Card], total: int) -> str:
    if not cards:
        return section("gallery", "Gallery", '<p class="empty">No transform was constructed.</p>')
    thumbs = "".join(one.thumb for one in cards)
    note = (
        "Least deformed first. IoU compares what the pieces make with the input, of the worse of the two shapes; "
        "no exact construction on the same trunks can pass its bound, and “change / least” is how much more area "
        "changes than there. Bending energy and directions of the outline tell how much of the input’s detail is kept."
    )
    if run.approximate:
        note += (
            " Approximate transforms, by the paper’s method, come after the exact ones: their pieces overlap and leave "
            "gaps, as the residual says, and no motion is planned for them."
        )
    lead = f'<p class="note"><a href="{GALLERY}/{INDEX}">All {count(total)} transforms, to filter and sort</a>'
    lead += f", each on a page of its own; here are the best {count(len(cards))}.</p>" if total > len(cards) else "</p>"
    body = f'{lead}<div class="thumbs">{thumbs}</div>\n{"".join(one.body for one in cards)}'
    return section("gallery", "Gallery", body, note)


def _best(run: Run, links: Mapping[int, str]) -> str:
    if not run.made:
        return section("best", "Best pairs", '<p class="empty">There are none.</p>')
    head = (
        "", "pair", "n", "IoU", "IoU P", "IoU Q", "change / least", "CRS", "QCRS", "Hausdorff / L<sub>c</sub>",
        "residual",
    )  # fmt: skip
    numeric = (True, False, *(True,) * 9)

    def cells(row: TransformRow) -> list[str]:
        far = max(row.hausdorff_p, row.hausdorff_q)
        names = linked(links, row.rank, f"{escape(row.name_p)} ⇄ {escape(row.name_q)}")
        if row.approximate:
            names += " (approximate)"
        values = (row.iou, row.iou_p, row.iou_q, row.change_ratio, row.crs, row.qcrs, far)
        pair = f'<div class="pair">{names}</div>'
        return [str(row.rank), pair, str(row.n), *(number(value) for value in values), small(row.area_residual)]

    rows = [cells(row) for row in run.made]
    body = table(head, rows[:SHOWN_PAIRS], numeric, "The least deformed transforms")
    if len(rows) > SHOWN_PAIRS:
        rest = table(head, rows[SHOWN_PAIRS:], numeric, "The other transforms")
        body += f"<details><summary>the other {len(rows) - SHOWN_PAIRS}</summary>{rest}</details>"
    return section("best", "Best pairs", f'<div class="sheet">{body}</div>')


def _scores(run: Run) -> str:
    plots = (
        figure(run.s_r, "Reversibility score", "shapes")
        + figure(run.qcrs, "QCRS, all pairs" if run.search is None else "QCRS, pairs kept", "pairs", logarithmic=True)
        + figure(run.crs, "CRS, selected pairs", "pairs")
        + figure(run.iou, "IoU of the worse shape", "transforms")
    )
    note = ""
    if run.pairs_without_trunks:
        note = f"Pairs that have no two trunks of one size, so that their QCRS is 0: {count(run.pairs_without_trunks)}."
    return section("scores", "Scores", f'<div class="plots">{plots}</div>', note)


def _timings(run: Run) -> str:
    longest = max((float(row["seconds"] or 0.0) for row in run.timings), default=0.0)
    head = (
        "stage",
        "items",
        "cached",
        "computed",
        "failed",
        "time",
        "",
        "processor time",
        "when first computed",
        "memory",
    )
    rows = []
    for row in run.timings:
        share = 100.0 * float(row["seconds"] or 0.0) / longest if longest else 0.0
        memory = row.get("peak_mb")
        rows.append(
            [
                escape(str(row["stage"])),
                *(count(row[name]) for name in ("items", "cached", "computed", "failed")),
                seconds(row["seconds"]),
                f'<span class="share"><i style="width:{share:.1f}%"></i></span>',
                seconds(row.get("cpu_seconds")),
                seconds(row.get("stored_seconds")),
                f"{count(memory)} MiB" if memory else NOTHING,
            ]
        )
    numeric = (False, True, True, True, True, True, False, True, True, True)
    note = "Items are work items: batches of shapes, blocks of pairs, or single pairs. What is cached costs no time."
    return section("time", "Time", f'<div class="sheet">{table(head, rows, numeric, "Stages")}</div>', note)


def _rejected(run: Run, lost: Sequence[tuple[TransformRow, str]]) -> str:
    rows = [(row, row.reason, row.message) for row in run.rejected]
    rows += [(row, "unreadable", message) for row, message in lost]
    if not rows:
        return section("rejected", "Rejected", '<p class="empty">No construction was rejected.</p>')
    cells = (
        [
            f"{escape(row.name_p)} ⇄ {escape(row.name_q)}",
            escape(reason),
            f'<div class="long">{escape(message)}</div>',
            number(row.qcrs),
            number(row.crs),
        ]
        for row, reason, message in rows
    )
    head = ("pair", "reason", "in words", "QCRS", "CRS")
    body = table(head, cells, (False, False, False, True, True), "Rejected constructions")
    note = "Pairs that were selected and did not become an exact transform."
    return section("rejected", "Rejected", f'<div class="sheet">{body}</div>', note)


def _errors(run: Run) -> str:
    if not run.errors:
        return section("errors", "Errors", '<p class="empty">There were none.</p>')
    cells = (
        [
            f'<div class="long">{escape(str(row["item"]))}</div>',
            escape(str(row["stage"])),
            escape(str(row.get("reason") or row["type"])),
            f'<div class="long">{escape(str(row["message"]))}</div>',
            count(row["attempts"]),
        ]
        for row in run.errors[:SHOWN_ERRORS]
    )
    head = ("item", "stage", "reason", "in words", "attempts")
    body = table(head, cells, (False, False, False, False, True), "Errors")
    more = len(run.errors) - SHOWN_ERRORS
    note = f"The first {SHOWN_ERRORS}; {count(more)} more are in errors.parquet." if more > 0 else ""
    return section("errors", "Errors", f'<div class="sheet">{body}</div>', note)


def _settings(run: Run) -> str:
    """What `run.json` says, folded: one group for each of its mappings, one for its plain values; lists are tables'."""
    plain = {name: value for name, value in run.facts.items() if not isinstance(value, Mapping | list)}
    groups = ({"run": plain} if plain else {}) | {
        name: value for name, value in run.facts.items() if isinstance(value, Mapping)
    }
    body = "".join(
        f"<details><summary>{escape(_words(name))}</summary>{_tree(name, values)}</details>"
        for name, values in groups.items()
    )
    return section(
        "settings", "Settings", f'<div class="sheet">{body}</div>', "What the run was told, and what it ran on."
    )


def _tree(name: str, values: Mapping[str, Any]) -> str:
    rows = ([escape(path), escape(value)] for path, value in _leaves(values))
    return f'<div class="tree">{table(("name", "value"), rows, (False, False), _words(name))}</div>'


def _leaves(values: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, str]]:
    for name, value in values.items():
        path = f"{before}{name}"
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{path}.")
        elif isinstance(value, list | tuple):
            yield path, ", ".join(str(one) for one in value) or NOTHING
        else:
            yield path, NOTHING if value is None else str(value)


def _words(name: str) -> str:
    return str(name).replace("_", " ")
