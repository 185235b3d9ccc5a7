"""Work items, of which each makes an artifact, and recipes, which make the work items of a stage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from pipeline.store.keys import KeyParts, SharedText, canonical_value

Reference = tuple[str, str]
"""(stage, key) of an artifact."""

Pair = tuple[int, int]
"""Positions of two items in the collection, the smaller first; or numbers of two groups of batches, of two spans of
groups, or of a query and a target."""


@dataclass(frozen=True)
class WorkItem:
    """A piece of work that makes an artifact.

    ``sources`` are the artifacts that it reads; ``spec`` is the third argument of its stage's ``run``. ``members`` are
    the positions of the collection's items that it concerns: all of a batch or query, two of a pair, none of a block
    between groups (`Progress.members` has them). ``block`` numbers the two groups, or the query and the target, between
    which it lies; ``pairs`` is how many pairs of shapes lie there.
    """

    parts: KeyParts
    parameters: tuple[Any, ...]
    sources: tuple[Reference, ...]
    spec: Any
    members: tuple[int, ...]
    block: Pair | None = None
    pairs: int = 0

    @property
    def stage(self) -> str:
        """Name of its stage."""
        return self.parts.stage

    @cached_property
    def key(self) -> str:
        """Its content key."""
        return self.parts.key()

    @property
    def reference(self) -> Reference:
        """(stage, key)."""
        return self.stage, self.key


@dataclass(frozen=True)
class Recipe:
    """What all work items of a stage share: parameters, and digests of code. It does not change during a run."""

    stage: str
    parameters: tuple[Any, ...]
    values: dict[str, Any]
    """The parameters as plain values, by name, as they enter keys."""
    code: dict[str, str]
    versions: dict[str, str]

    def parts(self, inputs: Sequence[str], spec: Any = None) -> KeyParts:
        """The parts of a work item's key; ``spec`` is what the work depends on besides its inputs, as plain values."""
        if spec is None:
            return KeyParts(self.stage, self.values, tuple(inputs), self.code, self.versions, shared=self._shared)
        values = {**self.values, "item": canonical_value(spec)}
        return KeyParts(self.stage, values, tuple(inputs), self.code, self.versions)

    def item(
        self,
        parts: KeyParts,
        sources: Sequence[Reference] = (),
        *,
        spec: Any = None,
        members: Sequence[int] = (),
        block: Pair | None = None,
        pairs: int = 0,
    ) -> WorkItem:
        """A work item whose key has these parts."""
        return WorkItem(parts, self.parameters, tuple(sources), spec, tuple(members), block, pairs)

    def after(self, earlier: WorkItem) -> WorkItem:
        """The work item that reads only the artifact of an ``earlier`` one, with the same members."""
        return self.item(self.parts([earlier.key]), [earlier.reference], members=earlier.members)

    @cached_property
    def _shared(self) -> SharedText:
        return SharedText.of(KeyParts(self.stage, self.values, (), self.code, self.versions))
