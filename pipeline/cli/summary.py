"""The summary on the terminal: counts, the best pairs, times, and the path of the report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import pyarrow.parquet as pq
from rich.console import Console

from pipeline.cli.progress import duration
from pipeline.datasets.collection import DUPLICATE
from pipeline.flow import RunOutcome
from pipeline.report.comparison import read_comparison
from pipeline.tables.messages import sentences, several
from pipeline.tables.record import counts
from pipeline.tables.results import Row
from riot.cli.table import Table

BEST = 10
"""Transforms in the summary; the report has the others (ours)."""

LONGEST_NAME = 22
"""Characters of a name in the summary, so that a row fits a terminal of 80 columns (ours)."""

REASONS = 3
"""Kinds of errors in the summary; errors.parquet has the others (ours)."""


def show_outcome(outcome: RunOutcome, console: Console, *, verbose: bool = False) -> None:
    """Print the summary of a finished run; ``verbose`` adds times, and all transforms and kinds of errors."""

    def show(text: str) -> None:
        console.print(text, highlight=False, markup=False, soft_wrap=True)

    show(_counts(outcome))
    if outcome.results.pairs:
        for line in _best(outcome, None if verbose else BEST):
            show(line)
    if verbose:
        for line in _times(outcome).lines():
            show(line)
    for sentence in sentences(counts(outcome.results), outcome.results.config.select.policy):
        show(sentence)
    compared = read_comparison(_rows(outcome, "transforms"), _rows(outcome, "timings"))
    if compared is not None:
        show(compared.sentence)
    if outcome.results.search is not None:
        show(outcome.results.search.sentence(_kept(outcome)))
    _errors(outcome, console, None if verbose else REASONS)
    if all(stage.computed + stage.failed == 0 for stage in outcome.results.stages):
        kept = "" if outcome.written else " and the tables are up to date"
        show(f"Everything cached: nothing was computed{kept} ({outcome.seconds:.1f} s).")
    show(f"Tables: {outcome.folder}")
    if outcome.report is not None:
        show(f"Report: {outcome.report}")


def _kept(outcome: RunOutcome) -> int:
    return sum(pq.read_metadata(file).num_rows for file in (outcome.folder / "qcrs").rglob("*.parquet"))


def _rows(outcome: RunOutcome, name: str) -> list[Row]:
    # Not pyarrow.parquet.read_table, nor pyarrow.dataset: both load pandas, which takes half a second.
    with pq.ParquetFile(outcome.folder / f"{name}.parquet") as file:
        rows: list[Row] = file.read().to_pylist()
    return rows


def _counts(outcome: RunOutcome) -> str:
    run_counts = counts(outcome.results)
    constructed = f"{run_counts['constructed']:,} constructed"
    parts = [
        several(run_counts["shapes"], "shape"),
        several(run_counts["pairs"], "pair") + " scored",
        f"{run_counts['selected']:,} selected",
        *([constructed] if outcome.results.config.select.policy == "varied" else []),
        several(run_counts["certified"], "transform") + " certified",
    ]
    if run_counts["approximate"]:
        parts.append(f"{run_counts['approximate']:,} approximate")
    if run_counts["rejected"]:
        parts.append(f"{run_counts['rejected']:,} rejected")
    return f"{outcome.results.collection.name}: {', '.join(parts)}, in {duration(outcome.seconds)}."


def _best(outcome: RunOutcome, most: int | None) -> Iterator[str]:
    rows = _rows(outcome, "transforms")
    shown = [
        (
            str(row["rank"]),
            _short(row["name_i"]),
            _short(row["name_j"]),
            str(row["n"]),
            "–" if row["margin"] is None else f"{row['margin']:.2f}",
            f"{row['iou']:.3f}",
            f"{min(row['bound_p'], row['bound_q']):.3f}",
            f"{row['crs']:.3f}",
            f"{row['qcrs']:.3f}",
        )
        for row in [row for row in rows if row["chosen"] and row["status"] != "rejected"][:most]
    ]
    if shown:
        columns = ("", "P", "Q", "pieces", "margin", "IoU", "bound", "CRS", "QCRS")
        varied = outcome.results.config.select.policy == "varied"
        title = "Best transforms, what shows something new first" if varied else "Best transforms, least deformed first"
        yield from Table(columns, shown, title, left=("P", "Q")).lines()
    rejected = Counter(row["reason"] for row in rows if row["status"] == "rejected")
    if rejected:
        yield f"Rejected: {', '.join(f'{count} × {reason}' for reason, count in rejected.most_common())}."


def _short(name: str) -> str:
    return name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - 1]}…"


def _times(outcome: RunOutcome) -> Table:
    columns = ("stage", "items", "in store", "computed", "failed", "wall s", "CPU s", "peak MiB")
    rows = [
        (
            stage.stage,
            f"{stage.total:,}",
            f"{stage.cached:,}",
            f"{stage.computed:,}",
            f"{stage.failed + stage.blocked:,}",
            f"{stage.seconds:.1f}",
            f"{stage.cpu_seconds:.1f}",
            f"{stage.peak_mb:.0f}" if stage.computed else "",
        )
        for stage in outcome.results.stages
    ]
    whole = ("whole run", "", "", "", "", f"{outcome.seconds:.1f}", "", "")
    return Table(columns, [*rows, whole], "Time by stage", left=("stage",), totals=1)


def _errors(outcome: RunOutcome, console: Console, most: int | None) -> None:
    errors = [row for row in outcome.results.errors if row["reason"] != DUPLICATE]
    copies = len(outcome.results.errors) - len(errors)
    if copies:
        text = f"{several(copies, 'file is', 'files are')} left out: the same bytes as another (errors.parquet)."
        console.print(text, highlight=False, markup=False, soft_wrap=True)
    if not errors:
        return
    kinds = Counter((row["stage"], row["reason"] or row["type"]) for row in errors)
    console.print(f"Finished with {several(len(errors), 'error')} (errors.parquet has them all):", highlight=False)
    for (stage, reason), count in kinds.most_common(most):
        first = next(row for row in errors if (row["stage"], row["reason"] or row["type"]) == (stage, reason))
        text = f"  {count} × {stage}/{reason}, such as {first['item']}: {first['message']}"
        console.print(text, highlight=False, markup=False, soft_wrap=True)
    if most is not None and len(kinds) > most:
        console.print(f"  and {several(len(kinds) - most, 'more kind')}", highlight=False)
