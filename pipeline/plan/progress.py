"""The state of a run as it goes through its stages: the collection, and the work items of each planned stage."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace
from functools import cached_property

from pipeline.config.schema import Config
from pipeline.datasets.collection import Collection
from pipeline.datasets.item import Item
from pipeline.plan.batches import SPREAD, batches_in_a_group, cut, spans_of_groups
from pipeline.plan.work_item import Recipe, Reference, WorkItem
from pipeline.store.artifact import Artifact


@dataclass(frozen=True)
class Progress:
    """What a stage can read when it plans its work. It is immutable; `with_work` returns the next state.

    Keys are chained: a work item names its inputs by their keys. Therefore all work up to the selection is planned from
    the configuration and the digests of the pictures alone; later stages ``read`` the results of earlier ones.
    """

    config: Config
    collection: Collection
    batches: tuple[range, ...]
    """Positions of the collection's items, cut into batches."""
    recipes: Mapping[str, Recipe]
    read: Callable[[WorkItem], Artifact]
    """The artifact of a work item that is done."""
    work: Mapping[str, tuple[WorkItem, ...]] = field(default_factory=dict)
    """Work items by stage, of the stages that were planned so far."""
    done: AbstractSet[Reference] = frozenset()
    lost: Mapping[str, tuple[WorkItem, ...]] = field(default_factory=dict)
    """Parts of failed blocks that failed alone, too, by stage."""

    @property
    def items(self) -> tuple[Item, ...]:
        """The items of the collection, in order of name."""
        return self.collection.items

    @cached_property
    def classes(self) -> tuple[str, ...]:
        """The class of every item; empty for none."""
        return tuple(item.cls for item in self.items)

    @cached_property
    def groups(self) -> tuple[range, ...]:
        """Numbers of the batches of each group: a block of pairs is between two groups, or of one with itself.

        Groups are cut by content, as batches are.
        """
        mean = batches_in_a_group(len(self.batches), self.config.batch)
        return tuple(cut([self._content(batch) for batch in self.batches], mean, SPREAD))

    @cached_property
    def spans(self) -> Sequence[Sequence[range]]:
        """Numbers of the groups of each span, level by level; rare blocks lie between spans of the first level."""
        return spans_of_groups([self._content(self.of_group(number)) for number in range(len(self.groups))])

    def _content(self, positions: range) -> str:
        return "".join(item.digest for item in self.items[positions.start : positions.stop])

    def of_group(self, number: int) -> range:
        """Positions of the items of a group."""
        return self.of_span(range(number, number + 1))

    def of_span(self, groups: range) -> range:
        """Positions of the items of neighbouring groups."""
        first, last = self.groups[groups.start], self.groups[groups.stop - 1]
        return range(self.batches[first.start].start, self.batches[last.stop - 1].stop)

    def of_side(self, stage: str, number: int) -> range:
        """Positions of the items on a side of a block: of a group, or, in a rare block, of a span of groups."""
        return self.of_span(self.spans[0][number]) if stage == "qcrs_rare" else self.of_group(number)

    def members(self, item: WorkItem) -> Sequence[int]:
        """The positions that a work item concerns; those of a block between groups, which are many, are in no item."""
        if item.members or item.block is None:
            return item.members
        a, b = (self.of_side(item.stage, number) for number in item.block)
        return a if a == b else [*a, *b]

    def locate(self, position: int) -> tuple[int, int]:
        """(batch, index within it) of an item; raises LookupError for a position that no item has."""
        if not 0 <= position < len(self.items):
            raise LookupError(f"no item {position} in a collection of {len(self.items)}")
        number = bisect_right(self.batches, position, key=lambda batch: batch.start) - 1
        return number, position - self.batches[number].start

    def finished(self, stage: str) -> list[WorkItem]:
        """The finished work items of a stage, in order; empty if the stage is not planned."""
        return [item for item in self.work.get(stage, ()) if item.reference in self.done]

    def with_work(
        self, stage: str, items: Sequence[WorkItem], done: AbstractSet[Reference], lost: Sequence[WorkItem] = ()
    ) -> Progress:
        """The state after one more stage; ``done`` are all artifacts that are in the store by now."""
        return replace(
            self,
            work={**self.work, stage: tuple(items)},
            done=done,
            lost={**self.lost, stage: tuple(lost)} if lost else self.lost,
        )

    def alone(self, position: int) -> Progress:
        """The state before the first stage, with a single batch of a single item."""
        return replace(self, batches=(range(position, position + 1),), work={}, lost={})


def begin(
    config: Config, collection: Collection, recipes: Mapping[str, Recipe], read: Callable[[WorkItem], Artifact]
) -> Progress:
    """A run before its first stage; ``collection.items`` are in canonical order."""
    batches = cut([item.digest for item in collection.items], config.batch)
    return Progress(config, collection, tuple(batches), recipes, read)
