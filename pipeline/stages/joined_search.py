"""The best partners of all shapes of a query in several shards, one after the other: each narrows the next (ours)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.stages.partner_rows import best_rows
from pipeline.stages.qcrs import COLUMNS
from pipeline.store.artifact import AnyArray, Artifact
from riot import scores
from riot.parameters import QcrsParameters
from riot.types import FloatArray, IntArray

if TYPE_CHECKING:
    from riot.scores.index import TrunkIndex
    from riot.scores.trunk_stack import TrunkStack

NARROWED = 0.85
"""The queries are laid out anew once they look less far than so many times as when that was done last, in the median.
Ours: any number gives the same result."""


def known_distances(i: IntArray, score: FloatArray, shapes: int, count: int) -> FloatArray:
    """(shapes, count) the distances of the partners that shapes have already, ascending; inf where there are fewer.

    ``i`` ascends, and each i's scores descend.

    >>> known_distances(np.array([0, 0, 2]), np.array([1.0, 0.5, 0.5]), 3, 1).round(3).tolist()
    [[0.0], [inf], [1.177]]
    """
    distances = np.full((shapes, count), np.inf)
    rank = np.arange(len(i)) - np.searchsorted(i, i)
    kept = rank < count
    distances[i[kept], rank[kept]] = scores.qcrs.distance_of(score[kept])
    return distances


def promising_only(query: TrunkStack, few: Mapping[int, IntArray]) -> tuple[TrunkStack, IntArray]:
    """The query with only those trunks of the shapes in ``few``, and (t,) the number of each trunk within its shape."""
    kept = np.ones(len(query.areas), dtype=bool)
    for shape, trunks in few.items():
        kept[query.starts[shape] : query.starts[shape + 1]] = False
        kept[query.starts[shape] + trunks] = True
    number = np.arange(len(query.areas)) - np.repeat(query.starts[:-1], np.diff(query.starts))
    return (query if kept.all() else scores.trunk_stack.of_trunks(query, kept)), number[kept]


def search_shards(
    query: TrunkStack,
    shards: Iterable[tuple[TrunkIndex, bool, int]],
    known: FloatArray,
    settings: QcrsParameters,
    numbers: IntArray,
) -> Artifact:
    """The best partners of every shape of a query, as rows of `pipeline.stages.partners`, of all shards together.

    Of each shard its index, whether the query comes after it, and the number of its first shape in the rows. ``known``
    (shapes, k) are distances of partners elsewhere: what is worse than the last may be missing. ``numbers`` are those
    of the query's trunks within their shapes, of which it may lack some.
    """
    tops, laid_out, found = known, None, []
    reached = np.full(len(query), np.inf)
    for index, after, start in shards:
        with np.errstate(invalid="ignore"):
            narrowed = np.median(np.nan_to_num(tops[:, -1] / reached, nan=1.0)) if len(query) else 1.0
        if laid_out is None or narrowed < NARROWED:
            laid_out, reached = scores.knn_join.lay_out_queries(query, tops), tops[:, -1]
        earlier = np.full(len(query), len(index) * after, dtype=np.int64)
        joined = scores.knn_join.join_partners(index, laid_out, tops, settings, earlier)
        tops = joined.tops
        columns: dict[str, AnyArray] = {name: getattr(joined.scores, name) for name in COLUMNS}
        columns["trunk_i"] = numbers[query.starts[columns["i"]] + columns["trunk_i"]]
        if after:
            columns["trunk_i"], columns["trunk_j"] = columns["trunk_j"], columns["trunk_i"]
        found.append({**columns, "j": columns["j"] + np.int32(start)})
    together: dict[str, Any] = {
        name: np.concatenate([np.empty(0), *(rows[name] for rows in found)]) for name in COLUMNS
    }
    best = best_rows(together, known.shape[1])
    return Artifact({**best, "promising": np.empty((0, 2), np.int32)})
