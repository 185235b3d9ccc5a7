"""Plans shown, and misses explained: what would run, how long, and why."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from rich.console import Console
from rich.table import Table

from pipeline.config.schema import Config
from pipeline.datasets.collection import collect
from pipeline.plan.causes import Causes, Pictures
from pipeline.plan.plan import (
    Plan,
    WorkItem,
    make_plan,
    plan_construct,
    plan_crs,
    plan_fabrications,
    plan_full_trunks,
    plan_motions,
    plan_paint,
    plan_paper,
    plan_refine,
    plan_select,
    plan_shortlist,
)
from pipeline.stages.registry import BY_NAME
from pipeline.store.store import State, Store
from pipeline.tables.results import certified, least_deformed

MOST_SHOWN = 20
"""Lines of causes for each stage."""

KNOWN_AFTER = {
    "trunks_full": "the selection",
    "crs": "the selection",
    "refine": "the selection",
    "shortlist": "the trunks are refined",
    "construct": "the shortlist",
    "paper": "construction",
    "motion": "construction",
    "paint": "construction",
    "fabricate": "construction",
}
"""When it is known what a stage has to do, of stages that depend on results."""


@dataclass(frozen=True)
class StageForecast:
    """What a run would do in one stage; ``items`` is None while what they depend on is not known."""

    stage: str
    items: int | None
    cached: int
    corrupt: int
    seconds: float | None
    """Estimate of the work left on one worker, from what the stage's artifacts in the store once took."""
    missing: tuple[WorkItem, ...]
    pictures: Pictures | None = None
    """Of the stage that reads them."""


def forecast(config: Config, store: Store) -> list[StageForecast]:
    """What a run would find and do, stage by stage, without doing anything.

    Raises `pipeline.datasets.collection.DatasetError` when there is no collection.
    """
    plan = make_plan(config, collect(config.dataset))
    pictures = Pictures(plan.items, config.outputs / config.dataset.name)
    static = (("ingest", plan.ingest), ("reversibility", plan.reversibility), ("trunks", plan.trunks))
    found = [_stage(store, name, items) for name, items in static]
    found[0] = replace(found[0], pictures=pictures)
    scored = tuple(plan.qcrs.values())
    if plan.pairs is None:
        found.append(_stage(store, "qcrs", scored))
    else:
        found += [_stage(store, "shards", plan.shards), _stage(store, "partners", scored)]
        found.append(_stage(store, "pairs", [plan.pairs]))
    return found + _after_selection(plan, store)


def _after_selection(plan: Plan, store: Store) -> list[StageForecast]:
    done = {item.reference for item in (*plan.qcrs.values(), *plan.reversibility)}
    select = plan_select(plan, done)
    found = [_stage(store, "select", [select])]
    if found[0].cached == 0:
        return found + _unknown("trunks_full", plan)
    pairs = [(int(i), int(j)) for i, j in store.get(*select.reference).arrays["pairs"]]
    full = plan_full_trunks(plan, pairs)
    crs = plan_crs(plan, pairs, full)
    found.append(_stage(store, "trunks_full", list(full.values())))
    found.append(_stage(store, "crs", crs))
    refined = plan_refine(plan, crs)
    found.append(_stage(store, "refine", refined))
    if found[-1].missing:
        return found + _unknown("shortlist", plan)
    shortlist = plan_shortlist(plan, refined)
    found.append(_stage(store, "shortlist", [shortlist]))
    if found[-1].missing:
        return found + _unknown("construct", plan)
    made = plan_construct(plan, [refined[place] for place in store.get(*shortlist.reference).arrays["places"]])
    found.append(_stage(store, "construct", made))
    if found[-1].missing:
        return found + _unknown("paper", plan)
    passed = certified(store, made)
    if plan.config.compare:
        found.append(_stage(store, "paper", plan_paper(plan, least_deformed(store, passed, plan.config.compare))))
    motion = plan_motions(plan, passed)
    found.append(_stage(store, "motion", motion))
    if paint := plan_paint(plan, motion):
        found.append(_stage(store, "paint", paint))
    if plan.config.fabricate.top:
        best = plan_motions(plan, least_deformed(store, passed, plan.config.fabricate.top))
        found.append(_stage(store, "fabricate", plan_fabrications(plan, best)))
    return found


