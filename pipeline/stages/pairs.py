"""The pairs to keep: each pair of which one shape is among the best partners of the other, once (ours)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.partner_rows import TYPES, best_rows
from pipeline.stages.qcrs import COLUMNS
from pipeline.stages.shards import searches, targets
from pipeline.stages.stage import Stage
from pipeline.store.artifact import AnyArray, Artifact
from pipeline.store.keys import digest_text


@dataclass(frozen=True)
class Starts:
    """For every input, the positions in the collection that its first i and its first j stand for."""

    starts: tuple[tuple[int, int], ...]


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Starts) -> Artifact:
    """Partners of queries within targets → the pairs, ordered by (i, j), positions in the collection with i < j.

    Keeps the ``k`` best partners of every shape over all shards; among equals the earlier one.
    """
    (count,) = parameters
    chunks: dict[str, list[AnyArray]] = {name: [np.empty(0, TYPES.get(name, np.int32))] for name in COLUMNS}
    # A query after the other: what all of them found together need not fit in memory.
    of_query = sorted(range(len(inputs)), key=lambda number: spec.starts[number][0])
    for query, numbers in groupby(of_query, key=lambda number: spec.starts[number][0]):
        found: list[Mapping[str, AnyArray]] = []
        for number in numbers:
            partners = inputs[number]
            found.append({**partners.arrays, "j": partners.arrays["j"] + np.int32(spec.starts[number][1])})
        rows = best_rows({name: np.concatenate([arrays[name] for arrays in found]) for name in COLUMNS}, count)
        rows["i"] += np.int32(query)
        for name in COLUMNS:
            chunks[name].append(rows[name])
    kept = {name: np.concatenate(chunk) for name, chunk in chunks.items()}
    kept |= {"i": np.minimum(kept["i"], kept["j"]), "j": np.maximum(kept["i"], kept["j"])}
    order = np.lexsort((kept["j"], kept["i"]))
    i, j = kept["i"][order], kept["j"][order]
    # A pair that both searches return has two equal rows: both are scored from the earlier shape's side.
    order = order[(np.diff(i, prepend=-1) != 0) | (np.diff(j, prepend=-1) != 0)]
    return Artifact({name: column[order] for name, column in kept.items()})


def items(progress: Progress) -> list[WorkItem]:
    """One work item, which collects the results of all finished searches."""
    recipe = progress.recipes["pairs"]
    first = [shard.members[0] for shard in progress.work["shards"]]
    starts = {"partners": first, "partners_beyond": [first[target[0]] for target in targets(progress)]}
    searches_done = [item for stage in starts for item in progress.finished(stage)]
    spec = Starts(
        tuple((item.members[0], starts[item.stage][item.block[1]]) for item in searches_done if item.block is not None)
    )
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
