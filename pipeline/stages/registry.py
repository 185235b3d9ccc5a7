"""The method as a list of stages: what each is called, which parameters it reads, and which module does its work."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from operator import attrgetter
from typing import Any

from pipeline.config.schema import Config, QcrsConfig
from pipeline.plan.code_digest import code_digests, edited_since_start, library_versions
from pipeline.store.artifact import Artifact, canonical_json
from pipeline.store.keys import KeyParts, SharedText, canonical_value


def _as_it_is(artifact: Artifact) -> Any:
    return artifact


@dataclass(frozen=True)
class Work:
    """How a stage's work is done: ``run`` of a work item's inputs, each of which ``prepare`` made of an artifact.

    A task prepares an input once for all its work items; a stage's module without ``prepare`` gets artifacts.
    """

    run: Callable[[Sequence[Any], Sequence[Any], Any], Artifact]
    prepare: Callable[[Artifact], Any] = _as_it_is


@dataclass(frozen=True)
class Stage:
    """One stage: name, the parameters it reads (groups, or one of a group), its items, how many go to a worker at once.

    ``bundle`` is the most work items in one task: a task should last a second or more, a stored artifact should be
    as small as can be used again. With ``tile`` a task is the work items between so many inputs and so many others, so
    that each input is read and prepared once for many work items.
    """

    name: str
    reads: tuple[str, ...]
    unit: str
    bundle: int = 1
    tile: int = 0

    @property
    def module(self) -> str:
        """The module whose ``run`` does the work, and whose import closure is the stage's code."""
        return f"pipeline.stages.{self.name}"


STAGES = (
    Stage("ingest", ("shape",), "batches of pictures", bundle=4),
    Stage("reversibility", ("reversibility",), "batches of shapes", bundle=16),
    Stage("trunks", ("trunks", "reversibility", "qcrs.variant"), "batches of shapes", bundle=8),
    Stage("qcrs", ("qcrs",), "blocks of pairs", tile=8),
    Stage("shards", (), "parts of the index"),
    Stage("partners", ("qcrs", "qcrs.k"), "searches of batches in parts", tile=8),
    Stage("pairs", ("qcrs.k",), "collection of pairs"),
    Stage("select", ("select",), "selection"),
    Stage("trunks_full", ("trunks",), "shapes", bundle=16),
    Stage("crs", ("crs", "refine.candidates"), "pairs", bundle=4),
    Stage("refine", ("refine", "construct.spacing", "construct.max_lost_contact"), "pairs", bundle=4),
    Stage("shortlist", ("select",), "selection"),
    Stage("construct", ("construct", "refine.reach"), "pairs"),
    Stage("paper", ("construct", "refine.reach"), "best transforms"),
    Stage("motion", ("motion",), "certified transforms", bundle=16),
    Stage("paint", (), "transforms of colour pictures", bundle=4),
    Stage("fabricate", ("fabricate.sizes", "fabricate.fix", "fabricate.paper"), "best transforms"),
)

BY_NAME = {stage.name: stage for stage in STAGES}


@dataclass(frozen=True)
class Recipe:
    """A stage with everything that its keys share: frozen when a run starts."""

    stage: Stage
    parameters: tuple[Any, ...]
    values: dict[str, Any]
    code: dict[str, str]
    versions: dict[str, str]

    def parts(self, inputs: Sequence[str], spec: Any = None) -> KeyParts:
        """Parts of the key of a work item; ``spec`` is whatever else the work depends on, as plain values."""
        if spec is None:
            return KeyParts(self.stage.name, self.values, tuple(inputs), self.code, self.versions, shared=self._shared)
        values = {**self.values, "item": canonical_value(spec)}
        return KeyParts(self.stage.name, values, tuple(inputs), self.code, self.versions)

    @cached_property
    def _shared(self) -> SharedText:
        return SharedText.of(KeyParts(self.stage.name, self.values, (), self.code, self.versions))


def recipe(stage: Stage, config: Config) -> Recipe:
    """Read a stage's parameters out of the configuration and take the digests of its code."""
    parameters = tuple(_read(config, name) for name in stage.reads)
    values = {name: canonical_value(value) for name, value in zip(stage.reads, parameters, strict=True)}
    return Recipe(stage, parameters, values, code_digests(stage.module), library_versions(stage.module))


def _read(config: Config, name: str) -> Any:
    value = attrgetter(name)(config)
    # Which pairs are scored is no part of a score: only stages that name mode or k depend on them.
    return value.sigmas if isinstance(value, QcrsConfig) else value


@cache
def work_of(stage: str, code: str) -> Work:
    """How a stage's work is done, if its code here and now is ``code`` (see `code_text`).

    Raises RuntimeError when it is not: the key would promise what other code computes.
    """
    module = BY_NAME[stage].module
    found = importlib.import_module(module)
    if code_text(code_digests(module), library_versions(module)) != code or edited_since_start(module):
        raise RuntimeError(
            f"the code of stage {stage} is not the code that the run was planned with: "
            "it changed after the start, or the workers have another version; start the run again"
        )
    return Work(found.run, getattr(found, "prepare", _as_it_is))


def code_text(code: dict[str, str], versions: dict[str, str]) -> str:
    """Code digests and versions as one comparable text."""
    return canonical_json([code, versions])
