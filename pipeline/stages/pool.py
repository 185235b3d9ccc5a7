"""The pool of policy ``varied``: the pairs that go on to CRS and refined trunks, by shape and by n too (ours).

QCRS orders pairs of one shape and of one n well, and badly those of different ones: a single list by QCRS is filled by
blobs with trunks of four vertices. What a transform loses lies along the outlines, so that the partners of a shape are
ordered by their perimeters, too.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from riot.types import BoolArray, FloatArray, IntArray


class Rows(NamedTuple):
    """Rows of candidates: i, j (positions in the collection, i < j), score, and the number n of trunk vertices."""

    i: IntArray
    j: IntArray
    score: FloatArray
    n: IntArray

    def at(self, rows: IntArray | BoolArray) -> Rows:
        """Some of the rows."""
        return Rows(self.i[rows], self.j[rows], self.score[rows], self.n[rows])

    @property
    def size(self) -> IntArray:
        """The place of n in `SIZES`."""
        return np.asarray(np.minimum(self.n, SIZES[-1]) - SIZES[0])

    @staticmethod
    def joined(parts: Sequence[Rows]) -> Rows:
        """The rows of several parts."""
        return Rows(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


SIZES = (3, 4, 5, 6)
"""Each n that has a share of the pool; more vertices count as the last."""

PARTNERS = 8
"""Best partners of a shape that are held for each n. Ours: two of three exact pairs are among the first two."""

BY_CLASS = 6
"""Pairs of a round that go by class. Ours: with fewer a run shows fewer classes, with more it misses exact pairs."""

PER_LENGTH = 0.1
"""QCRS that a unit of both perimeters weighs, of shapes of unit area. Ours, by a fit on 2,174 pairs of MPEG-7: within a
class, IoU after bending ranks like QCRS with Spearman .56, less the perimeters' weight with .74."""

CHUNK = 250_000
"""Rows that are read before the best are kept: of 32 bytes each, and some 100 while they are sorted."""


def fill_pool(blocks: Iterable[Rows], cluster: IntArray, label: IntArray, perimeter: FloatArray, size: int) -> IntArray:
    """(k, 2) the pairs of a pool of ``size``, in the order in which they entered it, read from ``blocks`` in any order.

    In a round, for each n one list gives a pair, the best by score, and one those whose shapes stand highest among each
    other's partners. Over every n, a list that begins with each class's most promising pair gives `BY_CLASS`, and one
    that begins with each shape's gives one. A pair promises its score less `PER_LENGTH` of both ``perimeter``
    (positions,). Shapes of a class have one number in ``label`` (positions,), near-duplicates in ``cluster``.

    >>> block = Rows(np.array([0, 0]), np.array([1, 2]), np.array([0.9, 0.8]), np.array([4, 3]))
    >>> fill_pool(iter([block]), np.arange(3), np.arange(3), np.full(3, 4.0), 1).tolist()
    [[0, 2]]
    """
    shape = np.arange(len(cluster))
    held = best_rows(blocks, len(cluster), size)
    by_size = [np.flatnonzero(held.size == k) for k in range(len(SIZES))]
    best = [iter(rows[_by_score(held.at(rows))].tolist()) for rows in by_size]
    mutual = [iter(rows[_by_rank(held.at(rows), shape, np.maximum)].tolist()) for rows in by_size]
    promise = held._replace(score=held.score - PER_LENGTH * (perimeter[held.i] + perimeter[held.j]))
    of_class = [iter(_by_rank(promise, label, np.minimum).tolist())] * BY_CLASS
    of_shape = [iter(_by_rank(promise, cluster, np.minimum).tolist())]
    taken: dict[tuple[int, int], None] = {}
    before = -1
    while before < len(taken) < size:
        before = len(taken)
        for queue in (*best, *mutual, *of_class, *of_shape):
            for row in queue:
                pair = int(held.i[row]), int(held.j[row])
                if pair not in taken:
                    taken[pair] = None
                    break
    return np.array(list(taken)[:size], dtype=np.int64).reshape(-1, 2)


def _by_score(rows: Rows) -> IntArray:
    return np.lexsort((rows.j, rows.i, -rows.score))


