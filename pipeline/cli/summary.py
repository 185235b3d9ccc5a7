"""The summary on the terminal: counts, the best pairs, times, and the path of the report."""

from __future__ import annotations

from collections import Counter

import pyarrow.parquet as pq
from rich.console import Console
from rich.table import Table

from pipeline.flow import RunOutcome
from pipeline.report.comparison import read_comparison
from pipeline.tables.messages import sentences, several
from pipeline.tables.record import counts
from pipeline.tables.results import Row

BEST = 10
"""Transforms in the summary; the report has the others (ours)."""

REASONS = 3
"""Kinds of errors in the summary; errors.parquet has the others (ours)."""


def show_outcome(outcome: RunOutcome, console: Console, *, verbose: bool = False) -> None:
    """Print the summary of a finished run; ``verbose`` lists all transforms and kinds of errors."""
    console.print(_counts(outcome), markup=False)
    if outcome.results.pairs:
        console.print(_best(outcome, None if verbose else BEST), markup=False)
    console.print(_times(outcome))
    for sentence in sentences(counts(outcome.results), outcome.results.config.select.policy):
        console.print(sentence, highlight=False, markup=False, soft_wrap=True)
    compared = read_comparison(_rows(outcome, "transforms"), _rows(outcome, "timings"))
    if compared is not None:
        console.print(compared.sentence, highlight=False, markup=False, soft_wrap=True)
    if outcome.results.search is not None:
        sentence = outcome.results.search.sentence(_kept(outcome))
        console.print(sentence, highlight=False, markup=False, soft_wrap=True)
    _errors(outcome, console, None if verbose else REASONS)
    if all(stage.computed + stage.failed == 0 for stage in outcome.results.stages):
        kept = "" if outcome.written else " and the tables are up to date"
        console.print(f"Everything cached: nothing was computed{kept} ({outcome.seconds:.1f} s).", highlight=False)
    console.print(f"Tables: {outcome.folder}", highlight=False, soft_wrap=True, markup=False)
    if outcome.report is not None:
        console.print(f"Report: {outcome.report}", highlight=False, soft_wrap=True, markup=False)


def _kept(outcome: RunOutcome) -> int:
    return sum(pq.read_metadata(file).num_rows for file in (outcome.folder / "qcrs").rglob("*.parquet"))


def _rows(outcome: RunOutcome, name: str) -> list[Row]:
    # Not pyarrow.parquet.read_table, nor pyarrow.dataset: both load pandas, which takes half a second.
    with pq.ParquetFile(outcome.folder / f"{name}.parquet") as file:
        rows: list[Row] = file.read().to_pylist()
    return rows


def _counts(outcome: RunOutcome) -> Table:
    run_counts = counts(outcome.results)
    table = Table(title=f"Run of {outcome.results.collection.name}", title_justify="left")
    names = ["shapes", "rejected_items", "pairs", "selected", "certified", "rejected", "errors"]
    if run_counts["approximate"]:
        names.insert(names.index("rejected"), "approximate")
    for name in names:
        table.add_column("no shape" if name == "rejected_items" else name, justify="right")
    table.add_row(*(f"{run_counts[name]:,}" for name in names))
    return table


def _best(outcome: RunOutcome, most: int | None) -> Table:
    table = Table(title="Best transforms, least deformed first", title_justify="left")
    for title, justify in (("", "right"), ("P", "left"), ("Q", "left"), ("n", "right")):
        table.add_column(title, justify=justify, max_width=30)  # type: ignore[arg-type]
    for title in ("QCRS", "CRS", "IoU P ≤ bound", "IoU Q ≤ bound", "Hausdorff/L_c", "residual"):
        table.add_column(title, justify="right")
    rows = _rows(outcome, "transforms")
    for row in [row for row in rows if row["status"] != "rejected"][:most]:
        residual = max(abs(row[name]) for name in ("overlap_p", "overlap_q", "gap_p", "gap_q"))
        table.add_row(
            str(row["rank"]),
            row["name_i"],
            row["name_j"],
            str(row["n"]),
            f"{row['qcrs']:.3f}",
            f"{row['crs']:.3f}",
            f"{row['iou_p']:.3f} ≤ {row['bound_p']:.3f}",
            f"{row['iou_q']:.3f} ≤ {row['bound_q']:.3f}",
            f"{max(row['hausdorff_p'], row['hausdorff_q']):.4f}",
            f"{residual:.0e}",
        )
    rejected = Counter(row["reason"] for row in rows if row["status"] == "rejected")
    if rejected:
        reasons = ", ".join(f"{count} × {reason}" for reason, count in rejected.most_common())
        table.caption = f"rejected: {reasons}"
    return table


def _times(outcome: RunOutcome) -> Table:
    table = Table(title="Time per stage", title_justify="left")
    table.add_column("stage")
    for title in ("items", "cached", "computed", "failed", "wall s", "cpu s", "stored s", "peak MiB"):
        table.add_column(title, justify="right")
    for stage in outcome.results.stages:
        table.add_row(
            stage.stage,
            f"{stage.total:,}",
            f"{stage.cached:,}",
            f"{stage.computed:,}",
            f"{stage.failed + stage.blocked:,}",
            f"{stage.seconds:.1f}",
            f"{stage.cpu_seconds:.1f}",
            f"{stage.stored_seconds:.1f}",
            f"{stage.peak_mb:.0f}" if stage.computed else "",
        )
    table.add_section()
    table.add_row("whole run", "", "", "", "", f"{outcome.seconds:.1f}", "", "", "")
    return table


def _errors(outcome: RunOutcome, console: Console, most: int | None) -> None:
    errors = outcome.results.errors
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
