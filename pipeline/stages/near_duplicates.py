"""The descriptors of a collection as one index, its near-duplicates, and what counts as another thing (ours)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.stage import Stage
from pipeline.store.artifact import AnyArray, Artifact
from pipeline.store.keys import digest_text
from riot import scores


@dataclass(frozen=True)
class Described:
    """Names and classes of the collection by position, and the position of the first shape of each input."""

    names: tuple[str, ...]
    classes: tuple[str, ...]
    starts: tuple[int, ...]


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Described) -> Artifact:
    """Descriptors of batches → ``positions`` (d,) ascending, ``cluster``, ``group``, ``elongation``, ``perimeter``, and
    the index.

    ``cluster`` is the first position of a cluster of near-duplicates. Shapes of one group are one thing: shapes of a
    class, or those of a cluster that have no class.
    """
    (settings,) = parameters
    names = ("elongation", "perimeter", *scores.likeness.DescriptorIndex.array_names())
    arrays: dict[str, AnyArray] = {name: np.concatenate([batch.arrays[name] for batch in inputs]) for name in names}
    described = [
        np.flatnonzero(batch.arrays["described"]) + start for batch, start in zip(inputs, spec.starts, strict=True)
    ]
    positions = np.concatenate(described)
    index = scores.likeness.DescriptorIndex.from_arrays(arrays)
    first = scores.likeness.near_duplicates(index, settings.near_duplicate, mirrored=settings.mirrored)
    cluster = positions[first]
    things: dict[str, int] = {}
    group = [
        things.setdefault(spec.classes[position] or f"\0{number}", len(things))
        for position, number in zip(positions.tolist(), cluster.tolist(), strict=True)
    ]
    columns = {"positions": positions, "cluster": cluster, "group": np.array(group, dtype=np.int64)}
    return Artifact({**columns, **arrays}, {"names": [spec.names[position] for position in positions.tolist()]})


def items(progress: Progress) -> list[WorkItem]:
    """One work item over the batches that are described; none without any."""
    recipe, described = progress.recipes["near_duplicates"], progress.finished("likeness")
    if not described:
        return []
    names = tuple(item.name for item in progress.items)
    spec = Described(names, progress.classes, tuple(item.members[0] for item in described))
    # A digest instead of the spec keeps names and classes out of the manifest.
    parts = recipe.parts([item.key for item in described], digest_text(repr(spec)))
    return [recipe.item(parts, [item.reference for item in described], spec=spec)]


STAGE = Stage(
    name="near_duplicates",
    unit="collection of shapes",
    after=("likeness",),
    parameters=("likeness",),
    items=items,
    run=run,
    scope="collection",
)
