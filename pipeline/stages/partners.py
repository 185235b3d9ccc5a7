"""The best partners of every shape of a batch within one shard, each scored as its pair is scored anywhere (ours)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pipeline.plan.part import Part
from pipeline.stages.qcrs import COLUMNS
from pipeline.stages.qcrs import prepare as stack_of_batch
from pipeline.stages.shards import is_shard, unpack
from pipeline.stages.specs import Place
from pipeline.store.artifact import Artifact
from riot.parameters import QcrsParameters
from riot.scores.index import Partners, TrunkIndex, best_partners
from riot.scores.index import join as join_stacks
from riot.scores.qcrs import BlockScores, TrunkStack, score_pairs
from riot.types import IntArray

ROUNDING = 1e-9
"""By less than this share of it a score differs between the two directions of its pair, whose sums run differently."""

FAIR = 0.25
"""Partners below this score are looked for pair by pair: the index knows no shape's own nearest, and hardly prunes."""

_TYPES = {"score": np.float64, "n": np.int8, "shift": np.int8}


def prepare(artifact: Artifact) -> TrunkStack | TrunkIndex:
    """Trunks of a batch as the scores read them, or a shard's index: made once for many work items."""
    return unpack(artifact) if is_shard(artifact) else stack_of_batch(artifact)


def run(inputs: Sequence[Any], parameters: Sequence[Any], spec: Place | Part) -> Artifact:
    """Stack of a batch and index of a shard → rows (i in the batch, j in the shard), each i's best first.

    A `Part` of the work is that of some rows i.

    Only scores above 0 count; among equals the earlier j comes first. ``trunk_i``, ``trunk_j`` and ``shift`` are of the
    pair with its earlier shape first, whichever of the two was looked up. ``compared`` of the document counts the pairs
    of which two trunks were compared corner by corner.
    """
    settings, count = parameters
    query, index = inputs
    place, rows = (spec.whole, spec.rows) if isinstance(spec, Part) else (spec, (0, len(query)))
    scores, compared = find(query, index, count, settings, place, range(*rows))
    return Artifact({name: np.asarray(getattr(scores, name)) for name in COLUMNS}, {"compared": compared})


def join(parts: Sequence[Artifact], lost: Sequence[Part]) -> Artifact:
    """What `run` makes of a batch, from all its parts, in any order; those that were ``lost`` have no rows."""
    empty = {name: np.empty(0, _TYPES.get(name, np.int32)) for name in COLUMNS}
    found = [empty, *(part.arrays for part in parts)]
    rows = {name: np.concatenate([arrays[name] for arrays in found]) for name in COLUMNS}
    order = np.argsort(rows["i"], kind="stable")  # all of one i are in one part, the best first
    compared = sum(int(part.document["compared"]) for part in parts)
    return Artifact({name: column[order] for name, column in rows.items()}, {"compared": compared})


def find(
    query: TrunkStack, index: TrunkIndex, count: int, settings: QcrsParameters, place: Place, rows: range
) -> tuple[BlockScores, int]:
    """Rows of shapes of the query as `run` says, and the number of pairs compared."""
    own = [place.first + i if place.first >= 0 else -1 for i in range(len(query))]
    # A copy, whose forest goes with it: as long as the index is kept there is no room for both.
    whole = replace(index.trunks)
    found = [_nearest(query.shape(i), index, whole, count, settings, own[i]) for i in rows]
    i = np.repeat(rows, [len(one.scores.j) for one in found]).astype(np.int32)
    columns = {name: np.concatenate([np.empty(0, np.int32), *(getattr(each.scores, name) for each in found)])
               for name in COLUMNS} | {"i": i}  # fmt: skip
    earlier = columns["j"] < np.array([*own, 0])[i] if place.first >= 0 else np.full(len(i), place.after)
    _turn(query, index, columns, np.flatnonzero(earlier), settings)
    order = np.lexsort((columns["j"], -columns["score"], i))
    rank = np.arange(len(i)) - np.searchsorted(i, i)  # i ascends, before and after
    order = order[(rank < count) & (columns["score"][order] > 0)]
    scores = BlockScores(**{name: columns[name][order].astype(_TYPES.get(name, np.int32)) for name in COLUMNS})
    return scores, sum(each.compared for each in found)


def _nearest(
    one: TrunkStack, index: TrunkIndex, whole: TrunkStack, count: int, settings: QcrsParameters, own: int
) -> Partners:
    """The best partners of one shape and as many more as it takes to be sure of them in either direction."""
    asked = count + 1
    while asked < len(index) and len(one.areas):
        found = best_partners(index, one, asked, settings, FAIR, [own])
        score = found.scores.score
        if len(score) < asked:
            break
        if score[-1] < score[count - 1] * (1 - ROUNDING):
            return found
        asked *= 2
    return _all(one, whole, settings, own)


def _all(one: TrunkStack, whole: TrunkStack, settings: QcrsParameters, own: int) -> Partners:
    """All partners of one shape, pair by pair: what is sooner when there is no near one to tell the far ones by."""
    others = np.flatnonzero((np.arange(len(whole)) != own) & (len(one.areas) > 0))
    scores = score_pairs(one, whole, np.column_stack([np.zeros_like(others), others]), settings)
    return Partners(scores, int((scores.n > 0).sum()))


def _turn(
    query: TrunkStack, index: TrunkIndex, columns: dict[str, Any], rows: IntArray, settings: QcrsParameters
) -> None:
    """Score pairs whose shape of the shard is the earlier one anew, from its side."""
    if len(rows) == 0:
        return
    numbers, place = np.unique(columns["j"][rows], return_inverse=True)
    first = join_stacks([index.trunks.shape(int(j)) for j in numbers])
    pairs = np.column_stack([place, columns["i"][rows]]).astype(np.int64)
    again = score_pairs(first, query, pairs, settings, columns["score"][rows] * (1 - ROUNDING))
    for name in ("score", "n", "trunk_i", "trunk_j", "shift"):
        columns[name][rows] = getattr(again, name)
