"""Choosing many different pairs that are worth much: a submodular cover, by the greedy algorithm (ours).

The value of a set of pairs is the sum, over all groups, of the worth of the group's pairs, the best whole, the second
by `AGAIN`, the third by its square, and so on. A group is a class, a cluster of near-duplicates, or two classes: what a
pair shows. This value is monotone and submodular, since what is shown already makes a pair gain less and never more.
Hence the greedy choice of k pairs is worth at least 1 − 1/e of the best choice (Nemhauser, Wolsey, Fisher: "An analysis
of approximations for maximizing submodular set functions", 1978).
"""

from __future__ import annotations

import heapq
from bisect import insort
from collections import defaultdict
from collections.abc import Hashable, Sequence

import numpy as np

from riot.types import FloatArray, IntArray

AGAIN = 0.5
"""What the worth of a pair counts for in a group that has a better one already (ours)."""

Groups = Sequence[Sequence[Hashable]]
"""The groups of each pair."""


def cover_value(worth: Sequence[float], groups: Groups) -> float:
    """The value of a set of pairs, of which ``worth`` and ``groups`` are.

    >>> cover_value([0.8, 0.6], [("bird", "cup"), ("bird", "key")])
    2.5
    """
    shown: dict[Hashable, list[float]] = defaultdict(list)
    for value, of_pair in zip(worth, groups, strict=True):
        for group in of_pair:
            shown[group].append(value)
    return sum(_discounted(sorted(-value for value in values)) for values in shown.values())


def _discounted(falling: Sequence[float]) -> float:
    """The discounted sum of values, given without their signs' turn: the greatest first, each times −1."""
    return -sum(value * AGAIN**place for place, value in enumerate(falling))


def greedy_cover(worth: FloatArray, groups: Groups, count: int) -> list[int]:
    """Rows of ``count`` pairs of worth above 0, in the order of the greedy choice; ties go to the earlier row.

    Each next pair is the one that adds most to `cover_value`.

    >>> greedy_cover(np.array([0.9, 0.8, 0.5]), [("bird", "cup"), ("bird", "cup"), ("dog", "key")], 2)
    [0, 2]
    """
    shown: dict[Hashable, list[float]] = defaultdict(list)

    def gain(row: int) -> float:
        return sum(_gain(shown[group], -float(worth[row])) for group in groups[row])

    # What a pair would add falls as the set grows: an earlier gain bounds it from above (lazy greedy, Minoux 1978).
    waiting = [(-gain(row), row) for row in np.flatnonzero(worth > 0).tolist()]
    heapq.heapify(waiting)
    chosen: list[int] = []
    while waiting and len(chosen) < count:
        _, row = heapq.heappop(waiting)
        current = (-gain(row), row)
        if waiting and current > waiting[0]:
            heapq.heappush(waiting, current)
            continue
        chosen.append(row)
        for group in groups[row]:
            insort(shown[group], -float(worth[row]))
    return chosen


def _gain(falling: list[float], value: float) -> float:
    longer = falling.copy()
    insort(longer, value)
    return _discounted(longer) - _discounted(falling)


def groups_of(pairs: IntArray, classes: Sequence[str], cluster: IntArray) -> list[tuple[Hashable, ...]]:
    """What each pair (k, 2) of positions shows: two classes, each alone and together, and two clusters.

    A shape without a class stands for its cluster alone.
    """
    groups: list[tuple[Hashable, ...]] = []
    for i, j in pairs.tolist():
        clusters = sorted((int(cluster[i]), int(cluster[j])))
        named = sorted({classes[i], classes[j]} - {""})
        groups.append((*clusters, *named, *([tuple(named)] if len(named) == 2 else [])))
    return groups
