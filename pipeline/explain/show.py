"""Forecasts and explanations as text."""

from __future__ import annotations

from pipeline.config.schema import Config
from pipeline.explain.causes import Causes
from pipeline.explain.forecast import Forecast
from pipeline.store.store import Store
from riot.errors import needs_extra

with needs_extra("mine"):
    from rich.console import Console
    from rich.table import Table

MOST_SHOWN = 20
"""Most lines of causes for a stage: a screen (ours)."""


def show_plan(forecast: Forecast, config: Config, console: Console) -> None:
    """Print the work of each stage."""
    table = Table(title="Plan: nothing was run", title_justify="left")
    table.add_column("stage")
    table.add_column("work items")
    for title in ("in all", "cached", "to do", "damaged", "estimate"):
        table.add_column(title, justify="right")
    for row in forecast.stages:
        stage = row.stage
        if row.items is None:
            most = f"≤ {stage.at_most(config)}"
            table.add_row(stage.name, stage.unit, most, "?", "?", "", f"after {stage.known_after}")
            continue
        estimate = "unknown" if row.seconds is None else f"{row.seconds:.1f} s"
        counts = (str(row.items), str(row.cached), str(len(row.missing)), str(row.corrupt or ""))
        table.add_row(stage.name, stage.unit, *counts, estimate)
    console.print(table)
    console.print("Estimates are for one worker, from what the same stage took before.", highlight=False)


def show_explanation(forecast: Forecast, store: Store, console: Console) -> None:
    """Print which components of its keys changed, for every stage with missing work."""
    causes = Causes(store, forecast.pictures)
    for row in forecast.stages:
        stage = row.stage
        if row.items is None:
            console.print(f"{stage.name}: known after {stage.known_after}", highlight=False)
        elif not row.missing:
            console.print(f"{stage.name}: all {row.items} cached", highlight=False)
        else:
            console.print(f"{stage.name}: {len(row.missing)} of {row.items} to do, because", highlight=False)
            counted = causes.count(row.missing).most_common()
            for text, count in counted[:MOST_SHOWN]:
                console.print(f"  {count} × {text}", highlight=False, markup=False, soft_wrap=True)
            if counted[MOST_SHOWN:]:
                left = sum(count for _, count in counted[MOST_SHOWN:])
                console.print(f"  {left} × other combinations of such causes", highlight=False)
