"""Plans of runs, for tests: the work items of every stage as they are if all goes well."""

from __future__ import annotations

from collections.abc import Callable

from pipeline.config.schema import Config
from pipeline.datasets.collection import Collection, collect
from pipeline.plan.progress import Progress, begin
from pipeline.plan.work_item import WorkItem
from pipeline.stages.all import STAGES, recipes
from pipeline.store.artifact import Artifact


def _nothing(item: WorkItem) -> Artifact:
    raise AssertionError(f"the plan of {item.stage} reads no result")


def planned(
    config: Config,
    until: str,
    collection: Collection | None = None,
    read: Callable[[WorkItem], Artifact] = _nothing,
) -> Progress:
    """A run of which every stage up to ``until`` is done; ``read`` gives the artifacts that later plans need."""
    progress = begin(config, collection or collect(config.dataset), recipes(config), read)
    for stage in STAGES:
        if stage.wanted(config):
            items = stage.items(progress)
            progress = progress.with_work(stage.name, items, progress.done | {item.reference for item in items})
        if stage.name == until:
            break
    return progress