def _unknown(first: str, plan: Plan) -> list[StageForecast]:
    """Of the stages from ``first`` on, of which it is not known what they have to do."""
    names, counts = list(KNOWN_AFTER), _optional(plan.config)
    later = [name for name in names[names.index(first) :] if counts.get(name, 1)]
    return [StageForecast(name, None, 0, 0, None, ()) for name in later]


def _optional(config: Config) -> dict[str, int]:
    """How many transforms go to the stages that a run can do without, at most."""
    pictures = config.select.top if config.dataset.kind == "folder" else 0
    return {"paper": config.compare, "paint": pictures, "fabricate": config.fabricate.top}


def _stage(store: Store, name: str, items: Sequence[WorkItem]) -> StageForecast:
    states = [store.state(*item.reference) for item in items]
    missing = tuple(item for item, state in zip(items, states, strict=True) if state is not State.PRESENT)
    corrupt = sum(state is State.CORRUPT for state in states)
    costs = [entry.cost["seconds"] for entry in store.entries(name) if "seconds" in entry.cost] if missing else []
    seconds = len(missing) * sum(costs) / len(costs) if costs else None
    if not missing:
        seconds = 0.0
    return StageForecast(name, len(items), len(items) - len(missing), corrupt, seconds, missing)


def show_plan(forecasts: Sequence[StageForecast], config: Config, console: Console) -> None:
    """Print what would run."""
    select = config.select
    pairs = select.breadth * select.top
    at_most = {"trunks_full": 2 * pairs, "crs": pairs, "refine": pairs, "shortlist": 1}
    at_most |= {name: min(most, select.top) for name, most in _optional(config).items()}
    table = Table(title="Plan: nothing was run", title_justify="left")
    table.add_column("stage")
    table.add_column("work items")
    for title in ("in all", "cached", "to do", "damaged", "estimate"):
        table.add_column(title, justify="right")
    for one in forecasts:
        unit = BY_NAME[one.stage].unit
        if one.items is None:
            most = f"≤ {at_most.get(one.stage, select.top)}"
            table.add_row(one.stage, unit, most, "?", "?", "", f"after {KNOWN_AFTER[one.stage]}")
            continue
        estimate = "unknown" if one.seconds is None else f"{one.seconds:.1f} s"
        table.add_row(
            one.stage, unit, str(one.items), str(one.cached), str(len(one.missing)), str(one.corrupt or ""), estimate
        )
    console.print(table)
    console.print("Estimates are for one worker, from what the same stage took before.", highlight=False)


def show_explanation(forecasts: Sequence[StageForecast], store: Store, console: Console) -> None:
    """Print for every stage with work left which components of its keys changed, old and new."""
    causes = Causes(store, next((one.pictures for one in forecasts if one.pictures is not None), None))
    for one in forecasts:
        if one.items is None:
            console.print(f"{one.stage}: known after {KNOWN_AFTER[one.stage]}", highlight=False)
        elif not one.missing:
            console.print(f"{one.stage}: all {one.items} cached", highlight=False)
        else:
            console.print(f"{one.stage}: {len(one.missing)} of {one.items} to do, because", highlight=False)
            found = causes.of(one.missing).most_common()
            for text, count in found[:MOST_SHOWN]:
                console.print(f"  {count} × {text}", highlight=False, markup=False, soft_wrap=True)
            if found[MOST_SHOWN:]:
                left = sum(count for _, count in found[MOST_SHOWN:])
                console.print(f"  {left} × other combinations of such causes", highlight=False)
