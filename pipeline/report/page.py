"""What the report shows, from the tables of a run: sections in the order of the method, after the gallery. Ours."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pipeline.report.card import Card
from pipeline.report.environment import render
from pipeline.report.formats import MISSING
from pipeline.report.histogram import Histogram, histogram
from pipeline.report.rows import TransformRow
from pipeline.report.run import ReportedRun
from pipeline.tables.messages import sentences
from pipeline.tables.record import GALLERY, STUDY

SHOWN_PAIRS = 20
"""Rows of pairs in sight; the others can be unfolded."""

SHOWN_ERRORS = 200
"""The page shows no more rows of errors; the table has them all."""

SHOWN_CARDS = 100
"""The page shows no more transforms; the gallery has them all."""


@dataclass(frozen=True)
class Rejection:
    """A transform that is not shown, and why."""

    row: TransformRow
    reason: str
    message: str


@dataclass(frozen=True)
class ReportPage:
    """The report: a run's numbers, the cards of its best transforms, and where its transforms have a page.

    ``links`` lead from the rank of each transform to its card or to its page in the gallery, which has ``listed`` of
    them. ``settings`` are groups of names and values.
    """

    run: ReportedRun
    cards: Sequence[Card]
    links: Mapping[int, str]
    listed: int
    rejections: Sequence[Rejection]

    @property
    def sentences(self) -> list[str]:
        """Sentences on what a reader could wonder about."""
        search = self.run.search
        return sentences(self.run.counts, self.run.policy) + (
            [] if search is None else [search.sentence(self.run.pairs)]
        )

    @property
    def plots(self) -> tuple[Histogram, ...]:
        """The distributions of all scores."""
        run = self.run
        pairs = "QCRS, all pairs" if run.search is None else "QCRS, pairs kept"
        return (
            histogram(run.s_r, "Reversibility score", "shapes"),
            histogram(run.qcrs, pairs, "pairs", logarithmic=True),
            histogram(run.crs, "CRS, selected pairs", "pairs"),
            histogram(run.iou, "IoU of the worse shape", "transforms"),
        )

    @property
    def settings(self) -> dict[str, list[tuple[str, str]]]:
        """What `run.json` says: a group for each of its mappings, one for its plain values; lists are tables'."""
        facts = self.run.facts
        plain = {name: value for name, value in facts.items() if not isinstance(value, Mapping | list)}
        groups = {name: value for name, value in facts.items() if isinstance(value, Mapping)}
        return {name: list(_leaves(values)) for name, values in (({"run": plain} if plain else {}) | groups).items()}


def page(run: ReportedRun, cards: Sequence[Card], lost: Sequence[Rejection], gallery: Mapping[int, str]) -> str:
    """The text of the report; ``lost`` are transforms whose file cannot be read.

    ``cards`` are the best `SHOWN_CARDS`; ``gallery`` leads from the ranks of all that can be read to their pages.
    """
    links = {**gallery, **{card.row.rank: f"#t{card.row.rank}" for card in cards}}
    refused = [Rejection(row, row.reason, row.message) for row in run.rejected]
    report = ReportPage(run, cards, links, len(gallery), [*refused, *lost])
    return render(
        "report.html",
        report=report,
        run=run,
        shown_pairs=SHOWN_PAIRS,
        shown_errors=SHOWN_ERRORS,
        gallery=f"{GALLERY}/index.html",
        studies=f"{STUDY}/index.html",
    )


def _leaves(values: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, str]]:
    for name, value in values.items():
        path = f"{before}{name}"
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{path}.")
        elif isinstance(value, list | tuple):
            yield path, ", ".join(map(str, value)) or MISSING
        else:
            yield path, MISSING if value is None else str(value)
