"""All stages, in the order in which a run goes through them."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache
from graphlib import TopologicalSorter

from pipeline import stages
from pipeline.config.schema import Config
from pipeline.datasets.collection import Collection
from pipeline.plan.code_digest import code_digests, edited_since_start, library_versions
from pipeline.plan.progress import Progress, begin
from pipeline.plan.work_item import Recipe
from pipeline.stages.stage import Stage
from pipeline.stages.wishes import check_wishes
from pipeline.store.artifact import canonical_json
from pipeline.store.reader import ArtifactReader
from pipeline.store.store import Store


def in_order(stages_by_name: Mapping[str, Stage]) -> tuple[Stage, ...]:
    """Sort stages so that each comes after those that it names; of several that may be next, the first by name.

    Raises KeyError if a stage comes after one that does not exist, CycleError if stages come after each other.
    """
    sorter = TopologicalSorter({name: stage.after for name, stage in stages_by_name.items()})
    sorter.prepare()
    ready: list[str] = []
    ordered: list[Stage] = []
    while sorter.is_active():
        ready = sorted([*ready, *sorter.get_ready()])
        name = ready.pop(0)
        ordered.append(stages_by_name[name])
        sorter.done(name)
    return tuple(ordered)


def _stages() -> dict[str, Stage]:
    names = sorted(module.name for module in pkgutil.iter_modules(stages.__path__))
    modules = [importlib.import_module(f"pipeline.stages.{name}") for name in names if name != "all"]
    defined = [vars(module)["STAGE"] for module in modules if "STAGE" in vars(module)]
    return {stage.name: stage for stage in defined}


BY_NAME: Mapping[str, Stage] = _stages()
STAGES: tuple[Stage, ...] = in_order(BY_NAME)


def recipes(config: Config) -> dict[str, Recipe]:
    """The recipe of every stage, by its name."""
    return {stage.name: stage.recipe(config) for stage in STAGES}


def begin_run(config: Config, collection: Collection, store: Store) -> Progress:
    """A run before its first stage, which reads what earlier stages found from ``store``, small artifacts once.

    Raises `StartError` for a wish that names what the collection lacks.
    """
    check_wishes(config.select, collection.items)
    read = ArtifactReader(store.read)
    return begin(config, collection, recipes(config), lambda item: read(*item.reference))


@cache
def checked_stage(name: str, code: str) -> Stage:
    """The stage of this name, if its code here and now is ``code`` (see `code_text`).

    Raises RuntimeError when it is not: the key would promise what other code computes.
    """
    stage = BY_NAME[name]
    module = stage.module
    if code_text(code_digests(module), library_versions(module)) != code or edited_since_start(module):
        raise RuntimeError(
            f"the code of stage {name} is not the code that the run was planned with: "
            "it changed after the start, or the workers have another version; start the run again"
        )
    return stage


def code_text(code: Mapping[str, str], versions: Mapping[str, str]) -> str:
    """Code digests and versions as one comparable text."""
    return canonical_json([code, versions])
