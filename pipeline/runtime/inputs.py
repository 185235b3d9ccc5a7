"""The inputs of a task's work items: each is read once, and kept while it is needed again and fits in memory."""

from __future__ import annotations

import math
import threading
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from typing import Any, overload

from pipeline.plan.work_item import Reference, WorkItem
from pipeline.stages.all import BY_NAME
from pipeline.store.artifact import Artifact
from pipeline.store.store import Store

CACHE_BYTES = 160 * 2**20
"""A worker keeps prepared inputs of artifacts of at most this size; the prepared ones take about twice as much."""

Prepare = Callable[[Artifact], Any]


class InputCache:
    """Prepared inputs of one stage, which a worker keeps from one task to the next where the stage works in tiles.

    They are named by content, so that the cache changes no result, and their size is bounded. A task of another stage
    empties the cache.
    """

    def __init__(self, limit: int = CACHE_BYTES) -> None:
        self._limit, self._stage, self._size = limit, "", 0
        self._entries: dict[Reference, tuple[Any, int]] = {}
        self._lock = threading.Lock()  # a worker of an external cluster may have several threads

    @property
    def size(self) -> int:
        """Bytes of the artifacts whose prepared inputs are in the cache."""
        return self._size

    def begin(self, stage: str) -> None:
        """Drop the inputs of another stage."""
        with self._lock:
            if stage != self._stage:
                self._entries.clear()
                self._stage, self._size = stage, 0

    def get(self, source: Reference) -> Any:
        """An input; None when it is not in the cache."""
        with self._lock:
            entry = self._entries.pop(source, None)
            if entry is None:
                return None
            self._entries[source] = entry  # the last entry is the one used last
            return entry[0]

    def keep(self, source: Reference, prepared: Any, size: int, next_use: Callable[[Reference], float]) -> None:
        """Keep an input. When it does not fit, drop others: first the inputs whose next use is last, of equal ones the
        oldest. The last one stays, whatever its size."""
        with self._lock:
            if source in self._entries:
                return
            self._entries[source] = prepared, size
            self._size += size
            while self._size > self._limit and len(self._entries) > 1:
                last = max(self._entries, key=next_use)
                self._size -= self._entries.pop(last)[1]

    def drop(self, source: Reference) -> None:
        """Drop one input."""
        with self._lock:
            self._size -= self._entries.pop(source, (None, 0))[1]


class Inputs:
    """Prepared inputs of the work items of one task, which run in order, so that each input's next use is known."""

    def __init__(self, store: Store, items: Sequence[WorkItem], cache: InputCache) -> None:
        self._store, self._cache = store, cache
        self.read_bytes = 0
        """Bytes of the arrays that were read from the store so far."""
        self._uses: dict[Reference, list[int]] = defaultdict(list)
        for position, item in enumerate(items):
            for source in item.sources:
                self._uses[source].append(position)

    def of(self, position: int, item: WorkItem, prepare: Prepare) -> Sequence[Any]:
        """The prepared inputs of the item at a ``position`` of the task; each is read when it is accessed.

        The access raises KeyError when an input is absent, `pipeline.errors.PayloadError` when it is corrupt.
        """
        self._cache.begin(item.stage)
        stage = BY_NAME[item.stage]
        is_tiled = stage.tile > 0 or stage.searches > 0
        return _LazyInputs(item.sources, lambda source: self._get(source, position, prepare, is_tiled))

    def _get(self, source: Reference, position: int, prepare: Prepare, is_tiled: bool) -> Any:
        is_kept = is_tiled or self._next_use(source, position) < math.inf
        prepared = self._cache.get(source)
        if prepared is None:
            artifact = self._store.read(*source)
            size = sum(array.nbytes for array in artifact.arrays.values())
            self.read_bytes += size
            prepared = prepare(artifact)
            if is_kept:
                self._cache.keep(source, prepared, size, lambda other: self._next_use(other, position))
        elif not is_kept:
            self._cache.drop(source)
        return prepared

    def _next_use(self, source: Reference, position: int) -> float:
        """The position of the next item after ``position`` that reads a source; infinity when there is none."""
        uses = self._uses.get(source, [])
        index = bisect_right(uses, position)
        return uses[index] if index < len(uses) else math.inf


class _LazyInputs(Sequence[Any]):
    """Inputs that are read when they are accessed: a selection has more of them than fit in memory at once."""

    def __init__(self, sources: Sequence[Reference], get: Callable[[Reference], Any]) -> None:
        self._sources, self._get = sources, get

    @overload
    def __getitem__(self, index: int) -> Any: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Any]: ...
    def __getitem__(self, index: int | slice) -> Any:
        if isinstance(index, slice):
            return _LazyInputs(self._sources[index], self._get)
        return self._get(self._sources[index])

    def __iter__(self) -> Iterator[Any]:
        return map(self._get, self._sources)

    def __len__(self) -> int:
        return len(self._sources)
