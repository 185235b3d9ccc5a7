"""The results of a run, read from the store item by item: the source of all tables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from pipeline.config.schema import Config
from pipeline.datasets.collection import Collection
from pipeline.datasets.item import SOURCE, shown_source
from pipeline.plan.progress import Progress
from pipeline.plan.work_item import Pair, Reference, WorkItem
from pipeline.runtime.events import StageEnded
from pipeline.runtime.worker import Failure
from pipeline.stages.all import BY_NAME
from pipeline.stages.select import selected
from pipeline.store.artifact import Artifact
from pipeline.store.store import Store
from pipeline.tables.partner_search import PartnerSearch
from riot.types import FloatArray, IntArray

Row = dict[str, Any]


@dataclass(frozen=True)
class Results:
    """A run at its end. Positions number the collection's items, shape numbers only what has a shape."""

    progress: Progress
    store: Store
    failed: Mapping[Reference, Failure]
    blocked: int
    """How many work items were not tried because an input had failed."""
    stages: tuple[StageEnded, ...]

    @property
    def config(self) -> Config:
        """The run's configuration."""
        return self.progress.config

    @property
    def collection(self) -> Collection:
        """What was mined."""
        return self.progress.collection

    @cached_property
    def work(self) -> Mapping[str, Sequence[WorkItem]]:
        """Work items of every stage, by name of the stage; parts of blocks that were lost among them."""
        return {name: (*items, *self.progress.lost.get(name, ())) for name, items in self.progress.work.items()}

    def artifact(self, item: WorkItem | None) -> Artifact | None:
        """The artifact of a work item; None where it failed or was blocked, or there is no such item."""
        if item is None or item.reference not in self.progress.done:
            return None
        return self.progress.read(item)

    def by_members(self, stage: str) -> dict[tuple[int, ...], WorkItem]:
        """Work items of a stage by the positions that they concern."""
        return {item.members: item for item in self.progress.work.get(stage, ())}

    @cached_property
    def keys(self) -> Mapping[str, Mapping[tuple[int, ...], str]]:
        """Keys of what is done of each shape and pair, by stage and positions."""
        return {
            stage: {item.members: item.key for item in self.progress.finished(stage)}
            for stage in self.progress.work
            if BY_NAME[stage].scope in ("shape", "pair")
        }

    @cached_property
    def numbers(self) -> IntArray:
        """(items,) shape number of every position, −1 without a shape."""
        lengths = np.zeros(len(self.progress.items), dtype=np.int64)
        for batch, item in zip(self.progress.batches, self.progress.work["ingest"], strict=True):
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
    def doubtful(self) -> int:
        """How many shapes may have been read wrongly."""
        read = [self.artifact(item) for item in self.progress.work["ingest"]]
        return sum(int(artifact.arrays["quality_doubtful"].sum()) for artifact in read if artifact is not None)

    @property
    def classes(self) -> int:
        """How many classes the shapes have; one without a class is a class of its own."""
        present = [item.cls for item, number in zip(self.progress.items, self.numbers, strict=True) if number >= 0]
        return len(set(present) - {""}) + present.count("")

    @cached_property
    def pairs(self) -> list[Pair]:
        """The selected pairs, best first; positions in the collection."""
        return [(int(i), int(j)) for i, j in selected(self.progress).pairs]

    @cached_property
    def qcrs(self) -> FloatArray:
        """(pairs,) QCRS of the selected pairs."""
        return selected(self.progress).score

    @cached_property
    def search(self) -> PartnerSearch | None:
        """What the search for partners took; None with ``qcrs.mode=all``, or when it failed."""
        collected = [self.artifact(item) for item in self.progress.work.get("pairs", ())]
        if not collected or collected[0] is None:
            return None
        missed = {
            member
            for item in (*self.work["partners"], *self.work["partners_beyond"])
            if item.reference not in self.progress.done
            for member in item.members
        }
        known = sum(bool(self.numbers[member] >= 0) for member in missed)
        return PartnerSearch(self.config.qcrs.k, self.shapes, known, int(self.config.qcrs.mode == "approximate"))

    @cached_property
    def without_trunks(self) -> int:
        """How many shapes were searched for trunks that QCRS compares and have none."""
        total = 0
        for batch, item in zip(self.progress.batches, self.progress.work["trunks"], strict=True):
            artifact = self.artifact(item)
            if artifact is not None:
                none = np.diff(artifact.arrays["trunk_offsets"]) == 0
                total += int((none & (self.numbers[batch.start : batch.stop] >= 0)).sum())
        return total

    @cached_property
    def errors(self) -> list[Row]:
        """Rows of the table of errors: by stage, then by item."""
        rows = []
        for rejected in self.collection.rejected:
            message = rejected.message.replace(rejected.source, shown_source(rejected.name, rejected.source))
            rows.append(
                _error(rejected.name, rejected.stage, "", rejected.type, rejected.reason, message, rejected.attempts)
            )
        for stage, items in self.work.items():
            for item in items:
                rows += self._errors_of(stage, item)
        return rows

    def _errors_of(self, stage: str, item: WorkItem) -> Iterator[Row]:
        failure = self.failed.get(item.reference)
        if failure is not None:
            message = failure.message  # an error of the system names the file with its whole path
            for position in self.progress.members(item):
                collection_item = self.progress.items[position]
                message = message.replace(collection_item.source, collection_item.shown_source)
            for name in self._names(item):
                yield _error(name, stage, item.key, failure.type, failure.reason, message, failure.attempts)
            return
        scope = BY_NAME[stage].scope
        artifact = None if scope in ("block", "part", "collection") else self.artifact(item)
        for row in () if artifact is None else artifact.document.get("errors", ()):
            if scope == "pair":
                name, message = self._names(item)[0], row["message"]
            else:
                member = self.progress.items[item.members[row["index"]]]
                name, message = member.name, row["message"].replace(SOURCE, member.shown_source)
            yield _error(name, stage, item.key, row["type"], row["reason"], message, 1)

    def _names(self, item: WorkItem) -> list[str]:
        names = [self.progress.items[position].name for position in self.progress.members(item)]
        of_pair = BY_NAME[item.stage].scope == "pair" or (item.stage == "qcrs" and len(names) == 2)
        return [" × ".join(names)] if of_pair else names or [f"({item.stage})"]


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
