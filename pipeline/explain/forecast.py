"""Forecast what a run would read from the store and what it would compute, stage by stage, without computing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pipeline.config.schema import Config
from pipeline.datasets.collection import collect
from pipeline.explain.causes import Pictures
from pipeline.plan.work_item import WorkItem
from pipeline.stages.all import STAGES, begin_run
from pipeline.stages.stage import Stage
from pipeline.store.store import State, Store


@dataclass(frozen=True)
class StageForecast:
    """What a run would do in a stage; ``items`` is None if it depends on work that is not done."""

    stage: Stage
    items: int | None
    cached: int = 0
    corrupt: int = 0
    seconds: float | None = None
    """Estimated time of the missing work on one worker, from the mean time of the stage's stored artifacts."""
    missing: tuple[WorkItem, ...] = ()


@dataclass(frozen=True)
class Forecast:
    """The work of a run, by stage, and the pictures that it would read."""

    stages: tuple[StageForecast, ...]
    pictures: Pictures


def forecast(config: Config, store: Store) -> Forecast:
    """Forecast a run; raises `pipeline.datasets.collection.DatasetError` if there is no collection."""
    progress = begin_run(config, collect(config.dataset), store)
    incomplete: set[str] = set()
    stages = []
    for stage in STAGES:
        if not stage.wanted(config):
            continue
        if stage.known_after in incomplete:
            incomplete.add(stage.name)
            stages.append(StageForecast(stage, None))
            continue
        items = stage.items(progress)
        # Later stages are planned as if this one succeeds.
        progress = progress.with_work(stage.name, items, progress.done | {item.reference for item in items})
        if stage.is_due(items):
            stages.append(_look(stage, items, store))
            if stages[-1].missing:
                incomplete.add(stage.name)
    pictures = Pictures(progress.items, config.outputs / config.dataset.name)
    return Forecast(tuple(stages), pictures)


def _look(stage: Stage, items: Sequence[WorkItem], store: Store) -> StageForecast:
    states = [state for state, _ in store.check_all([item.reference for item in items])]
    missing = tuple(item for item, state in zip(items, states, strict=True) if state is not State.PRESENT)
    corrupt = sum(state is State.CORRUPT for state in states)
    costs = [entry.cost["seconds"] for entry in store.entries(stage.name) if "seconds" in entry.cost] if missing else []
    seconds = len(missing) * sum(costs) / len(costs) if costs else None
    return StageForecast(stage, len(items), len(items) - len(missing), corrupt, seconds if missing else 0.0, missing)
