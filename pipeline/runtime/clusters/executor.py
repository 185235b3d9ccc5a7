"""The interface of all clusters: an executor runs bundles of work items."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol

from pipeline.plan.work_item import WorkItem
from pipeline.runtime.worker import Receipt
from pipeline.store.store import Store

Bundle = Sequence[WorkItem]
"""Work items of one stage that go to a worker as one task."""


class Executor(Protocol):
    """Runs bundles of work items in any order."""

    @property
    def workers(self) -> int:
        """How many bundles it runs at once."""

    def run(self, store: Store, bundles: Sequence[Bundle]) -> Iterator[Receipt]:
        """Run bundles against a store; yields the receipt of every work item as soon as it arrives."""
