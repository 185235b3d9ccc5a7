"""The transforms that a page shows first: good ones of different things. Ours."""

from __future__ import annotations

from collections.abc import Sequence

from pipeline.report.rows import TransformRow

FIRST = 6
"""How many swing on the first screen: three rows of two on a phone, two of three on a desk (ours)."""


def first_transforms(rows: Sequence[TransformRow]) -> list[TransformRow]:
    """The best `FIRST` of ``rows`` (best first) that can swing, as many different things among them as there are.

    A transform of a class, or without classes of a shape, that is shown already comes after all others; one that lifts
    comes after one that swings flat. Approximate ones, which have no motion, are left out.
    """
    waiting = sorted((row for row in rows if row.swing), key=lambda row: (row.swings_flat is False, row.rank))
    shown: list[TransformRow] = []
    things: set[str] = set()
    while waiting and len(shown) < FIRST:
        best = min(waiting, key=lambda row: sum(name in things for name in _things(row)))
        waiting.remove(best)
        shown.append(best)
        things.update(_things(best))
    return shown


def _things(row: TransformRow) -> tuple[str, str]:
    return row.class_p or row.name_p, row.class_q or row.name_q
