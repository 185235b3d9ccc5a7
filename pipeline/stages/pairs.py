"""The pairs to keep: those that are among the best partners of either shape, each once (ours)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pipeline.stages.qcrs import COLUMNS
from pipeline.stages.specs import Starts
from pipeline.store.artifact import AnyArray, Artifact


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Starts) -> Artifact:
    """Partners of batches within shards → the pairs, ordered by (i, j), positions in the collection with i < j.

    Of every shape the ``k`` best over all shards are kept; among equals the earlier partner. ``compared`` is the sum.
    """
    (count,) = parameters
    parts: dict[str, list[AnyArray]] = {name: [np.empty(0, np.int64)] for name in COLUMNS}
    compared = 0
    for (batch, shard), found in zip(spec.starts, inputs, strict=True):
        compared += int(found.document["compared"])
        for name in COLUMNS:
            parts[name].append(found.arrays[name])
        parts["i"][-1] = parts["i"][-1].astype(np.int64) + batch
        parts["j"][-1] = parts["j"][-1].astype(np.int64) + shard
    rows = {name: np.concatenate(part) for name, part in parts.items()}
    order = np.lexsort((rows["j"], -rows["score"], rows["i"]))
    shape = rows["i"][order]
    order = order[np.arange(len(order)) - np.searchsorted(shape, shape) < count]
    low, high = np.minimum(rows["i"], rows["j"])[order], np.maximum(rows["i"], rows["j"])[order]
    # A pair found from both sides has the same row twice: both were scored from the earlier shape's side.
    pairs, first = np.unique(np.column_stack([low, high]), axis=0, return_index=True)
    types = {"score": np.float64, "n": np.int8, "shift": np.int8}
    kept = {name: rows[name][order][first].astype(types.get(name, np.int32)) for name in COLUMNS}
    kept |= {"i": pairs[:, 0].astype(np.int32), "j": pairs[:, 1].astype(np.int32)}
    return Artifact(kept, {"compared": compared})
