"""Policies of the selection that take the best pairs of one list: ``paper`` (paper §5.3) and ``global`` (ours)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from riot.types import BoolArray, FloatArray, IntArray

Block = tuple[IntArray, IntArray, FloatArray]
"""Pairs: i, j (i < j) and score."""


class Chosen(NamedTuple):
    """Selected pairs, best first: ``pairs`` (p, 2) int64, positions i < j in the collection, ``score`` (p,) float64."""

    pairs: IntArray
    score: FloatArray


FIRST_POOL = 50_000
"""Best pairs in the first pool, of 24 bytes each; the limits seldom need more (measured on MPEG-7)."""

GROWTH = 8
"""Factor by which the pool grows if they do: a few readings, and a pool not much larger than needed (ours)."""


@dataclass(frozen=True)
class SelectionLimits:
    """The greatest numbers of pairs: in all, of the same two classes, and with the same shape."""

    top: int
    per_class_pair: int
    per_shape: int


def best_of_classes(classes: Sequence[str], scores: FloatArray) -> BoolArray:
    """(positions,) the shape of best reversibility ``scores`` (nan = none) of each class.

    A shape of class "" is a class of its own. Ties go to the earlier shape.

    >>> best_of_classes(["cup", "cup", ""], np.array([0.2, 0.4, 0.1])).tolist()
    [False, True, True]
    """
    best: dict[str, int] = {}
    for position, name in enumerate(classes):
        if np.isnan(scores[position]):
            continue
        group = name or f"\0{position}"
        if group not in best or scores[position] > scores[best[group]]:
            best[group] = position
    chosen = np.zeros(len(classes), dtype=np.bool_)
    chosen[list(best.values())] = True
    return chosen


def select_best(blocks: Iterable[Block], top: int) -> Chosen:
    """The best pairs."""
    pool, _ = best_pairs(blocks, first_pool(top))
    return _rows(pool, np.arange(min(top, len(pool[2]))))


def select_global(
    blocks: Callable[[int], tuple[Iterable[Block], bool]], label: IntArray, limits: SelectionLimits
) -> Chosen:
    """The best pairs within the limits, greedily by falling score; ``label`` (positions,) numbers the classes.

    Ties go to the earlier pair. ``blocks`` starts the reading of the best pairs anew, at least so many, and says
    whether there may be more: only a pool of them is held, and a larger one is read when the limits use up the first.
    """
    size = first_pool(limits.top)
    while True:
        read, cut = blocks(size)
        pool, more = best_pairs(read, size)
        rows = greedy(pool[0], pool[1], label, limits)
        if len(rows) == limits.top or not (cut or more):
            return _rows(pool, np.array(rows, dtype=np.int64))
        size *= GROWTH


def first_pool(top: int) -> int:
    """Pairs that are held at first to select ``top`` of them."""
    return max(FIRST_POOL, top)


def _rows(pool: Block, rows: IntArray) -> Chosen:
    i, j, score = pool
    return Chosen(np.column_stack([i[rows], j[rows]]), score[rows])


def labels(classes: Sequence[str]) -> IntArray:
    """A number for every class, by position; class "" differs from every class, itself too."""
    numbers: dict[str, int] = {}
    label = [numbers.setdefault(name or f"\0{position}", len(numbers)) for position, name in enumerate(classes)]
    return np.array(label, dtype=np.int64)


def greedy(i: IntArray, j: IntArray, label: IntArray, limits: SelectionLimits) -> list[int]:
    """Take pairs (p,), the best first, as long as the limits allow; returns the rows of those taken."""
    shapes: Counter[int] = Counter()
    class_pairs: Counter[tuple[int, int]] = Counter()
    chosen: list[int] = []
    for row, (first, second) in enumerate(zip(i.tolist(), j.tolist(), strict=True)):
        low, high = sorted((int(label[first]), int(label[second])))
        if class_pairs[low, high] >= limits.per_class_pair:
            continue
        if max(shapes[first], shapes[second]) >= limits.per_shape:
            continue
        class_pairs[low, high] += 1
        shapes[first] += 1
        shapes[second] += 1
        chosen.append(row)
        if len(chosen) == limits.top:
            break
    return chosen


def best_pairs(blocks: Iterable[Block], limit: int) -> tuple[Block, bool]:
    """The ``limit`` best pairs, best first; and whether there are more."""
    none = np.empty(0, np.int64)
    held: list[Block] = [(none, none, np.empty(0))]
    count, least, cut = 0, 0.0, False
    for i, j, score in blocks:
        # A pair below the last of a full pool cannot enter it; at an equal score the order of pairs decides.
        mask = score >= least
        held.append((i[mask], j[mask], score[mask]))
        count += len(held[-1][2])
        if count > 2 * limit:
            held, cut = [_best(held, limit)], True
            count, least = limit, float(held[0][2][-1])
    cut = cut or count > limit
    return _best(held, limit), cut


def _best(held: Sequence[Block], limit: int) -> Block:
    i, j = (np.concatenate([block[side] for block in held]) for side in (0, 1))
    score = np.concatenate([block[2] for block in held])
    order = np.lexsort((j, i, -score))[:limit]
    return i[order], j[order], score[order]
