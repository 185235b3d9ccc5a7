"""Quick cross-reversibility scores of one block: all pairs of two batches, or of one with itself."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from pipeline.artifact import Artifact
from pipeline.work.trunk_arrays import unpack_batch_trunks
from riot.quick import TrunkStack, score_block, stack

COLUMNS = ("i", "j", "score", "n", "trunk_i", "trunk_j", "shift")


def prepare(batch: Artifact) -> TrunkStack:
    """Trunks of a batch as the scores read them, made once for all its blocks of a task."""
    starts, leaves = batch.arrays["leaf_offsets"].tolist(), np.array(batch.arrays["leaves"])
    return stack(unpack_batch_trunks(batch), [leaves[a:b] for a, b in pairwise(starts)])


def run(inputs: Sequence[TrunkStack], parameters: Sequence[Any], spec: bool) -> Artifact:
    """Stacks of one batch (``spec``: with itself) or of two → a row for each pair, i and j local to their batches."""
    (settings,) = parameters
    stacks = list(inputs)
    scores = score_block(stacks[0], stacks[-1], settings, same=spec)
    return Artifact({name: np.asarray(getattr(scores, name)) for name in COLUMNS})
