"""What the report shows, from the tables of a run: transforms, then numbers in the order of the method. Ours."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pipeline.report.classes import CLASSES, LEAST
from pipeline.report.environment import render
from pipeline.report.first import first_transforms
from pipeline.report.formats import MISSING
from pipeline.report.gallery import INDEX
from pipeline.report.histogram import Histogram, histogram
from pipeline.report.pictures import HEIGHT, WIDTH
from pipeline.report.rows import TransformRow
from pipeline.report.run import ReportedRun
from pipeline.tables.messages import sentences
from pipeline.tables.record import CHECK, GALLERY, STUDY
from riot.errors import needs_extra

with needs_extra("mine"):
    from markupsafe import Markup

SHOWN_PAIRS = 20
"""Rows of the best pairs, and of those compared that are in sight; the others of these can be unfolded."""

SHOWN_ROWS = 200
"""The page shows no more rows of errors, or of rejections; the tables have them all."""

SHOWN_TRANSFORMS = 100
"""The page shows no more transforms; the gallery has them all."""


Silhouettes = Mapping[int, tuple[Markup, Markup]]
"""SVG elements of the inputs of transforms, by rank."""


@dataclass(frozen=True)
class Rejection:
    """A transform that is not shown, and why."""

    row: TransformRow
    reason: str
    message: str


@dataclass(frozen=True)
class ReportPage:
    """The report: the transforms that a run found, and its numbers.

    ``transforms`` are those that have a page in the gallery, best first, and ``silhouettes`` SVG elements of their
    inputs, by rank. ``settings`` are groups of names and values.
    """

    run: ReportedRun
    transforms: Sequence[TransformRow]
    silhouettes: Silhouettes
    rejections: Sequence[Rejection]

    @property
    def first(self) -> list[TransformRow]:
        """Those that swing on the first screen."""
        return first_transforms(self.transforms)

    @property
    def wall(self) -> Sequence[TransformRow]:
        """Those that the page shows."""
        return self.transforms[:SHOWN_TRANSFORMS]

    @property
    def links(self) -> Mapping[int, str]:
        """From the rank of each transform to its page in the gallery."""
        return {row.rank: f"{GALLERY}/{row.page}" for row in self.transforms}

    @property
    def shown_classes(self) -> int:
        """Number of classes that have a transform."""
        return len({kind for row in self.transforms for kind in row.classes})

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
        """What `run.json` says: a group for each of its mappings, one for its plain values.

        Lists are those of tables, and the digests of the run's files, as many as there are pictures, stay there.
        """
        facts = {name: value for name, value in self.run.facts.items() if name != "files"}
        plain = {name: value for name, value in facts.items() if not isinstance(value, Mapping | list)}
        groups = {name: value for name, value in facts.items() if isinstance(value, Mapping)}
        return {name: list(_leaves(values)) for name, values in (({"run": plain} if plain else {}) | groups).items()}


def page(
    run: ReportedRun, transforms: Sequence[TransformRow], silhouettes: Silhouettes, lost: Sequence[Rejection]
) -> str:
    """The text of the report.

    ``transforms`` are those that have a page in the gallery, ``lost`` those whose file cannot be read.
    """
    refused = [Rejection(row, row.reason, row.message) for row in run.rejected]
    return render(
        "report.html",
        report=ReportPage(run, transforms, silhouettes, [*refused, *lost]),
        run=run,
        shown_pairs=SHOWN_PAIRS,
        shown_rows=SHOWN_ROWS,
        base=f"{GALLERY}/",
        size=(WIDTH, HEIGHT),
        gallery=f"{GALLERY}/{INDEX}",
        check=CHECK if (run.folder / CHECK).exists() else "",
        classes=f"{GALLERY}/{CLASSES}" if len(run.classes) >= LEAST else "",
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
