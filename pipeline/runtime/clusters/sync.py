"""``cluster=sync``: everything in this process, one item after another, for debugging and as the reference."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pipeline.runtime.clusters.executor import Bundle
from pipeline.runtime.inputs import InputCache
from pipeline.runtime.worker import Receipt, run_items
from pipeline.store.store import Store


class SyncExecutor:
    """See `pipeline.runtime.clusters.executor.Executor`. It has no time limit."""

    workers = 1

    def __init__(self) -> None:
        self._cache = InputCache()

    def run(self, store: Store, bundles: Sequence[Bundle]) -> Iterator[Receipt]:
        """See `Executor.run`."""
        for bundle in bundles:
            yield from run_items(store, bundle, self._cache)
