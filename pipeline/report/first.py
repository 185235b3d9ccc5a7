"""The transforms that a page shows first: good ones of different things. Ours."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pipeline.report.rows import TransformRow

FIRST = 6
"""How many swing on the first screen: three rows of two on a phone, two of three on a desk (ours)."""


def first_transforms(rows: Sequence[TransformRow]) -> list[TransformRow]:
    """Up to `FIRST` of ``rows`` that can swing, of as many different things as there are.

    What is taken next has the fewest things that are shown already (a thing is a class, or a shape without one) or of a
    class with a number in its name, such as "device3", since nobody can see whether a device 3 looks like one; among
    those it swings flat; and then surprise times margin counts: one thing becomes quite
    another, and both are recognised. Without surprise and margin the rank counts. Approximate transforms, which have no
    motion, are left out.
    """
    waiting = [row for row in rows if row.swing]
    shown: list[TransformRow] = []
    things: set[str] = set()
    while waiting and len(shown) < FIRST:
        best = min(
            waiting,
            key=lambda row: (
                len(_things(row) & things) + _numbered(row),
                row.swings_flat is False,
                -_worth(row),
                row.rank,
            ),
        )
        waiting.remove(best)
        shown.append(best)
        things |= _things(best)
    return shown


def _things(row: TransformRow) -> set[str]:
    return {row.class_p or row.name_p, row.class_q or row.name_q}


def _numbered(row: TransformRow) -> int:
    return sum(any(map(str.isdigit, kind)) for kind in (row.class_p, row.class_q))


def _worth(row: TransformRow) -> float:
    worth = row.surprise * max(row.margin, 0.0)
    return worth if math.isfinite(worth) else 0.0
