"""The choice, by policy ``varied``: of the pairs constructed, many different ones that are recognised well (ours).

Motion, textures and fabrication follow for the chosen alone. The other policies choose all that they construct.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.collected import Collected
from pipeline.stages.construct import certified, least_deformed
from pipeline.stages.cover import EVERY_THING, greedy_cover, groups_of
from pipeline.stages.stage import Stage
from pipeline.store.artifact import Artifact
from pipeline.store.keys import digest_text
from riot.parameters import LikenessParameters
from riot.types import IntArray

if TYPE_CHECKING:
    from pipeline.config.selection import SelectConfig


UNRECOGNISED = 0.25
"""What the margin of a pair counts for of which one result would be taken for another thing. Ours."""


@dataclass(frozen=True)
class Constructed:
    """What the choice reads: classes by position, and the pair of positions of each construction.

    The inputs are the constructions, their margins, with ``select.flat`` their motions, and, if it is ``described``,
    the collection. ``margins`` and ``motions`` number the constructions that have one.
    """

    classes: tuple[str, ...]
    pairs: tuple[tuple[int, int], ...]
    margins: tuple[int, ...]
    motions: tuple[int, ...]
    described: bool


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Constructed) -> Artifact:
    """The inputs that `Constructed` lists → ``positions`` (k,) of the chosen among the constructions, best first."""
    settings, likeness = parameters
    count = len(spec.pairs)
    rows = [{**artifact.document} for artifact in inputs[:count]]
    for number, artifact in zip((*spec.margins, *spec.motions), inputs[count:], strict=False):
        rows[number] |= artifact.document
    collected = Collected.of(inputs[-1].arrays if spec.described else {}, len(spec.classes))
    pairs = np.array(spec.pairs, dtype=np.int64).reshape(-1, 2)
    return Artifact({"positions": choose(rows, pairs, spec.classes, collected, settings, likeness)})


def choose(
    rows: Sequence[Mapping[str, Any]],
    pairs: IntArray,
    classes: Sequence[str],
    collected: Collected,
    settings: SelectConfig,
    likeness: LikenessParameters,
) -> IntArray:
    """Rows of the chosen, best first: `greedy_cover` of every thing by worth, then, if they are too few, others by IoU.

    Of near-duplicates only the pair of greatest worth counts, before the greedy choice, whose bound so holds.
    """
    iou = np.array([_iou(row) for row in rows])
    worth = np.array([_worth(row, settings.min_iou) for row in rows])
    wanted = np.flatnonzero([_wanted(row, settings) for row in rows])
    # IoU decides between pairs that are worth nothing.
    order = worth + (worth == 0) * (iou - 1)
    wanted = wanted[collected.distinct(pairs[wanted], order[wanted], likeness)]
    groups = groups_of(pairs[wanted], classes, collected.cluster, EVERY_THING)
    chosen = wanted[greedy_cover(worth[wanted], groups, settings.top)]
    others = np.setdiff1d(wanted, chosen)
    others = others[np.argsort(-iou[others], kind="stable")]
    return np.concatenate([chosen, others])[: settings.top].astype(np.int64)


def _iou(row: Mapping[str, Any]) -> float:
    """IoU of the worse shape; 0 without a transform."""
    return min(float(row["iou_p"]), float(row["iou_q"])) if "riot" in row else 0.0


def _worth(row: Mapping[str, Any], floor: float) -> float:
    """The lesser margin, or 0 if the pair is below the floor or mistaken; the IoU where the collection has no other.

    It counts for less if a result is nearer to another thing than to all of its own but the input.
    """
    if _iou(row) < floor:
        return 0.0
    if "other_p" not in row or "other_q" not in row:
        return _iou(row)
    margins = row["margin_p"], row["margin_q"]  # None: equal to another thing
    recognised = row["recognised_p"] and row["recognised_q"]
    return 0.0 if None in margins else max(0.0, min(margins)) * (1.0 if recognised else UNRECOGNISED)


def _wanted(row: Mapping[str, Any], settings: SelectConfig) -> bool:
    """Whether a construction has a transform, and is as the user wishes."""
    return (
        "riot" in row
        and (not settings.pieces or row["n"] in settings.pieces)
        and row.get("surprise", 0.0) >= settings.min_surprise
        and (not settings.flat or bool(row.get("swings_flat")))
    )


def items(progress: Progress) -> list[WorkItem]:
    """One work item, over the constructions that are done."""
    recipe, constructed = progress.recipes["choose"], progress.finished("construct")
    number = {item.members: k for k, item in enumerate(constructed)}
    margins, motions = progress.finished("margin"), progress.finished("swing")
    things = progress.finished("near_duplicates")
    spec = Constructed(
        progress.classes,
        tuple((item.members[0], item.members[1]) for item in constructed),
        tuple(number[item.members] for item in margins),
        tuple(number[item.members] for item in motions),
        bool(things),
    )
    sources = [*constructed, *margins, *motions, *things]
    parts = recipe.parts([item.key for item in sources], digest_text(repr(spec)))
    return [recipe.item(parts, [item.reference for item in sources], spec=spec)]


def chosen(progress: Progress) -> list[WorkItem]:
    """The constructions that are chosen, in order; without this stage all that are done, none if it failed."""
    constructed = progress.finished("construct")
    if "choose" not in progress.work:
        return constructed
    return [
        constructed[int(position)]
        for item in progress.finished("choose")
        for position in progress.read(item).arrays["positions"]
    ]


def best_certified(progress: Progress, count: int) -> list[WorkItem]:
    """The first ``count`` certified ones of the chosen; without this stage, the least deformed."""
    if "choose" not in progress.work:
        return least_deformed(progress, count)
    return chosen_certified(progress)[:count]


def chosen_certified(progress: Progress) -> list[WorkItem]:
    """The chosen constructions whose certificates passed, in order."""
    passed = {item.members for item in certified(progress)}
    return [item for item in chosen(progress) if item.members in passed]


STAGE = Stage(
    name="choose",
    unit="selection",
    after=("margin", "swing"),
    parameters=("select", "likeness"),
    items=items,
    run=run,
    scope="collection",
    known_after="construct",
    wanted=lambda config: config.select.policy == "varied",
    at_most=lambda config: 1,
    here=True,
)
