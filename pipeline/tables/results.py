"""What a run found, read back from the store item by item: the source of all tables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import PurePath
from typing import Any

import numpy as np

from pipeline.datasets.collection import Collection
from pipeline.datasets.item import SOURCE, Item
from pipeline.datasets.sample import PREFIX
from pipeline.plan.plan import Pair, Plan, Reference, WorkItem
from pipeline.runtime.events import StageEnded
from pipeline.runtime.worker import Failure
from pipeline.store.artifact import Artifact
from pipeline.store.store import Store
from pipeline.tables.partner_search import Search
from riot.types import FloatArray, IntArray

Row = dict[str, Any]

OF_PAIRS = ("crs", "refine", "construct", "paper", "motion", "paint", "fabricate")
"""Stages whose work items concern a pair."""

NOT_BY_SHAPE = ("qcrs", "shards", "partners", "pairs", "select", "shortlist")
"""Stages whose artifacts have no errors of single shapes."""


@dataclass(frozen=True)
class Results:
    """The plan with what became of it. Positions number the collection's items, shape numbers only what has a shape."""

    plan: Plan
    collection: Collection
    store: Store
    done: frozenset[Reference]
    failed: Mapping[Reference, Failure]
    blocked: int
    pairs: tuple[Pair, ...]
    qcrs: FloatArray
    work: Mapping[str, Sequence[WorkItem]]
    """Work items of every stage, by name of the stage."""
    stages: tuple[StageEnded, ...]

    def artifact(self, item: WorkItem) -> Artifact | None:
        """The artifact of a work item; None where it failed or was blocked."""
        return self.store.get(*item.reference) if item.reference in self.done else None

    @cached_property
    def numbers(self) -> IntArray:
        """(items,) shape number of every position, −1 without a shape."""
        lengths = np.zeros(len(self.plan.items), dtype=np.int64)
        for batch, item in zip(self.plan.batches, self.plan.ingest, strict=True):
            artifact = self.artifact(item)
            if artifact is not None:
                lengths[batch.start : batch.stop] = np.diff(artifact.arrays["offsets"])
        valid = lengths > 0
        return np.where(valid, np.cumsum(valid) - 1, -1)

    @property
    def shapes(self) -> int:
        """How many items became shapes."""
        return int((self.numbers >= 0).sum())

    @property
    def classes(self) -> int:
        """How many classes the shapes have; one without a class is a class of its own."""
        found = [item.cls for item, number in zip(self.plan.items, self.numbers, strict=True) if number >= 0]
        return len(set(found) - {""}) + found.count("")

    @cached_property
    def search(self) -> Search | None:
        """What the search for partners took; None with ``qcrs.mode=all``, or when it failed."""
        found = None if self.plan.pairs is None else self.artifact(self.plan.pairs)
        if found is None:
            return None
        missed = {
            member for item in self.work["partners"] if item.reference not in self.done for member in item.members
        }
        known = sum(bool(self.numbers[member] >= 0) for member in missed)
        return Search(self.plan.config.qcrs.k, self.shapes, int(found.document["compared"]), known)

    @cached_property
    def without_trunks(self) -> int:
        """How many shapes were searched for trunks that QCRS compares and have none."""
        total = 0
        for batch, item in zip(self.plan.batches, self.plan.trunks, strict=True):
            artifact = self.artifact(item)
            if artifact is not None:
                none = np.diff(artifact.arrays["trunk_offsets"]) == 0
                total += int((none & (self.numbers[batch.start : batch.stop] >= 0)).sum())
        return total

    def source(self, item: Item) -> str:
        """The item's source relative to its collection: where that lies is no part of the tables."""
        return shown_source(item.name, item.source)

    @cached_property
    def errors(self) -> list[Row]:
        """Rows of the table of errors: by stage, then by item."""
        rows = [
            _error(
                one.name,
                one.stage,
                "",
                one.type,
                one.reason,
                self._readable(one.message, one.source, one.name),
                one.attempts,
            )
            for one in self.collection.rejected
        ]
        for name, items in self.work.items():
            for item in items:
                rows += self._failed(name, item)
        return rows

    def _readable(self, message: str, source: str, name: str) -> str:
        return message.replace(source, shown_source(name, source))

    def _failed(self, stage: str, item: WorkItem) -> Iterator[Row]:
        failure = self.failed.get(item.reference)
        if failure is not None:
            message = failure.message  # an error of the system names the file with its whole path
            for position in item.members:
                of = self.plan.items[position]
                message = self._readable(message, of.source, of.name)
            for name in self._names(item):
                yield _error(name, stage, item.key, failure.type, failure.reason, message, failure.attempts)
            return
        if item.reference not in self.done or stage in NOT_BY_SHAPE:
            return
        artifact = self.store.get(*item.reference)
        for row in artifact.document.get("errors", ()):
            if len(item.members) == 2 and stage in OF_PAIRS:
                name, message = self._names(item)[0], row["message"]
            else:
                member = self.plan.items[item.members[row["index"]]]
                name, message = member.name, row["message"].replace(SOURCE, self.source(member))
            yield _error(name, stage, item.key, row["type"], row["reason"], message, 1)

    def _names(self, item: WorkItem) -> list[str]:
        names = [self.plan.items[position].name for position in item.members]
        of_pair = item.stage in OF_PAIRS or (item.stage == "qcrs" and len(names) == 2)
        return [" × ".join(names)] if of_pair else names or [f"({item.stage})"]


def certified(store: Store, made: Sequence[WorkItem]) -> list[WorkItem]:
    """Those of finished constructions that passed."""
    return [item for item in made if store.get(*item.reference).document["status"] == "certified"]


def least_deformed(store: Store, passed: Sequence[WorkItem], count: int) -> list[WorkItem]:
    """The ``count`` constructions of greatest IoU of the worse shape among those that passed, best first."""

    def iou(item: WorkItem) -> float:
        document = store.get(*item.reference).document
        return min(float(document["iou_p"]), float(document["iou_q"]))

    # Nothing need be read where nothing is wanted.
    return sorted(passed, key=iou, reverse=True)[:count] if count else []


def shown_source(name: str, source: str) -> str:
    """A source without the place of its collection: a sample's definition, or the file's path below the root."""
    if source.startswith(PREFIX):
        return source
    suffix = PurePath(source).suffix
    return name if name.endswith(suffix) else name + suffix


def _error(item: str, stage: str, key: str, kind: str, reason: str, message: str, attempts: int) -> Row:
    return {
        "item": item,
        "stage": stage,
        "key": key,
        "type": kind,
        "reason": reason,
        "message": message,
        "attempts": attempts,
    }
