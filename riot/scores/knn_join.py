"""The best partners of many shapes in an index at once (ours): a search for each of them finds the same, more slowly.

A query knows some partners already, which say how far its trunks look. Trunks that look as far are gathered together:
one that looks farther would make all that lie beside it look in vain.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from riot.kernels.knn_join import SAME_SCORE, Cells, Found, join
from riot.parameters import QcrsParameters
from riot.scores.index import TrunkIndex
from riot.scores.qcrs import BlockScores, scale_of
from riot.scores.trunk_stack import TrunkStack
from riot.types import FloatArray, IntArray

REACH_RATIO = 1.25
"""Trunks of a cell of queries look so many times as far as one another at most. Ours: any number gives the same
result."""

NEAREST = 1e-3
"""Distances below count as equal in that. Ours: any number gives the same result."""


@dataclass(frozen=True, eq=False)
class JoinedPartners:
    """Pairs that may be among the best of their query, by (i, j); i numbers the queries, j the shapes of the index, and
    trunk_i and trunk_j are theirs. ``tops`` (q, k) are the least distances of every query so far, ascending."""

    scores: BlockScores
    tops: FloatArray


def lay_out_queries(queries: TrunkStack, tops: FloatArray) -> TrunkIndex:
    """The queries' trunks in cells, ready for a join, by how far they look: as the last of ``tops`` (q, k) says.

    Any ``tops`` give the same result, those at hand the quickest join.
    """
    reach = np.maximum(tops[:, -1], NEAREST)
    finite = np.isfinite(reach)
    kinds = np.zeros(len(reach), dtype=np.int64)
    kinds[finite] = np.floor(np.log(reach[finite] / NEAREST) / np.log(REACH_RATIO)).astype(np.int64)
    kinds[~finite] = kinds.max(initial=0) + 1
    return TrunkIndex.build([queries], kinds)


def join_partners(
    index: TrunkIndex,
    queries: TrunkIndex,
    tops: FloatArray,
    parameters: QcrsParameters | None = None,
    earlier: IntArray | None = None,
) -> JoinedPartners:
    """The partners of every query in the index that may be among its k best, where ``tops`` (q, k) are the distances of
    the best elsewhere, ascending, inf where there are fewer.

    A query's k best scores, elsewhere and here, are all among those and these; a pair here that scores like the last
    one is there, too. ``earlier`` (q,) says how many shapes of the index come before a query in a pair, by default
    none.

    >>> from riot.scores.trunk_stack import stack
    >>> from riot.scores.trunks import quick_trunks
    >>> houses, kites = stack([quick_trunks(house)]), stack([quick_trunks(kite)])
    >>> nothing = np.full((1, 1), np.inf)
    >>> join_partners(TrunkIndex.build([kites]), lay_out_queries(houses, nothing), nothing).scores.score.round(3)
    array([0.991])
    """
    shape = (len(queries), len(index))
    scale = scale_of(queries.trunks, index.trunks, parameters or QcrsParameters())
    earlier = np.zeros(len(queries), dtype=np.int64) if earlier is None else earlier
    found = Found(tops.copy(), np.full(shape, np.inf), np.full((*shape, 3), -1, dtype=np.int32))
    here, there = (Cells(side.cells, side.crowns, side.owners) for side in (queries, index))
    join(here, there, scale, earlier, found)
    near = (found.winners[:, :, 0] >= 0) & (found.bests <= found.tops[:, -1:] + SAME_SCORE * scale.slack)
    i, j = np.nonzero(near)
    one, two, shift = found.winners[i, j].T
    turned = j < earlier[i]
    own = np.where(turned, two, one) - queries.trunks.starts[i]
    other = np.where(turned, one, two) - index.trunks.starts[j]
    return JoinedPartners(
        BlockScores(
            i=i.astype(np.int32),
            j=j.astype(np.int32),
            score=np.exp(-0.5 * found.bests[i, j] ** 2),
            n=np.diff(queries.trunks.offsets)[queries.trunks.starts[i] + own].astype(np.int8),
            trunk_i=own.astype(np.int32),
            trunk_j=other.astype(np.int32),
            shift=shift.astype(np.int8),
        ),
        found.tops,
    )
