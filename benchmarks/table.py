"""One row for each step, as a table and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from floors import Floor, distance_of
from rich import box
from rich.console import Console
from rich.table import Table

WIDTH = 210


@dataclass(frozen=True)
class Row:
    """The cost of one step in CPU milliseconds an item; ``ratio`` = the reference's mean over this step's.

    ``met``: the mean is within ``target_ms`` and the ratio is no less than ``target_ratio``; None without a target.
    ``agree``: the step and its reference give the same; None where there is nothing to compare.
    """

    step: str
    per: str
    items: int
    failed: int
    median_ms: float
    mean_ms: float
    p90_ms: float
    paper_ms: float | None = None
    target_ms: float | None = None
    target_ratio: float | None = None
    reference: str = ""
    reference_ms: float | None = None
    ratio: float | None = None
    met: bool | None = None
    floor: Floor | None = None
    times_floor: float | None = None
    bounded_by: str = ""
    agree: bool | None = None
    note: str = ""


def row(
    step: str,
    per: str,
    ms: Sequence[float],
    *,
    mean: float | None = None,
    items: int | None = None,
    failed: int = 0,
    paper_ms: float | None = None,
    target_ms: float | None = None,
    target_ratio: float | None = None,
    reference: str = "",
    reference_ms: float | None = None,
    ratio: float | None = None,
    floor: Floor | None = None,
    bounded_by: str = "",
    agree: bool | None = None,
    note: str = "",
) -> Row:
    """A row of the times of items; ``mean`` and ``items`` where a time is that of a whole block's share."""
    mean = float(np.mean(ms)) if mean is None else mean
    if ratio is None and reference_ms is not None:
        ratio = reference_ms / mean
    met = None
    if target_ms is not None:
        met = mean <= target_ms and (target_ratio is None or (ratio is not None and ratio >= target_ratio))
    median, p90 = (float(np.quantile(ms, share)) for share in (0.5, 0.9))
    number = len(ms) if items is None else items
    times = distance_of(mean, floor)
    return Row(
        *(step, per, number, failed, median, mean, p90, paper_ms, target_ms, target_ratio),
        *(reference, reference_ms, ratio, met, floor, times, bounded_by, agree, note),
    )


def to_json(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Rows as plain values."""
    return [asdict(row) for row in rows]


def show(rows: Sequence[Row], console: Console | None = None) -> None:
    """Print the table."""
    console = console or Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=WIDTH, file=console.file)
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_lines=False)
    table.add_column("step", no_wrap=True)
    for name in ("paper", "target", "median", "mean", "p90"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("reference, its time", ratio=2)
    table.add_column("ratio", justify="right", no_wrap=True)
    table.add_column("met", no_wrap=True)
    table.add_column("floor", justify="right", no_wrap=True)
    table.add_column("× floor", justify="right", no_wrap=True)
    table.add_column("what bounds it; what the floor counts", ratio=4)
    for row in rows:
        table.add_row(*_cells(row))
    console.print(table)
    console.print(
        "CPU milliseconds an item on one core, the least of the rounds of each item. ratio: the reference's mean over "
        "the step's.\nmet: mean within the target. × floor: mean over the floor.",
        soft_wrap=True,
    )


def _cells(row: Row) -> list[str]:
    target = _number(row.target_ms)
    if row.target_ratio is not None:
        target += f", {row.target_ratio:g}×"
    reference = f"{row.reference}, {_number(row.reference_ms)}" if row.reference_ms is not None else row.reference
    if row.agree is not None:
        reference += ", equal" if row.agree else ", NOT EQUAL"
    met = "" if row.met is None else "yes" if row.met else "NO"
    about = "; ".join(remark for remark in (row.bounded_by, row.note, row.floor.says if row.floor else "") if remark)
    return [
        f"{row.step}, {row.items} {row.per}{'s' if row.items != 1 else ''}"
        + (f", {row.failed} refused" if row.failed else ""),
        *(_number(value) for value in (row.paper_ms,)),
        target,
        *(_number(value) for value in (row.median_ms, row.mean_ms, row.p90_ms)),
        reference,
        "" if row.ratio is None else f"{row.ratio:.3g}×",
        met,
        _number(row.floor.ms) if row.floor else "",
        "" if row.times_floor is None else f"{row.times_floor:.3g}",
        about,
    ]


def _number(value: float | None) -> str:
    if value is None:
        return ""
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"