def _by_rank(rows: Rows, shape: IntArray, join: np.ufunc) -> IntArray:
    """Order of rows, over every n, by the ``join`` of their ranks among the partners of both shapes, then by score."""
    any_size = rows._replace(n=np.full_like(rows.n, SIZES[0]))
    best = _best_of_shapes(any_size, shape)
    rank = join(*_ranks(any_size.at(best), shape))
    i, j, score, _ = rows.at(best)
    return np.asarray(best[np.lexsort((j, i, -score, rank))])


def best_rows(blocks: Iterable[Rows], shapes: int, count: int) -> Rows:
    """Of all rows, the ``count`` best of each n and the `PARTNERS` best of each shape and n; they need no order.

    Shapes are numbered below ``shapes``. The best rows of several parts are those of the parts' own: what is not among
    the best of a part is not among those of all.
    """
    none = np.empty(0, np.int64)
    rows, waiting = Rows(none, none, np.empty(0), none), 0
    parts = [rows]
    least, floors = np.zeros(len(SIZES)), np.zeros((len(SIZES), shapes))
    for block in blocks:
        size, score = block.size, block.score
        # Neither among the best of its n nor among the partners of a shape: it cannot enter.
        enters = (score >= least[size]) | (score >= floors[size, block.i]) | (score >= floors[size, block.j])
        parts.append(block.at(enters))
        waiting += len(parts[-1].n)
        if waiting > CHUNK:
            rows, least, floors = _trimmed(Rows.joined(parts), shapes, count)
            parts, waiting = [rows], 0
    return _trimmed(Rows.joined(parts), shapes, count)[0]


def _trimmed(rows: Rows, shapes: int, count: int) -> tuple[Rows, FloatArray, FloatArray]:
    """The rows that may enter, best first; the least score among the best of each n, and of each n and shape."""
    pair = rows.i * shapes + rows.j
    rows = rows.at(np.lexsort((pair, -rows.score)))
    pair = rows.i * shapes + rows.j
    _, once = np.unique(pair * len(SIZES) + rows.size, return_index=True)
    rows = rows.at(np.sort(once))
    least, floors = np.zeros(len(SIZES)), np.zeros((len(SIZES), shapes))
    place = _place(rows.size)
    last = place == count - 1
    least[rows.size[last]] = rows.score[last]
    sides = np.column_stack([rows.i, rows.j])
    rank = _place((sides * len(SIZES) + rows.size[:, None]).ravel()).reshape(-1, 2)
    row, side = np.nonzero(rank == PARTNERS - 1)
    floors[rows.size[row], sides[row, side]] = rows.score[row]
    return rows.at((place < count) | (rank.min(axis=1, initial=PARTNERS) < PARTNERS)), least, floors


def _place(groups: IntArray) -> IntArray:
    """The place, from 0, of each entry among those of its group, in their order."""
    order = np.argsort(groups, kind="stable")
    place = np.arange(len(order))
    first = np.where(_changes(groups[order]), place, 0)
    place[order] = place - np.maximum.accumulate(first)
    return place


def _best_of_shapes(rows: Rows, shape: IntArray) -> IntArray:
    """The rows that are the best of their two shapes, or clusters, and n."""
    a, b = np.minimum(shape[rows.i], shape[rows.j]), np.maximum(shape[rows.i], shape[rows.j])
    order = np.lexsort((rows.j, rows.i, -rows.score, b, a, rows.size))
    return np.sort(order[_changes(rows.size[order], a[order], b[order])])


def _ranks(rows: Rows, shape: IntArray) -> tuple[IntArray, IntArray]:
    """Ranks, from 0, of each row among the rows of its n with the shape of i, and with that of j."""
    twice = np.tile(np.arange(len(rows.n)), 2)
    i, j, score, _ = rows.at(twice)
    owner, size = shape[np.concatenate([rows.i, rows.j])], rows.size[twice]
    order = np.lexsort((j, i, -score, owner, size))
    first = _changes(size[order], owner[order])
    place = np.arange(len(order))
    rank = np.empty(len(order), np.int64)
    rank[order] = place - np.maximum.accumulate(np.where(first, place, 0))
    return rank[: len(rows.n)], rank[len(rows.n) :]


def _changes(*columns: IntArray) -> BoolArray:
    """Where any of the columns differs from the entry before; true of the first entry."""
    changes = np.ones(len(columns[0]), dtype=np.bool_)
    changes[1:] = np.any([column[1:] != column[:-1] for column in columns], axis=0)
    return changes
