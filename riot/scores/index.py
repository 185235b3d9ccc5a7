"""Index over the trunks of a collection: it finds the best partners of a shape without scoring all pairs (ours).

The trunks of one n of all shapes are gathered into leaves of similar trunks, and leaves into cells. The trunks of a
shape are compared only with cells that are near enough. The limit of that shrinks as good partners are found, which is
early, because the nearest cells come first. The results equal those of scoring every pair, to the last bit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from riot.kernels.bounds import QCRS_LEAF, TILE_LEAVES
from riot.kernels.forest import Forest
from riot.kernels.search import block, partners
from riot.parameters import QcrsParameters
from riot.scores.leaves import gather_leaves
from riot.scores.qcrs import BlockScores, distance_of, scale_of
from riot.scores.ragged import joined, joined_offsets
from riot.scores.trunk_stack import TrunkStack, lay_out_forest, read_only

CELL_LEAVES = 128
"""Leaves of a cell. Ours: any number gives the same result."""

FEW_OTHERS = 2
"""If a shape has no more than so many times as many others as it wants partners, all are scored. Ours: any number gives
the same result."""

OF_TRUNKS = ("starts", "offsets", "edges", "alphas", "betas", "areas")
"""Arrays of the cells that are those of the trunks."""

CELL_ARRAYS = tuple(name for name in Forest._fields if name not in OF_TRUNKS)
"""Arrays of the cells that are stored: to read and check them takes a quarter of the time of laying them out."""


@dataclass(frozen=True, eq=False)
class TrunkIndex:
    """The trunks of a collection, ready for search.

    Parameters
    ----------
    trunks : TrunkStack
        All shapes' trunks.
    cells : Forest
        The same, gathered into cells regardless of their shapes.
    """

    trunks: TrunkStack
    cells: Forest

    def __len__(self) -> int:
        return len(self.trunks)

    @classmethod
    def build(cls, stacks: Sequence[TrunkStack], kinds: npt.NDArray[np.int64] | None = None) -> TrunkIndex:
        """Index the shapes of some stacks, numbered in their order; a cell has shapes of one of the ``kinds``
        (shapes,)."""
        everything = join(stacks)
        del stacks  # what they hold is in there
        of_shapes = np.zeros(len(everything), dtype=np.int64) if kinds is None else kinds
        of_trunks = np.repeat(of_shapes, np.diff(everything.starts))
        leaves = gather_leaves(everything, of_trunks)
        n, kind = np.diff(everything.offsets)[leaves[:, 0]], of_trunks[leaves[:, 0]]
        runs = np.flatnonzero((np.diff(n, prepend=0) != 0) | (np.diff(kind, prepend=-1) != 0))
        first = np.concatenate([np.arange(low, high, CELL_LEAVES) for low, high in _spans(runs, len(n))] + [[len(n)]])
        return cls(everything, lay_out_forest(everything, leaves, first, np.arange(len(first))))

    @cached_property
    def owners(self) -> npt.NDArray[np.int32]:
        """(t,) each trunk's shape."""
        return np.repeat(np.arange(len(self)), np.diff(self.trunks.starts)).astype(np.int32)

    @cached_property
    def crowns(self) -> npt.NDArray[np.float32]:
        """(tiles, 2 features, 32) boxes of the cells, laid out as `riot.kernels.leaves` does those of leaves."""
        cells, first = self.cells, self.cells.leaves[:-1]
        tiles, features = -(-len(first) // TILE_LEAVES), cells.features.shape[1]
        crowns = np.zeros((tiles * TILE_LEAVES, 2 * features), dtype=np.float32)
        if len(first):
            # A cell's leaves lie side by side in its tiles, of which the last may have room left.
            places = np.arange(len(cells.trunks)) + np.repeat(
                TILE_LEAVES * cells.tiles[:-1] - first, np.diff(cells.leaves)
            )
            boxes = cells.boxes.swapaxes(1, 2).reshape(-1, 2 * features)[places]
            crowns[: len(first), 0::2] = np.minimum.reduceat(boxes[:, 0::2], first)
            crowns[: len(first), 1::2] = np.maximum.reduceat(boxes[:, 1::2], first)
        return np.ascontiguousarray(crowns.reshape(tiles, TILE_LEAVES, crowns.shape[1]).swapaxes(1, 2))

    @classmethod
    def array_names(cls) -> tuple[str, ...]:
        """The names of the arrays that `to_arrays` gives."""
        return (*(f"trunks.{field.name}" for field in fields(TrunkStack)), *(f"cells.{name}" for name in CELL_ARRAYS))

    def to_arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Plain arrays by name, for storage."""
        groups = {"trunks": self.trunks.to_arrays(), "cells": self.cells._asdict()}
        return {name: groups[group][array] for name in self.array_names() for group, array in [name.split(".")]}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, npt.NDArray[Any]]) -> TrunkIndex:
        """Undo `to_arrays`; the arrays are not copied, so that they may be those of a mapped file."""
        trunks = TrunkStack.from_arrays({field.name: arrays[f"trunks.{field.name}"] for field in fields(TrunkStack)})
        of_trunks = {name: getattr(trunks, name) for name in OF_TRUNKS}
        return cls(trunks, read_only(Forest(**{name: arrays[f"cells.{name}"] for name in CELL_ARRAYS}, **of_trunks)))


@dataclass(frozen=True, eq=False)
class Partners:
    """The best pairs, best first (ties: i, then j), and the number of pairs that were compared for that.

    ``compared`` counts the pairs of shapes of which the distance of two trunks was computed. ``promising`` (p, 2) are
    the query's trunks, as shape and number, near enough to a trunk of another shape.
    """

    scores: BlockScores
    compared: int
    promising: npt.NDArray[np.int32]


def join(stacks: Sequence[TrunkStack]) -> TrunkStack:
    """The shapes of several stacks as one stack.

    >>> from riot.scores.trunk_stack import stack
    >>> from riot.scores.trunks import quick_trunks
    >>> len(join([stack([quick_trunks(house)]), stack([quick_trunks(kite)])]))
    2
    """
    if len(stacks) == 1:
        return stacks[0]

    return TrunkStack(
        starts=joined_offsets([stack.starts for stack in stacks]),
        offsets=joined_offsets([stack.offsets for stack in stacks]),
        edges=joined(stacks, "edges"),
        alphas=joined(stacks, "alphas"),
        betas=joined(stacks, "betas"),
        areas=joined(stacks, "areas"),
        leaf_starts=joined_offsets([stack.leaf_starts for stack in stacks]),
        leaves=np.concatenate([np.empty((0, QCRS_LEAF), np.int32), *(stack.leaves for stack in stacks)]),
    )


def best_partners(
    index: TrunkIndex,
    query: TrunkStack,
    count: int,
    parameters: QcrsParameters | None = None,
    least: float = 0.0,
    itself: Sequence[int] | None = None,
    margin: float = 1.0,
    earlier: Sequence[int] | None = None,
) -> Partners:
    """For every shape of ``query`` the ``count`` best partners in the index that score above 0 and at least ``least``.

    ``itself`` gives the number of every query shape in the index, which is no partner, or −1. In the
    scores, i numbers the query's shapes and j the index's, and trunk_i and trunk_j are theirs. Exact; among equals the
    first by (j; trunks; shift). ``earlier`` says for every query shape how many shapes of the index come before it, by
    default none: a pair is scored, and trunks and shifts compared, with its earlier shape first. With
    ``parameters.epsilon`` partner number k may score that much less than the true one of this number.
    ``margin`` says how many times as far as the last partner a trunk of another shape may be from a promising one.
    Raises ValueError if ``count`` < 1.

    >>> from riot.scores.trunk_stack import stack
    >>> from riot.scores.trunks import quick_trunks
    >>> both = stack([quick_trunks(house), quick_trunks(kite)])
    >>> best_partners(TrunkIndex.build([both]), both.shape(0), 1, itself=[0]).scores.j.tolist()
    [1]
    """
    if count < 1:
        raise ValueError(f"best_partners({count=}): ask for one partner at least")
    itself = [-1] * len(query) if itself is None else itself
    earlier = [0] * len(query) if earlier is None else earlier
    searches = [
        _search(index, query, i, count, parameters, float(distance_of(least)), itself[i : i + 1], margin, earlier[i])
        for i in range(len(query))
    ]
    promising = [np.stack([np.full_like(near, i), near], axis=1) for i, (_, _, near) in enumerate(searches)]
    return Partners(
        _collect(query, [rows for rows, _, _ in searches]),
        sum(met for _, met, _ in searches),
        np.concatenate([np.empty((0, 2), np.int32), *promising]),
    )


def best_pairs(index: TrunkIndex, count: int, parameters: QcrsParameters | None = None, least: float = 0.0) -> Partners:
    """The ``count`` best pairs i < j of the index that score above 0 and at least ``least``, best first; exact.

    >>> from riot.scores.trunk_stack import stack
    >>> from riot.scores.trunks import quick_trunks
    >>> both = stack([quick_trunks(house), quick_trunks(kite)])
    >>> best = best_pairs(TrunkIndex.build([both]), 1).scores
    >>> best.i.tolist(), best.j.tolist()
    ([0], [1])
    """
    if count < 1:
        raise ValueError(f"best_pairs({count=}): ask for one pair at least")
    limit = float(distance_of(least))
    kept = np.empty((0, 6))
    compared = 0
    for i in range(len(index)):
        rows, met, _ = _search(index, index.trunks, i, count, parameters, limit, range(i + 1))
        compared += met
        kept = np.concatenate([kept, rows])
        kept = kept[np.lexsort((kept[:, 1], kept[:, 0], kept[:, 2]))][:count]
        if len(kept) == count:
            limit = min(limit, float(kept[-1, 2]))
    return Partners(_collect(index.trunks, [kept]), compared, np.empty((0, 2), np.int32))


def _search(
    index: TrunkIndex,
    query: TrunkStack,
    i: int,
    count: int,
    parameters: QcrsParameters | None,
    limit: float,
    not_these: Sequence[int] | range,
    margin: float = 1.0,
    earlier: int = 0,
) -> tuple[npt.NDArray[np.float64], int, npt.NDArray[np.int32]]:
    """(k, 6) i, j, D, T, T', shift of the nearest, nearest first; the number of shapes that were compared; and the
    numbers of the promising trunks of shape i."""
    out = [number for number in not_these if number >= 0]
    if FEW_OTHERS * count >= len(index):
        return _score_all(index, query, i, count, parameters, limit, out, earlier)
    bests = np.full(len(index), np.inf)
    bests[out] = -1.0
    winners = np.full((len(index), 3), -1, dtype=np.int32)
    met = np.zeros(len(index), dtype=np.int32)
    tops = np.full(count, limit)
    trunks = np.full(len(query.areas), np.inf)
    scale = scale_of(query, index.trunks, parameters or QcrsParameters(), margin)
    partners(
        i, query.forest, index.cells, index.owners, earlier, index.crowns, scale, tops, bests, winners, met, trunks
    )
    met[out] = 0
    near = np.flatnonzero((winners[:, 0] >= 0) & (bests <= tops[-1]))
    near = near[np.lexsort((near, bests[near]))][:count]
    own, other = np.where(near < earlier, 1, 0), np.where(near < earlier, 0, 1)
    t, u = winners[near, own] - query.starts[i], winners[near, other] - index.trunks.starts[near]
    rows = np.column_stack([np.full(len(near), i), near, bests[near], t, u, winners[near, 2]])
    of_shape = trunks[query.starts[i] : query.starts[i + 1]]
    promising = np.flatnonzero((of_shape < np.inf) & (of_shape <= margin * tops[-1]))
    return rows.astype(np.float64), int(met.sum()), promising.astype(np.int32)


def _score_all(
    index: TrunkIndex,
    query: TrunkStack,
    i: int,
    count: int,
    parameters: QcrsParameters | None,
    limit: float,
    out: Sequence[int],
    earlier: int,
) -> tuple[npt.NDArray[np.float64], int, npt.NDArray[np.int32]]:
    """As `_search`, by scoring every pair: a search that must find most of the shapes has no limit to prune by."""
    others = np.setdiff1d(np.arange(len(index)), out)
    first = int(np.searchsorted(others, earlier))
    limits, distance, winners = np.full(len(others), limit), np.empty(len(others)), np.empty((len(others), 3), np.int32)
    pairs = np.column_stack([np.full(len(others), i), others]).astype(np.int64)
    settings = parameters or QcrsParameters()
    for part, turned in ((slice(0, first), True), (slice(first, None), False)):
        a, b = (index.trunks, query) if turned else (query, index.trunks)
        along = np.ascontiguousarray(pairs[part, ::-1] if turned else pairs[part])
        block(along, a.forest, b.forest, scale_of(a, b, settings), limits[part], distance[part], winners[part])
    winners[:first, :2] = winners[:first, 1::-1]
    there = np.flatnonzero(winners[:, 0] >= 0)
    near = there[np.lexsort((others[there], distance[there]))][:count]
    rows = np.column_stack([pairs[near], distance[near], winners[near]])
    every = np.arange(query.starts[i + 1] - query.starts[i], dtype=np.int32)
    return rows.astype(np.float64), len(there), every


def _collect(query: TrunkStack, rows: Sequence[npt.NDArray[np.float64]]) -> BlockScores:
    every = np.concatenate([np.empty((0, 6)), *rows])
    i, trunk = every[:, 0].astype(np.int64), every[:, 3].astype(np.int64)
    return BlockScores(
        i=i.astype(np.int32),
        j=every[:, 1].astype(np.int32),
        score=np.exp(-0.5 * every[:, 2] ** 2),
        n=np.diff(query.offsets)[query.starts[i] + trunk].astype(np.int8),
        trunk_i=trunk.astype(np.int32),
        trunk_j=every[:, 4].astype(np.int32),
        shift=every[:, 5].astype(np.int8),
    )


def _spans(starts: npt.NDArray[np.int64], end: int) -> list[tuple[int, int]]:
    return list(zip(starts.tolist(), [*starts[1:].tolist(), end], strict=False))
