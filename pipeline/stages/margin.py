"""How well the two results of a transform are recognised: their margins against the collection (ours)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.collected import Collected
from pipeline.stages.shape_arrays import ErrorRow, attempt
from pipeline.stages.stage import Column, Stage, TableColumns
from pipeline.store.artifact import Artifact
from riot import scores
from riot.types import FloatArray, IntArray

if TYPE_CHECKING:
    from riot.scores.likeness import Margin


@dataclass(frozen=True)
class Things:
    """The shapes of a collection; groups and names are of those in the index."""

    collected: Collected
    groups: IntArray
    names: tuple[str, ...]


def prepare(artifact: Artifact) -> Things | Artifact:
    """The shapes of a collection; a construction as it is."""
    if "positions" not in artifact.arrays:
        return artifact
    count = int(artifact.arrays["positions"].max(initial=-1)) + 1
    collected = Collected.of(artifact.arrays, count)
    return Things(collected, np.asarray(artifact.arrays["group"]), tuple(artifact.document["names"]))


def run(inputs: Sequence[Any], parameters: Sequence[Any], spec: tuple[int, int]) -> Artifact:
    """A construction and the collection → a document: surprise, margins of both results, nearest others."""
    constructed, things = inputs
    (settings,) = parameters
    errors: list[ErrorRow] = []
    i, j = np.array(spec)[:, None]
    row: dict[str, Any] = {"surprise": float(things.collected.surprise(i, j, mirrored=settings.mirrored)[0])}
    for side, position in (("p", spec[0]), ("q", spec[1])):
        outline = np.asarray(constructed.arrays[f"outline_{side}"])
        margin = attempt(0, lambda o=outline, k=position: _margin(o, k, things, settings.mirrored), errors)  # type: ignore[misc]
        if margin is not None and margin.nearest >= 0:
            # A result that equals another thing is mistaken for it however far it is from its input.
            row[f"margin_{side}"] = margin.value if math.isfinite(margin.value) else None
            row[f"other_{side}"] = things.names[margin.nearest]
            row[f"recognised_{side}"] = margin.recognised
    return Artifact({}, {**row, "errors": errors})


def _margin(outline: FloatArray, position: int, things: Things, mirrored: bool) -> Margin:
    number, index = int(things.collected.number[position]), things.collected.index
    described = scores.descriptor.outline_descriptor(outline)
    return scores.likeness.margin(described, number, index, things.groups, mirrored=mirrored)


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each construction that has a transform, in order."""
    recipe, collections = progress.recipes["margin"], progress.finished("near_duplicates")
    return [
        recipe.item(
            recipe.parts([item.key, collection.key], item.members),
            [item.reference, collection.reference],
            spec=item.members,
            members=item.members,
        )
        for collection in collections
        for item in progress.finished("construct")
        if "riot" in progress.read(item).document
    ]


def _row(artifact: Artifact) -> Mapping[str, Any]:
    row = {name: value for name, value in artifact.document.items() if name != "errors"}
    margins = [margin for margin in (row.get("margin_p"), row.get("margin_q")) if margin is not None]
    return row | {"margin": min(margins) if len(margins) == 2 else None}


MARGIN = "1 − its distance to its input / to the nearest other thing of the collection; ≤ 0 = mistaken, null = no other"
OTHER = "name of the nearest shape of another class, or of another cluster of near-duplicates without classes"
RECOGNISED = "whether the nearest shape but its input is the same thing; null = no other"

STAGE = Stage(
    name="margin",
    unit="transforms",
    after=("construct", "near_duplicates"),
    parameters=("likeness",),
    items=items,
    run=run,
    scope="pair",
    prepare=prepare,
    known_after="construct",
    at_most=lambda config: config.select.constructed,
    bundle=32,
    tables=(
        TableColumns(
            "transforms",
            (
                Column("margin", "float64", "how well both results are recognised: the lesser of the two margins", "1"),
                Column("margin_p", "float64", f"of P: {MARGIN}", "1"),
                Column("margin_q", "float64", f"of Q: {MARGIN}", "1"),
                Column("other_p", "string", f"of P: {OTHER}"),
                Column("other_q", "string", f"of Q: {OTHER}"),
                Column("recognised_p", "bool", f"of P: {RECOGNISED}"),
                Column("recognised_q", "bool", f"of Q: {RECOGNISED}"),
                Column("surprise", "float64", "how much the two inputs differ, in descriptor and elongation", "1"),
            ),
            _row,
        ),
    ),
)
