"""A table of a few rows, as lines of text. Ours."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

GAP = "  "
"""What stands between two columns."""


@dataclass(frozen=True)
class Table:
    """Rows of text below a title and the names of the columns; the last ``totals`` rows stand below a rule.

    Columns that are named in ``left`` are flush left, the others flush right.
    """

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    title: str = ""
    left: Sequence[str] = ()
    totals: int = 0

    def lines(self) -> Iterator[str]:
        """The table, a line a row.

        >>> list(Table(["stage", "MB"], [["crs", "12.5"]], left=["stage"]).lines())
        ['stage    MB', '─────  ────', 'crs    12.5']
        """
        widths = [max(map(_width, column)) for column in zip(self.columns, *self.rows, strict=True)]
        rule = GAP.join("─" * width for width in widths)
        if self.title:
            yield self.title
        yield self._line(self.columns, widths)
        yield rule
        for number, row in enumerate(self.rows):
            if self.totals and number == len(self.rows) - self.totals:
                yield rule
            yield self._line(row, widths)

    def _line(self, row: Sequence[str], widths: Sequence[int]) -> str:
        cells = []
        for name, cell, width in zip(self.columns, row, widths, strict=True):
            space = " " * (width - _width(cell))
            cells.append(cell + space if name in self.left else space + cell)
        return GAP.join(cells).rstrip()


def _width(text: str) -> int:
    """Columns that a text takes on a terminal: two for a wide character, none for one that goes onto another."""
    return sum(
        0 if unicodedata.combining(character) else 1 + (unicodedata.east_asian_width(character) in "WF")
        for character in text
    )
