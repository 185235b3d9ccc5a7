"""What a search for partners asks: which shapes, in which parts of the index, and how many partners (ours)."""

from __future__ import annotations

from dataclasses import dataclass

from riot.parameters import QcrsParameters


@dataclass(frozen=True)
class ShardPosition:
    """How a query lies to a shard: ``first`` is the number of its first shape in the shard, −1 if it is not in it;
    ``after`` says whether it comes after the shard in the collection. The rows number the shard's shapes from ``start``
    on."""

    first: int
    after: bool
    start: int = 0

    def earlier(self, i: int, shapes: int) -> int:
        """How many of the shard's ``shapes`` come before shape i of the query."""
        return self.first + i if self.first >= 0 else shapes * self.after


@dataclass(frozen=True)
class Search:
    """What the inputs of a search are: so many ``batches``, whose shapes are the query, and then ``shards``."""

    batches: int
    shards: tuple[ShardPosition, ...]


@dataclass(frozen=True)
class Wanted:
    """How many partners of a shape are wanted, how they are scored, and the margin of promising trunks."""

    count: int
    settings: QcrsParameters
    margin: float = 1.0
