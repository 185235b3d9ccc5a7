"""Parts of the work between two batches, or between a query and shards: what is halved to find a deadly pair."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Any

Span = tuple[int, int]
"""First number, and the one after the last."""


@dataclass(frozen=True)
class Sides:
    """The sides of a block: so many of its inputs are batches of ``rows``, and after them so many of ``columns``.

    Without columns it is the block of a group with itself.
    """

    rows: int
    columns: int

    @property
    def same(self) -> bool:
        """Whether both sides are the same."""
        return self.columns == 0

    @property
    def numbers(self) -> tuple[range, range]:
        """Numbers of the inputs of either side."""
        rows = range(self.rows)
        return rows, rows if self.same else range(self.rows, self.rows + self.columns)


@dataclass(frozen=True)
class SubBlock:
    """Some rows and columns of a block of pairs; ``whole`` is the spec of the work item that they are taken from.

    Rows and columns are numbered within their sides. Where these are the same, only pairs with row < column count. A
    search for partners has its shards as a single column.

    >>> list(SubBlock(Sides(1, 0), (0, 3), (0, 3)).pairs())
    [(0, 1), (0, 2), (1, 2)]
    """

    whole: Any
    rows: Span
    columns: Span

    def pairs(self) -> Iterator[tuple[int, int]]:
        """(row, column) of all its pairs, in order."""
        same = isinstance(self.whole, Sides) and self.whole.same
        for row in range(*self.rows):
            for column in range(*self.columns):
                if row < column or not same:
                    yield row, column

    def halves(self) -> list[SubBlock]:
        """Two to four sub-blocks that have all of its pairs, each once; none where it has one pair only."""
        if len(list(islice(self.pairs(), 2))) < 2:
            return []
        quarters = (
            SubBlock(self.whole, rows, columns) for rows in _halves(self.rows) for columns in _halves(self.columns)
        )
        # Rows after all columns have no pairs: half of a batch with an earlier half of the same.
        return [quarter for quarter in quarters if any(quarter.pairs())]


def _halves(span: Span) -> list[Span]:
    low, high = span
    if high - low < 2:
        return [span]
    middle = (low + high) // 2
    return [(low, middle), (middle, high)]
