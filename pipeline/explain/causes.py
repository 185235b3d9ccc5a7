"""Causes: which part of a work item's key changed since the nearest stored artifact of its stage."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from pipeline.datasets.item import Item
from pipeline.plan.work_item import WorkItem
from pipeline.store.artifact import canonical_json
from pipeline.store.store import State, Store

Changes = tuple[str, ...]

Cause = tuple[str, str]
"""The stage in which a change began, and the change in words."""

NOTHING_STORED = "new: nothing of this stage is in the store"

NOT_DONE = "not done yet: all that it reads is in the store (a run ended before it, it failed, or none asked for it)"

FEW = 3
"""Most names, or causes of a work item, that an explanation lists: one line of a terminal (ours)."""


class Causes:
    """Explain why work items are not in the store, by comparison with the nearest stored artifacts of their stages.

    Ask stage after stage: a change that a stage inherits is explained by the cause found for the earlier stage.
    """

    def __init__(self, store: Store, pictures: Pictures | None = None) -> None:
        self._store, self._pictures = store, pictures or Pictures()
        self._known: dict[str, list[Known]] = {}
        self._causes_of: dict[str, tuple[Cause, ...]] = {}

    def count(self, missing: Iterable[WorkItem]) -> Counter[str]:
        """Count the work items by the text of their causes; later calls refer to these causes."""
        return Counter(self._text(item) for item in missing)

    def _text(self, item: WorkItem) -> str:
        own = self._own(item)
        own_texts = {text for _, text in own}
        inherited: dict[str, Cause] = {}  # by the change: one that reaches several inputs is listed once
        for cause in (
            cause for key in item.parts.inputs for cause in self._causes_of.get(key, ()) if cause[1] not in own_texts
        ):
            inherited.setdefault(cause[1], cause)
        causes = (*own, *inherited.values()) or self._inputs(item)
        self._causes_of[item.key] = causes
        if item.stage == "ingest":
            self._causes_of |= {alone.key(): causes for alone in item.parts.each_input()}
        words = [text if stage == item.stage else f"after {stage}: {text}" for stage, text in causes]
        return "; ".join(_few(words))

    def _own(self, item: WorkItem) -> tuple[Cause, ...]:
        """Which parts of the item's key, except its inputs, differ from the nearest stored artifact."""
        if self._store.state(*item.reference) is State.CORRUPT:
            return ((item.stage, "corrupt: the stored artifact is torn, truncated or altered"),)
        if item.stage not in self._known:
            self._known[item.stage] = gather(entry.parts for entry in self._store.entries(item.stage))
        if not self._known[item.stage]:
            return ((item.stage, NOTHING_STORED),)
        stored = nearest(item.parts.to_json(), self._known[item.stage])
        return tuple((item.stage, text) for text in stored.changes(item.parts.to_json()))

    def _inputs(self, item: WorkItem) -> tuple[Cause, ...]:
        """How the inputs differ from the nearest stored artifact's, if nothing else does and all inputs are stored."""
        stored = nearest(item.parts.to_json(), self._known[item.stage])
        if item.stage == "ingest":
            return (("ingest", self._pictures.changed(item, stored)),)
        if not stored.inputs.issuperset(item.parts.inputs):
            return ((item.stage, NOT_DONE),)
        if self._pictures.removed:
            return (("ingest", self._pictures.removed),)
        return ((item.stage, stored.new_inputs(item.parts.inputs)),)


