"""The pairs to keep: each pair of which one shape is among the best partners of the other, once (ours)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.partners import TYPES
from pipeline.stages.qcrs import COLUMNS
from pipeline.stages.shards import searches
from pipeline.stages.stage import Stage
from pipeline.store.artifact import AnyArray, Artifact
from pipeline.store.keys import digest_text


@dataclass(frozen=True)
class Starts:
    """For every input, the positions in the collection of the first shape of its batch and of its shard."""

    starts: tuple[tuple[int, int], ...]


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Starts) -> Artifact:
    """Partners of batches within shards → the pairs, ordered by (i, j), positions in the collection with i < j.

    Keeps the ``k`` best partners of every shape over all shards; among equals the earlier one. ``compared`` is the sum
    of the inputs'.
    """
    (count,) = parameters
    chunks: dict[str, list[AnyArray]] = {name: [np.empty(0, np.int64)] for name in COLUMNS}
    compared = 0
    for (batch, shard), partners in zip(spec.starts, inputs, strict=True):
        compared += int(partners.document["compared"])
        for name in COLUMNS:
            chunks[name].append(partners.arrays[name])
        chunks["i"][-1] = chunks["i"][-1].astype(np.int64) + batch
        chunks["j"][-1] = chunks["j"][-1].astype(np.int64) + shard
    rows = {name: np.concatenate(chunk) for name, chunk in chunks.items()}
    order = np.lexsort((rows["j"], -rows["score"], rows["i"]))
    shape = rows["i"][order]
    order = order[np.arange(len(order)) - np.searchsorted(shape, shape) < count]
    low, high = np.minimum(rows["i"], rows["j"])[order], np.maximum(rows["i"], rows["j"])[order]
    # A pair that both searches return has two equal rows: both are scored from the earlier shape's side.
    pairs, first = np.unique(np.column_stack([low, high]), axis=0, return_index=True)
    kept = {name: rows[name][order][first].astype(TYPES.get(name, np.int32)) for name in COLUMNS}
    kept |= {"i": pairs[:, 0].astype(np.int32), "j": pairs[:, 1].astype(np.int32)}
    return Artifact(kept, {"compared": compared})


def items(progress: Progress) -> list[WorkItem]:
    """One work item, which collects the results of all finished searches."""
    recipe = progress.recipes["pairs"]
    searches_done = [*progress.finished("partners"), *progress.finished("partners_beyond")]
    shards = progress.work["shards"]
    blocks = [item.block for item in searches_done if item.block is not None]
    spec = Starts(tuple((progress.batches[b].start, shards[s].members[0]) for b, s in blocks))
    parts = recipe.parts([item.key for item in searches_done], digest_text(repr(spec)))
    return [recipe.item(parts, [item.reference for item in searches_done], spec=spec)]


STAGE = Stage(
    name="pairs",
    unit="collection of pairs",
    after=("partners_beyond",),
    parameters=("qcrs.k",),
    items=items,
    run=run,
    scope="collection",
    wanted=searches,
    here=True,
)
