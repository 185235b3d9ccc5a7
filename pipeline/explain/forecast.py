"""Forecast: what a run would find in the store and what it would do, stage by stage, without doing anything."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pipeline.config.schema import Config
from pipeline.datasets.collection import collect
from pipeline.explain.causes import Pictures
from pipeline.plan.progress import begin
from pipeline.plan.work_item import WorkItem
from pipeline.stages.all import STAGES, recipes
from pipeline.stages.stage import Stage
from pipeline.store.reader import ArtifactReader
from pipeline.store.store import State, Store


@dataclass(frozen=True)
class StageForecast:
    """What a run would do in one stage; ``items`` is None while what they depend on is not known."""

    stage: Stage
    items: int | None
    cached: int = 0
    corrupt: int = 0
    seconds: float | None = None
    """Estimate of the work left on one worker, from what the stage's artifacts in the store once took."""
    missing: tuple[WorkItem, ...] = ()


@dataclass(frozen=True)
class Forecast:
    """What a run would do, and the pictures that it would read."""

    stages: tuple[StageForecast, ...]
    pictures: Pictures


def forecast(config: Config, store: Store) -> Forecast:
    """What a run would find and do; raises `pipeline.datasets.collection.DatasetError` when there is no collection."""
    read = ArtifactReader(store.get)
    collection = collect(config.dataset)
    progress = begin(config, collection, recipes(config), lambda item: read(*item.reference))
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
        # As if all went well: later stages are planned as they would be then.
        progress = progress.with_work(stage.name, items, progress.done | {item.reference for item in items})
        if items or not (stage.optional and stage.scope == "pair"):
            stages.append(_look(stage, items, store))
            if stages[-1].missing:
                incomplete.add(stage.name)
    pictures = Pictures(progress.items, config.outputs / config.dataset.name)
    return Forecast(tuple(stages), pictures)


def _look(stage: Stage, items: Sequence[WorkItem], store: Store) -> StageForecast:
    states = [store.state(*item.reference) for item in items]
    missing = tuple(item for item, state in zip(items, states, strict=True) if state is not State.PRESENT)
    corrupt = sum(state is State.CORRUPT for state in states)
    costs = [entry.cost["seconds"] for entry in store.entries(stage.name) if "seconds" in entry.cost] if missing else []
    seconds = len(missing) * sum(costs) / len(costs) if costs else None
    return StageForecast(stage, len(items), len(items) - len(missing), corrupt, seconds if missing else 0.0, missing)