@dataclass(frozen=True)
class Pictures:
    """The pictures of the collection, and the folder of the previous run, whose tables list the pictures it had."""

    items: tuple[Item, ...] = ()
    folder: Path | None = None

    @cached_property
    def before(self) -> Mapping[str, str]:
        """Digests of the previous run's shapes, by name; empty for a file without a shape."""
        if self.folder is None:
            return {}
        import pyarrow.parquet as pq  # imported here because only an explanation needs it

        try:
            shapes = pq.read_table(self.folder / "shapes.parquet", columns=["name", "digest"]).to_pydict()
            errors = pq.read_table(self.folder / "errors.parquet", columns=["item"]).to_pydict()
        except (OSError, ValueError, KeyError):
            return {}
        return dict.fromkeys(errors["item"], "") | dict(zip(shapes["name"], shapes["digest"], strict=True))

    @cached_property
    def removed(self) -> str:
        """Which shapes of the previous run are no longer in the collection under any name, in words; "" if none."""
        left = {item.digest for item in self.items} | {item.name for item in self.items}
        gone = [name for name, digest in self.before.items() if digest and left.isdisjoint((name, digest))]
        return _listed("picture removed", gone)

    def describe(self, new: Sequence[Item]) -> str:
        """Which of the ``new`` items replace others of the same name, and which are additional, in words."""
        replaced = [item.shown_source for item in new if item.name in self.before]
        added = [item.shown_source for item in new if item.name not in self.before]
        word = "picture added" if self.before else "picture new to the store"
        return "; ".join(filter(None, (_listed("picture replaced", replaced), _listed(word, added))))

    def changed(self, batch: WorkItem, stored: Known) -> str:
        """Which pictures make a batch differ from the ``stored`` batches, whose keys are otherwise equal, in words."""
        new = [item for item in batch.spec if item.digest not in stored.inputs]
        # If all pictures of a batch are known, a change beside the batch moved its limits.
        others = [item for item in self.items if item.digest not in stored.inputs]
        around = "; ".join(filter(None, (self.removed, self.describe(others))))
        return self.describe(new) or around or "pictures in other batches, each known"


@dataclass(frozen=True)
class Known:
    """Stored keys that differ in their inputs only: the parts that they share, and all their inputs."""

    shared: Mapping[str, Any]
    inputs: frozenset[str]

    def changes(self, parts: Mapping[str, Any]) -> list[str]:
        """Components of a key that differ from the shared ones, with old and new values."""
        return _differences("", self.shared, _shared(parts))

    def new_inputs(self, inputs: Collection[str]) -> str:
        """How a key's inputs differ from the stored ones, in words."""
        new = set(inputs) - self.inputs
        if not new:
            return "inputs: known ones in a combination that is not done yet, or under other names"
        return f"inputs: {len(new)} of {len(set(inputs))} are new"


def gather(stored: Iterable[Mapping[str, Any]]) -> list[Known]:
    """Group the parts of stored keys by everything but their inputs, so that thousands of keys are a few groups."""
    groups: dict[str, tuple[Mapping[str, Any], set[str]]] = {}
    for parts in stored:
        shared = _shared(parts)
        groups.setdefault(canonical_json(shared), (shared, set()))[1].update(parts["inputs"])
    return [Known(shared, frozenset(inputs)) for shared, inputs in groups.values()]


def explain(parts: Mapping[str, Any], known: Sequence[Known]) -> Changes:
    """List the components of a key that differ from the nearest of the ``known`` keys, with old and new values."""
    if not known:
        return (NOTHING_STORED,)
    stored = nearest(parts, known)
    return tuple(stored.changes(parts)) or (stored.new_inputs(parts["inputs"]),)


def nearest(parts: Mapping[str, Any], known: Sequence[Known]) -> Known:
    """The ``known`` keys that differ in the fewest components; among equals, those that share the most inputs."""
    inputs = set(parts["inputs"])
    return min(known, key=lambda old: (len(old.changes(parts)), -len(inputs & old.inputs)))


def _shared(parts: Mapping[str, Any]) -> dict[str, Any]:
    # parameters.item tells apart work items with the same inputs.
    parameters = {name: value for name, value in parts["parameters"].items() if name != "item"}
    return {"schema": parts["schema"], "parameters": parameters, "code": parts["code"], "versions": parts["versions"]}


def _differences(name: str, old: Any, new: Any) -> list[str]:
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        differences = []
        for key in sorted(old.keys() | new.keys()):
            differences += _differences(f"{name}.{key}".lstrip("."), old.get(key), new.get(key))
        return differences
    if old == new:
        return []
    if name.startswith("code."):
        return [f"{name} {_short(old)} → {_short(new)}"]
    return [f"{name} {old!r} → {new!r}"]


def _listed(what: str, names: Sequence[str]) -> str:
    return f"{what}: {', '.join(_few(names))}" if names else ""


def _few(texts: Sequence[str]) -> list[str]:
    return [*texts[:FEW], *([f"and {len(texts) - FEW} more"] if texts[FEW:] else [])]


def _short(digest: Any) -> str:
    return digest[:8] if isinstance(digest, str) else "absent"
