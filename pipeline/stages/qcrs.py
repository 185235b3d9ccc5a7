"""Quick cross-reversibility scores of one block: all pairs of two batches, or of one with itself, or a part of them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from pipeline.plan.part import Part
from pipeline.stages.trunk_arrays import unpack_batch_trunks
from pipeline.store.artifact import Artifact
from riot.scores.qcrs import BlockScores, TrunkStack, score_block, score_pairs, stack

COLUMNS = ("i", "j", "score", "n", "trunk_i", "trunk_j", "shift")


def prepare(batch: Artifact) -> TrunkStack:
    """Trunks of a batch as the scores read them, made once for all its blocks of a task."""
    starts, leaves = batch.arrays["leaf_offsets"].tolist(), np.array(batch.arrays["leaves"])
    return stack(unpack_batch_trunks(batch), [leaves[a:b] for a, b in pairwise(starts)])


def run(inputs: Sequence[TrunkStack], parameters: Sequence[Any], spec: bool | Part) -> Artifact:
    """Stacks of one batch (``spec``: with itself) or of two → a row for each pair, i and j local to their batches."""
    (settings,) = parameters
    stacks = list(inputs)
    if isinstance(spec, Part):
        return _rows(score_pairs(stacks[0], stacks[-1], np.array(list(spec.pairs()), dtype=np.int64), settings))
    return _rows(score_block(stacks[0], stacks[-1], settings, same=spec))


def join(parts: Sequence[Artifact], lost: Sequence[Part]) -> Artifact:
    """What `run` makes of a block, from all its parts but those that were ``lost``: for their pairs see `unknown`."""
    found = [*(part.arrays for part in parts), *(unknown(list(part.pairs())).arrays for part in lost)]
    rows = {name: np.concatenate([arrays[name] for arrays in found]) for name in COLUMNS}
    order = np.lexsort((rows["j"], rows["i"]))
    return Artifact({name: column[order] for name, column in rows.items()})


def unknown(pairs: Sequence[tuple[int, int]]) -> Artifact:
    """Rows of pairs that could not be scored: score nan; n, trunks and shift −1."""
    i, j = np.array(pairs, dtype=np.int32).reshape(-1, 2).T
    small, large = np.full(len(pairs), -1, dtype=np.int8), np.full(len(pairs), -1, dtype=np.int32)
    return _rows(BlockScores(i, j, np.full(len(pairs), np.nan), small, large, large, small))


def _rows(scores: BlockScores) -> Artifact:
    return Artifact({name: np.asarray(getattr(scores, name)) for name in COLUMNS})
