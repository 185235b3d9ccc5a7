"""Table and plot of how the bookkeeping grows with a collection."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.figure import Figure

Row = Mapping[str, Any]
"""What a step of `bookkeeping` took, by name."""

FIGURES: Mapping[str, tuple[str, str, Callable[[Row], float]]] = {
    "plan, s of CPU": ("plan", "seconds of CPU", lambda row: row["cpu_s"]),
    "selection, s of CPU": ("preselect", "seconds of CPU", lambda row: row["cpu_s"]),
    "run again, s of CPU": ("again", "seconds of CPU", lambda row: row["cpu_s"]),
    "table, s of CPU": ("tables", "seconds of CPU", lambda row: row["cpu_s"]),
    "files": ("select", "files", lambda row: row["count"]),
    "plan, MB": ("plan", "MB", lambda row: row["peak_mb"]),
    "worker, MB": ("preselect", "MB", lambda row: row["peak_mb"]),
    "driver, MB": ("select", "MB", lambda row: row["peak_mb"]),
    "table, MB": ("tables", "MB", lambda row: row["peak_mb"]),
}
"""What is shown: of which step, in which panel, and which of its numbers."""


def figures(rows: Sequence[Row]) -> dict[str, dict[int, float]]:
    """Each figure by the number of shapes."""
    return {
        name: dict(sorted((row["shapes"], value(row)) for row in rows if row["step"] == step))
        for name, (step, _, value) in FIGURES.items()
    }


def table(rows: Sequence[Row]) -> str:
    """The figures as a table of Markdown, a row for each size."""
    columns = {name: values for name, values in figures(rows).items() if values}
    sizes = sorted({row["shapes"] for row in rows})
    head = ["| shapes | pairs |", *(f" {name} |" for name in columns), "\n|---:|---:|", *("---:|" for _ in columns)]
    lines = [
        f"\n| {size:,} | {size * (size - 1) // 2:,} |"
        + "".join(f" {_number(values[size])} |" if size in values else " |" for values in columns.values())
        for size in sizes
    ]
    return "".join([*head, *lines])


def draw(rows: Sequence[Row], path: Path) -> None:
    """The figures against the number of shapes, a panel for each unit; seconds are logarithmic, as the shapes are."""
    matplotlib.rcParams["svg.hashsalt"] = "bookkeeping"
    panels = list(dict.fromkeys(panel for _, panel, _ in FIGURES.values()))
    figure = Figure(figsize=(10.5, 3.6), layout="constrained")
    sizes = sorted({row["shapes"] for row in rows})
    for axes, unit in zip(figure.subplots(1, len(panels)), panels, strict=True):
        for mark, (name, values) in zip(
            "osD^v", ((n, v) for n, v in figures(rows).items() if FIGURES[n][1] == unit), strict=False
        ):
            if values:
                axes.plot([*values], [*values.values()], f"{mark}-", label=name.partition(",")[0])
        axes.set_xscale("log")
        if unit.startswith("seconds"):
            axes.set_yscale("log")
        else:
            axes.set_ylim(bottom=0)
        axes.set_xticks(sizes, [f"{size:,}" for size in sizes], rotation=30)
        axes.minorticks_off()
        axes.set_xlabel("shapes, N")
        axes.set_ylabel(unit)
        axes.grid(visible=True, color="0.9")
        axes.legend(frameon=False)
    figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None, dpi=120)


def _number(value: float) -> str:
    return f"{value:,.0f}" if value >= 100 else f"{value:.1f}"
