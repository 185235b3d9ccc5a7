"""What the work items of a task read: each input once, kept while it is wanted again and there is room."""

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

ROOM = 160 * 2**20
"""Bytes of the artifacts whose prepared forms a worker keeps; the forms take about twice as many."""

Prepare = Callable[[Artifact], Any]


class Kept:
    """Prepared inputs of one stage that a worker keeps, from one task to the next where the stage works in tiles.

    They are named by content and take a bounded number of bytes, so that what is kept changes no result. A task of
    another stage lets all of them go.
    """

    def __init__(self, room: int = ROOM) -> None:
        self._room, self._stage, self._size = room, "", 0
        self._held: dict[Reference, tuple[Any, int]] = {}
        self._lock = threading.Lock()  # a worker of an external cluster may have several threads

    @property
    def size(self) -> int:
        """Bytes of the artifacts whose prepared forms are kept."""
        return self._size

    def begin(self, stage: str) -> None:
        """Let go of another stage's inputs."""
        with self._lock:
            if stage != self._stage:
                self._held.clear()
                self._stage, self._size = stage, 0

    def get(self, source: Reference) -> Any:
        """A kept input; None when it is not kept."""
        with self._lock:
            found = self._held.pop(source, None)
            if found is None:
                return None
            self._held[source] = found  # now the last that was used
            return found[0]

    def keep(self, source: Reference, prepared: Any, size: int, wanted: Callable[[Reference], float]) -> None:
        """Keep an input; without room those go that are ``wanted`` last, of equal ones the one used longest ago."""
        with self._lock:
            if source in self._held:
                return
            self._held[source] = prepared, size
            self._size += size
            while self._size > self._room:
                last = max(self._held, key=wanted)
                self._size -= self._held.pop(last)[1]

    def drop(self, source: Reference) -> None:
        """Let go of one input."""
        with self._lock:
            self._size -= self._held.pop(source, (None, 0))[1]


class Inputs:
    """Prepared inputs of the work items of one task, which are worked on in order: what it will read is known."""

    def __init__(self, store: Store, items: Sequence[WorkItem], kept: Kept) -> None:
        self._store, self._kept = store, kept
        self._uses: dict[Reference, list[int]] = defaultdict(list)
        for place, item in enumerate(items):
            for source in item.sources:
                self._uses[source].append(place)

    def of(self, place: int, item: WorkItem, prepare: Prepare) -> Sequence[Any]:
        """The prepared inputs of the item at ``place``, each read when it is asked for.

        Asking raises KeyError when an input is absent, `pipeline.errors.PayloadError` when it is corrupt.
        """
        self._kept.begin(item.stage)
        lasting = BY_NAME[item.stage].tile > 0
        return _Asked(item.sources, lambda source: self._get(source, place, prepare, lasting))

    def _get(self, source: Reference, place: int, prepare: Prepare, lasting: bool) -> Any:
        again = lasting or self._next(source, place) < math.inf
        prepared = self._kept.get(source)
        if prepared is None:
            artifact = self._store.get(*source)
            prepared = prepare(artifact)
            if again:
                size = sum(array.nbytes for array in artifact.arrays.values())
                self._kept.keep(source, prepared, size, lambda kept: self._next(kept, place))
        elif not again:
            self._kept.drop(source)
        return prepared

    def _next(self, source: Reference, place: int) -> float:
        """The first item after ``place`` that reads a source; infinity when there is none."""
        uses = self._uses.get(source, [])
        at = bisect_right(uses, place)
        return uses[at] if at < len(uses) else math.inf


class _Asked(Sequence[Any]):
    """Inputs that are read when they are asked for: a selection has more of them than may be held at once."""

    def __init__(self, sources: Sequence[Reference], get: Callable[[Reference], Any]) -> None:
        self._sources, self._get = sources, get

    @overload
    def __getitem__(self, index: int) -> Any: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Any]: ...
    def __getitem__(self, index: int | slice) -> Any:
        if isinstance(index, slice):
            return _Asked(self._sources[index], self._get)
        return self._get(self._sources[index])

    def __iter__(self) -> Iterator[Any]:
        return map(self._get, self._sources)

    def __len__(self) -> int:
        return len(self._sources)
