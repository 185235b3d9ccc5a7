"""The shortlist: of the pairs whose trunks were refined, the ones that are constructed (ours).

A construction reaches the bound of its trunks (theory §8), so that this ranks pairs by their true deformation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.refine import bound
from pipeline.stages.select import SelectionLimits, greedy, labels
from pipeline.stages.stage import Stage
from pipeline.store.artifact import Artifact
from pipeline.store.keys import digest_text


@dataclass(frozen=True)
class Refined:
    """What the shortlist reads: classes by position, and the pair of positions of each input."""

    classes: tuple[str, ...]
    pairs: tuple[tuple[int, int], ...]


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Refined) -> Artifact:
    """Refined plans of the pairs, in order of selection → ``positions`` (k,) among them, least deformation first.

    Pairs are taken greedily by falling bound within the limits of ``select`` (policy ``paper`` has none); equal bounds
    in order of selection. A pair without a plan is taken only if there are too few others.
    """
    (settings,) = parameters
    bounds = np.array([bound(plans) for plans in inputs])
    order = np.argsort(-bounds, kind="stable")
    pairs = np.array(spec.pairs, dtype=np.int64).reshape(-1, 2)[order]
    if settings.policy == "paper":
        limits = SelectionLimits(settings.top, len(order) + 1, len(order) + 1)
    else:
        limits = SelectionLimits(settings.top, settings.per_class_pair, settings.per_shape)
    ranks = greedy(pairs[:, 0], pairs[:, 1], labels(spec.classes), limits)
    return Artifact({"positions": order[np.array(ranks, dtype=np.int64)]})


def items(progress: Progress) -> list[WorkItem]:
    """One work item, over the pairs whose trunks are refined."""
    recipe, refined = progress.recipes["shortlist"], progress.finished("refine")
    pairs = tuple((item.members[0], item.members[1]) for item in refined)
    spec = Refined(progress.classes, pairs)
    parts = recipe.parts([item.key for item in refined], digest_text(repr(spec)))
    return [recipe.item(parts, [item.reference for item in refined], spec=spec)]


def shortlisted(progress: Progress) -> list[int]:
    """Numbers, among the pairs with refined trunks that are done, of those to construct; none if it failed."""
    for item in progress.finished("shortlist"):
        return [int(number) for number in progress.read(item).arrays["positions"]]
    return []


STAGE = Stage(
    name="shortlist",
    unit="selection",
    after=("refine",),
    parameters=("select",),
    items=items,
    run=run,
    scope="collection",
    known_after="refine",
    at_most=lambda config: 1,
    here=True,
)
