"""What older searches have of new ones, when some shapes of a collection are added, changed or gone (ours).

A shape is the same if its picture is, by digest, and what reads pictures and makes trunks. Older queries and shards are
followed to their pictures through the manifests in the store.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np

from pipeline.plan.work_item import Reference, WorkItem
from pipeline.runtime.older import entry_or_none, inputs_and_spec, older_and_missing
from pipeline.stages.reused_search import AddedShape, OlderSearch, ReusedGroup, ReusingSearch
from pipeline.stages.search_spec import Search, ShardPosition
from pipeline.store.artifact import canonical_json
from pipeline.store.keys import digest_text
from pipeline.store.store import Entry, Store
from riot.types import IntArray

MOST_ADDED = 128
"""Added shapes, at most, that are all scored: more would take as long as a search for all (by their cost, ours)."""

FEW_NEW = 4
"""New shapes of a query, at most, that are scored with all others batch by batch: that takes less than to read the
index for them (by the cost of one, ours)."""


def with_older_searches(store: Store, work: Sequence[WorkItem]) -> list[WorkItem]:
    """The work items of a stage of searches, in which those that the store lacks read what older ones have of them.

    Only exact searches: in the approximate mode, and with ``qcrs.epsilon``, a row depends on what else is searched.
    """
    settings, _, mode = work[0].parameters
    if mode != "topk" or settings.epsilon > 0.0:
        return list(work)
    older, missing = older_and_missing(store, work)
    if not (older and missing):
        return list(work)
    plan = _Plan(store, work[0], older)
    wanted = {item.key for item in missing}
    return [plan.reusing(item) if item.key in wanted else item for item in work]


def in_order(numbers: Sequence[int]) -> list[int]:
    """Indices of a longest ascending subsequence.

    >>> in_order([5, 1, 2, 9, 3])
    [1, 2, 4]
    """
    lasts: list[int] = []
    at: list[int] = []
    before: list[int] = []
    for index, number in enumerate(numbers):
        length = bisect_left(lasts, number)
        lasts[length : length + 1], at[length : length + 1] = [number], [index]
        before.append(at[length - 1] if length else -1)
    chain = at[-1:]
    while chain and before[chain[-1]] >= 0:
        chain.append(before[chain[-1]])
    return chain[::-1]


class _Member(NamedTuple):
    """A shape of shards: what it is, its number in them, its batch and place there, and whether the query comes after
    it."""

    name: str
    j: int
    batch: str
    place: int
    after: bool


@dataclass(frozen=True)
class _Target:
    """Keys of shards, and how a query lies to them. Where it is in the shard, ``first`` is left out: 0."""

    shards: tuple[str, ...]
    positions: tuple[ShardPosition, ...]


@dataclass(frozen=True)
class _Asked:
    """What a search asks: its query's shapes, the number of the first in its own shard or −1, and where it looks."""

    names: tuple[str, ...]
    lengths: tuple[int, ...]
    first: int
    target: _Target


