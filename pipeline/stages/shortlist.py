"""The shortlist: of the pairs whose trunks were refined, the ones that are constructed (ours).

A construction reaches the bound of its trunks (theory §8), so that this ranks pairs by their true deformation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.collected import Collected
from pipeline.stages.cover import greedy_cover, groups_of
from pipeline.stages.policies import SelectionLimits, greedy, labels
from pipeline.stages.refine import bound
from pipeline.stages.stage import Stage
from pipeline.store.artifact import Artifact
from pipeline.store.keys import digest_text
from riot.parameters import LikenessParameters
from riot.types import FloatArray, IntArray

if TYPE_CHECKING:
    from pipeline.config.selection import SelectConfig


LEAST = 1e-3
"""IoU that is expected at least of a pair with a plan, however long its outlines."""

LOST_PER_LENGTH, LOST_PER_BOUND = 0.013, 0.2
"""IoU that a bent transform loses for a unit of both perimeters (unit area), and of what the bound lacks to 1. Ours, by
a fit on 2,174 pairs of MPEG-7."""


@dataclass(frozen=True)
class Refined:
    """What the shortlist reads: classes by position, and the pair of positions of each input.

    If the collection is ``described``, the last input are its clusters.
    """

    classes: tuple[str, ...]
    pairs: tuple[tuple[int, int], ...]
    described: bool


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Refined) -> Artifact:
    """Refined plans of the pairs, in order of selection → ``positions`` (k,) among them, least deformation first.

    Pairs are taken greedily by falling bound within the limits of ``select`` (policy ``paper`` has none); equal bounds
    in order of selection. A pair without a plan is taken only if there are too few others.
    """
    settings, likeness = parameters
    if settings.policy == "varied":
        things = inputs[-1].arrays if spec.described else {}
        collected = Collected.of(things, len(spec.classes))
        bounds = np.array([bound(plans, settings.pieces) for plans in inputs[: len(spec.pairs)]])
        pairs = np.array(spec.pairs, dtype=np.int64).reshape(-1, 2)
        return Artifact({"positions": varied(bounds, pairs, spec.classes, collected, settings, likeness)})
    bounds = np.array([bound(plans) for plans in inputs])
    order = np.argsort(-bounds, kind="stable")
    pairs = np.array(spec.pairs, dtype=np.int64).reshape(-1, 2)[order]
    if settings.policy == "paper":
        limits = SelectionLimits(settings.top, len(order) + 1, len(order) + 1)
    else:
        limits = SelectionLimits(settings.top, settings.per_class_pair, settings.per_shape)
    ranks = greedy(pairs[:, 0], pairs[:, 1], labels(spec.classes), limits)
    return Artifact({"positions": order[np.array(ranks, dtype=np.int64)]})


def varied(
    bounds: FloatArray,
    pairs: IntArray,
    classes: Sequence[str],
    collected: Collected,
    settings: SelectConfig,
    likeness: LikenessParameters,
) -> IntArray:
    """Rows of the pairs (k, 2) to choose from: in turn the next of those whose trunks allow the least deformation, and
    the next two of a cover of what they show, by the IoU that is expected of them.

    Bounds say little of how well a result is recognised, hence the cover; without the other list it would pass by the
    best of what has been shown. Of near-duplicates only the pair of greatest bound counts.
    """
    distinct = collected.distinct(pairs, bounds, likeness)
    possible = distinct[bounds[distinct] > 0]
    by_bound = possible[np.argsort(-bounds[possible], kind="stable")].tolist()
    groups = groups_of(pairs[possible], classes, collected.cluster)
    lost = LOST_PER_LENGTH * collected.perimeter[pairs[possible]].sum(axis=1) + LOST_PER_BOUND * (1 - bounds[possible])
    by_cover = possible[greedy_cover(np.maximum(1 - lost, LEAST), groups, settings.constructed)].tolist()
    turns = (row for three in zip_longest(by_bound, by_cover[::2], by_cover[1::2]) for row in three if row is not None)
    return np.array([*dict.fromkeys(turns)][: settings.constructed], dtype=np.int64)


def items(progress: Progress) -> list[WorkItem]:
    """One work item, over the pairs whose trunks are refined."""
    recipe, refined = progress.recipes["shortlist"], progress.finished("refine")
    pairs = tuple((item.members[0], item.members[1]) for item in refined)
    things = progress.finished("near_duplicates") if progress.config.select.policy == "varied" else []
    spec = Refined(progress.classes, pairs, bool(things))
    sources = [*refined, *things]
    parts = recipe.parts([item.key for item in sources], digest_text(repr(spec)))
    return [recipe.item(parts, [item.reference for item in sources], spec=spec)]


def shortlisted(progress: Progress) -> list[int]:
    """Numbers, among the pairs with refined trunks that are done, of those to construct; none if it failed."""
    for item in progress.finished("shortlist"):
        return [int(number) for number in progress.read(item).arrays["positions"]]
    return []


STAGE = Stage(
    name="shortlist",
    unit="selection",
    after=("refine",),
    parameters=("select", "likeness"),
    items=items,
    run=run,
    scope="collection",
    known_after="refine",
    at_most=lambda config: 1,
    here=True,
)
