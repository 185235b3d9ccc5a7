"""How reversibility and QCRS are spread over a collection, and what shapes along the scale look like (Figs. 17, 18)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pipeline.study import plots
from pipeline.study.findings import Findings, Sheet, of_columns
from pipeline.study.finished import StudiedRun
from pipeline.study.statistics import quantiles
from pipeline.tables.schemas import column
from riot.errors import needs_extra
from riot.parameters.field import ParameterGroup, parameter
from riot.types import FloatArray, IntArray

with needs_extra("mine"):
    import pyarrow as pa

SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Quantiles in the tables."""

BANDS = (0.1, 0.5, 0.8, 0.9)
"""Scores between which the lead counts shapes and pairs (ours)."""

WORDS = ("least", "25 %", "median", "75 %", "greatest")


@dataclass(frozen=True)
class Parameters(ParameterGroup):
    """What is shown."""

    samples: int = parameter(10, at_least=2, meaning="Shapes that are shown along the scale of reversibility.")


@dataclass(frozen=True, eq=False)
class Group:
    """Scores of one kind of one class, or of all."""

    score: str
    cls: str
    values: FloatArray

    @property
    def things(self) -> str:
        """What has such a score."""
        return "shapes" if self.score == "S_r" else "pairs"


def study(finished: StudiedRun, parameters: Parameters, say: Callable[[str], None]) -> Findings:
    """Distributions of S_r and QCRS, over everything and by class, and shapes at equal steps of rank by S_r."""
    reversible = finished.values("reversibility", "score")
    groups = list(_groups(finished, reversible))
    group_quantiles = [quantiles(group.values, SHARES) for group in groups]
    table = of_columns(
        "Distribution of each score over everything and by class; a pair counts for both its classes.",
        [
            (column("score", pa.string(), "which score"), [group.score for group in groups]),
            (column("class", pa.string(), "class of the shape, or of one of the two; empty = all"),
             [group.cls for group in groups]),
            (column("values", pa.int64(), "how many", "count"), [int(np.isfinite(g.values).sum()) for g in groups]),
            *((column(f"q{share:.2f}", pa.float64(), f"quantile {share:.2f}", "score in [0, 1]"),
               [row[k] for row in group_quantiles]) for k, share in enumerate(SHARES)),
        ],
    )  # fmt: skip
    everything = {group.score: group.values for group in groups if not group.cls}
    kinds = {name: {g.cls: g.values for g in groups if g.cls and g.score == name} for name in everything}
    order = np.argsort(reversible, kind="stable")[: int(np.isfinite(reversible).sum())]
    chosen = order[np.linspace(0, len(order) - 1, min(parameters.samples, len(order))).astype(np.int64)]
    shown = [finished.shapes[number] for number in chosen]
    captions = [f"{finished.mined.names[number]}\n{reversible[number]:.3f}" for number in chosen]
    figures = {
        "scale": (plots.along(shown, captions), "Shapes along the scale of reversibility, at equal steps of rank"),
        "reversibility": (
            plots.histograms({"S_r": everything["S_r"]}, "reversibility score", "shapes"), "All shapes",
        ),
        "qcrs": (plots.histograms({"QCRS": everything["QCRS"]}, "QCRS", "pairs", logarithmic=True), "All pairs"),
    }  # fmt: skip
    for name, of_kind in kinds.items():
        if of_kind:
            ordered = sorted(of_kind, key=lambda cls, scores=of_kind: -float(np.nanmedian(scores[cls])))  # type: ignore[misc]
            figures[f"{name.lower()}-classes"] = (
                plots.boxes({cls: of_kind[cls] for cls in ordered}, name),
                f"{name} by class, the highest median first",
            )
    cells = [
        (group.score, f"{np.isfinite(group.values).sum():,}", *(f"{value:.3f}" for value in row))
        for group, row in zip(groups, group_quantiles, strict=True)
        if not group.cls
    ]
    return Findings(
        f"Scores of {finished.mined.dataset}",
        " ".join(_told(group) for group in groups if not group.cls),
        table,
        [Sheet("All shapes and pairs", ("score", "values", *WORDS), cells)],
        figures,
    )


def _told(group: Group) -> str:
    """How the values lie on the scale, in a sentence."""
    known = group.values[np.isfinite(group.values)]
    bounds = (-np.inf, *BANDS, np.inf)
    shares = np.histogram(known, bounds)[0] / max(len(known), 1)
    words = (f"below {BANDS[0]}", *(f"from {a} to {b}" for a, b in pairwise(BANDS)), f"{BANDS[-1]} or more")
    phrases = (f"{share:.0%} {word}" for share, word in zip(shares, words, strict=True))
    return f"{group.score} of {len(known):,} {group.things}: {', '.join(phrases)}."


def _groups(finished: StudiedRun, reversible: FloatArray) -> Iterator[Group]:
    i, j, score = (finished.quick.column(name).to_numpy() for name in ("i", "j", "score"))
    yield Group("S_r", "", reversible)
    score = score.astype(np.float64)
    yield Group("QCRS", "", score)
    names = sorted(set(finished.classes) - {""})
    number: IntArray = np.array([names.index(cls) if cls else -1 for cls in finished.classes], dtype=np.int64)
    a, b = number[i], number[j]
    for k, cls in enumerate(names):
        yield Group("S_r", cls, reversible[number == k])
        ours = score[(a == k) | (b == k)]
        if len(ours):
            yield Group("QCRS", cls, ours)