class _Plan:
    """What the older searches of a stage know, and which of them a search reads."""

    def __init__(self, store: Store, like: WorkItem, older: Sequence[str]) -> None:
        self._store = store
        self._names, self._members = cache(self._read_names), cache(self._read_members)
        self._numbers, self._cover = cache(self._match), cache(self._choose)
        self._older: list[tuple[Reference, _Asked]] = []
        self._known: dict[str, dict[int, int]] = defaultdict(dict)
        """Of each shape: the older searches that know it, and its number in their queries."""
        for key in older:
            inputs, spec = inputs_and_spec(store, key, like.parts)
            if spec.keys() != {"batches", "shards"}:
                continue
            positions = tuple(ShardPosition(**position) for position in spec["shards"])
            asked = self._asked(inputs, Search(spec["batches"], positions))
            if asked is not None:
                for i, name in enumerate(asked.names):
                    self._known[name][len(self._older)] = i
                self._older.append(((like.stage, key), asked))

    def reusing(self, item: WorkItem) -> WorkItem:
        """The work item, which reads what older ones have of it."""
        asked = self._asked(item.parts.inputs, item.spec)
        if asked is None:
            return item
        numbers: dict[Reference, int] = {source: k for k, source in reversed(list(enumerate(item.sources)))}
        groups: list[ReusedGroup] = []
        of_older: dict[tuple[int, ...], list[int]] = defaultdict(list)
        for i, name in enumerate(asked.names):
            of_older[tuple(self._known.get(name, ()))].append(i)
        for older, shapes in of_older.items():
            group = self._group(older, shapes, asked, numbers)
            if group is not None:
                groups.append(group)
        if not groups:
            return item
        new = of_older.get((), [])
        if 0 < len(new) <= FEW_NEW:
            everything = range(len(self._members(asked.target)))
            groups.append(ReusedGroup(tuple(new), (), self._added(everything, asked, numbers)))
        spec = ReusingSearch(item.spec, len(item.parts.inputs), asked.lengths, tuple(groups))
        more = [source for source, number in numbers.items() if number >= len(item.sources)]
        return replace(item, sources=(*item.sources, *more), spec=spec)

    def _group(
        self, older: tuple[int, ...], shapes: Sequence[int], asked: _Asked, numbers: dict[Reference, int]
    ) -> ReusedGroup | None:
        """What some shapes of a query take from ``older`` searches; ``numbers`` grows by what is to be read for it."""
        chosen, left = self._cover(tuple(self._older[number][1].target for number in older), asked.target)
        if not chosen or len(left) > MOST_ADDED:
            return None
        pieces: list[OlderSearch] = []
        for choice in chosen:
            reference, before = self._older[older[choice]]
            j = self._numbers(before.target, asked.target)
            here = np.full(len(before.names), -1)
            for i in shapes:
                there = self._known[asked.names[i]][older[choice]]
                # In its own shard a shape must have kept its place among the others.
                if asked.first < 0 or j[before.first + there] == asked.first + i:
                    here[there] = i
            pieces.append(OlderSearch(numbers.setdefault(reference, len(numbers)), here, j))
        return ReusedGroup(tuple(shapes), tuple(pieces), self._added(left, asked, numbers))

    def _added(self, indices: Iterable[int], asked: _Asked, numbers: dict[Reference, int]) -> tuple[AddedShape, ...]:
        """Shapes of the target, by their indices there."""
        members = self._members(asked.target)
        return tuple(
            AddedShape(numbers.setdefault(("trunks", batch), len(numbers)), place, j, after)
            for _, j, batch, place, after in (members[index] for index in indices)
        )

    def _asked(self, inputs: Sequence[str], search: Search) -> _Asked | None:
        """What a search asks; None if a manifest that says what shapes there are cannot be read any more."""
        shards = tuple(inputs[search.batches : search.batches + len(search.shards)])
        target = _Target(shards, tuple(replace(position, first=0) for position in search.shards))
        try:
            batches = [self._names(key) for key in inputs[: search.batches]]
            self._members(target)
        except LookupError:
            return None
        names = tuple(name for names in batches for name in names)
        return _Asked(names, tuple(map(len, batches)), search.shards[0].first, target)

    def _read_names(self, batch: str) -> list[str]:
        """What the shapes of a batch are: their pictures, and what made trunks of them."""
        trunks = self._entry("trunks", batch)
        ingest = self._entry("ingest", trunks.parts["inputs"][0])
        made = digest_text(canonical_json([{**entry.parts, "inputs": []} for entry in (trunks, ingest)]))
        return [f"{made} {picture}" for picture in ingest.parts["inputs"]]

    def _read_members(self, target: _Target) -> list[_Member]:
        """The shapes of shards, in order."""
        members: list[_Member] = []
        for key, position in zip(target.shards, target.positions, strict=True):
            batches = self._entry("shards", key).parts["inputs"]
            places = [(name, batch, k) for batch in batches for k, name in enumerate(self._names(batch))]
            for number, (name, batch, place) in enumerate(places, start=position.start):
                members.append(_Member(name, number, batch, place, position.after))
        return members

    def _entry(self, stage: str, key: str) -> Entry:
        entry = entry_or_none(self._store, stage, key)
        if entry is None:
            raise LookupError(f"{stage}/{key[:12]}")
        return entry

    def _match(self, old: _Target, new: _Target) -> IntArray:
        """The number in the ``new`` target of each number in the old one; −1 where that shape is not there, or does not
        come before and after the same shapes."""
        here = {(member.name, member.after): member.j for member in self._members(new)}
        before = self._members(old)
        pairs = [(member.j, here[name]) for member in before if (name := (member.name, member.after)) in here]
        numbers = np.full(before[-1].j + 1, -1)
        for index in in_order([j for _, j in pairs]):
            numbers[pairs[index][0]] = pairs[index][1]
        return numbers

    def _choose(self, older: tuple[_Target, ...], new: _Target) -> tuple[list[int], list[int]]:
        """Which of the older targets have most shapes of a new one, and the indices of the shapes that none has."""
        left = {member.j: k for k, member in enumerate(self._members(new))}
        chosen: list[int] = []
        while older:
            found = [set(self._numbers(old, new).tolist()) & left.keys() for old in older]
            best = max(range(len(older)), key=lambda k: len(found[k]))
            if not found[best]:
                break
            chosen.append(best)
            left = {j: k for j, k in left.items() if j not in found[best]}
        return chosen, list(left.values())
