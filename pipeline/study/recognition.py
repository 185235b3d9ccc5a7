"""Whether results are recognised: the nearest shape of each is of its input's class as often as the input's own is."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.study import plots
from pipeline.study.findings import Findings, Sheet, of_columns
from pipeline.study.finished import StudiedRun
from pipeline.study.results import OTHERS, Likenesses, beside, chosen_rows, described_outline
from pipeline.tables.schemas import column
from riot.errors import needs_extra
from riot.parameters.field import ParameterGroup, parameter

with needs_extra("mine"):
    import pyarrow as pa


@dataclass(frozen=True)
class Parameters(ParameterGroup):
    """How many results are looked at, and of which runs."""

    top: int = parameter(100, at_least=1, meaning="Transforms of each run, the first by rank.")
    others: tuple[str, ...] = parameter((), meaning=OTHERS)


@dataclass(frozen=True)
class RecognisedResult:
    """One result: its run, input and margin, and the shapes, by number, nearest to it and to its input."""

    run: str
    rank: int
    shape: int
    iou: float
    margin: float | None
    nearest: int
    nearest_of_input: int
    recognised: bool
    input_recognised: bool


def study(finished: StudiedRun, parameters: Parameters, say: Callable[[str], None]) -> Findings:
    """The nearest shape of each result and each input, leave one out: shares by run and class, what is mistaken."""
    say("descriptors of the collection …")
    shapes = Likenesses.of(finished)
    results: list[RecognisedResult] = []
    for name, run in beside(finished, parameters.others).items():
        say(f"nearest shapes of the results, {name} …")
        results += _results(name, run, shapes, parameters.top)
    runs = list(dict.fromkeys(result.run for result in results))
    kinds = [finished.classes[result.shape] for result in results]
    names = finished.mined.names
    shares = [(run, *_cells([result for result in results if result.run == run])) for run in runs]
    mistaken = Counter(
        (result.run, kind or names[result.shape], finished.classes[result.nearest] or names[result.nearest])
        for result, kind in zip(results, kinds, strict=True)
        if not result.recognised
    )
    first = [result for result in results if result.run == runs[0]]
    lead = (
        f"Of the {len(first)} results of {runs[0]}, {_share(first):.1%} are recognised: the nearest shape, its input "
        f"left out, is of its input's class. Of their inputs it is {_ceiling(first):.1%}, so that "
        f"{_share(first) / max(_ceiling(first), 1e-9):.1%} of what can be recognised is."
    )
    margins = {run: np.array([r.margin for r in results if r.run == run and r.margin is not None]) for run in runs}
    return Findings(
        f"Recognition of {finished.mined.dataset}",
        lead,
        _table(results, kinds, finished),
        [
            Sheet(
                "Recognised, by run",
                (
                    "run",
                    "results",
                    "recognised",
                    "inputs recognised",
                    "of these",
                    "median margin of the worse",
                    "median IoU",
                ),
                shares,
            ),
            Sheet("By class", ("class", *(f"{run}" for run in runs)), _by_class(results, kinds, runs)),
            Sheet(
                "Mistaken",
                ("run", "input", "taken for", "results"),
                [
                    (*key, str(count))
                    for key, count in sorted(mistaken.items(), key=lambda entry: (-entry[1], entry[0]))
                ],
                numeric=3,
            ),
        ],
        {
            "margins": (
                plots.histograms(margins, "margin", "results"),
                "Margins of the results; those below 0 are not shown",
            )
        },
    )


def _results(name: str, run: StudiedRun, shapes: Likenesses, top: int) -> list[RecognisedResult]:
    results = []
    for row in chosen_rows(run)[:top]:
        for side, number in (("p", int(row["i"])), ("q", int(row["j"]))):
            nearest = shapes.nearest(described_outline(row, side), number)
            of_input = shapes.nearest(shapes.index.descriptor(number), number)
            same = [bool(shapes.thing[other] == shapes.thing[number]) for other in (nearest, of_input)]
            results.append(
                RecognisedResult(
                    name, int(row["rank"]), number, float(row["iou"]), row[f"margin_{side}"], nearest, of_input, *same
                )
            )
    return results


def _share(results: Sequence[RecognisedResult]) -> float:
    return float(np.mean([result.recognised for result in results]))


def _ceiling(results: Sequence[RecognisedResult]) -> float:
    return float(np.mean([result.input_recognised for result in results]))


def _cells(results: Sequence[RecognisedResult]) -> tuple[str, ...]:
    by_rank: dict[int, list[float]] = {}
    for result in results:
        if result.margin is not None:
            by_rank.setdefault(result.rank, []).append(result.margin)
    worse = [min(margins) for margins in by_rank.values() if len(margins) == 2]
    share, ceiling = _share(results), _ceiling(results)
    of_these = f"{share / ceiling:.1%}" if ceiling else "–"
    margin = f"{np.median(worse):.3f}" if worse else "–"
    iou = float(np.median([result.iou for result in results]))
    return str(len(results)), f"{share:.1%}", f"{ceiling:.1%}", of_these, margin, f"{iou:.3f}"


def _by_class(results: Sequence[RecognisedResult], kinds: Sequence[str], runs: Sequence[str]) -> list[tuple[str, ...]]:
    """Recognised of all results of each class, by run."""
    rows = []
    for kind in sorted(set(kinds)):
        cells = []
        for run in runs:
            of_class = [r.recognised for r, own in zip(results, kinds, strict=True) if own == kind and r.run == run]
            cells.append(f"{sum(of_class)} of {len(of_class)}" if of_class else "")
        rows.append((kind or "(none)", *cells))
    return rows


def _table(results: Sequence[RecognisedResult], kinds: Sequence[str], finished: StudiedRun) -> pa.Table:
    names, classes = finished.mined.names, finished.classes
    return of_columns(
        "Results of the runs, two of each transform, and the shapes nearest to them.",
        [
            (column("run", pa.string(), "policy of the run"), [result.run for result in results]),
            (column("rank", pa.int32(), "rank in its `transforms`", "rank"), [result.rank for result in results]),
            (column("name", pa.string(), "input of the result"), [names[result.shape] for result in results]),
            (column("class", pa.string(), "class of the input, empty = none"), list(kinds)),
            (column("margin", pa.float64(), "margin of the result, null = no other thing", "1"),
             [result.margin for result in results]),
            (column("nearest", pa.string(), "nearest shape, the input left out"), [names[r.nearest] for r in results]),
            (column("nearest_class", pa.string(), "class of the nearest shape"), [classes[r.nearest] for r in results]),
            (column("recognised", pa.bool_(), "whether this is the same thing"), [r.recognised for r in results]),
            (column("input_recognised", pa.bool_(), "whether that of the input itself is"),
             [result.input_recognised for result in results]),
        ],
    )  # fmt: skip
