"""Conjugate, refined trunks of a pair, from which construction may start, most promising first (theory §7)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.crs import unpack_scores
from pipeline.stages.shape_arrays import ErrorRow, attempt, expect_shape
from pipeline.stages.stage import Column, Stage, TableColumns
from pipeline.store.artifact import Artifact
from riot import construction
from riot.errors import ConstructionError
from riot.geometry.shape import Shape

if TYPE_CHECKING:
    from riot.construction.plan import ConstructionPlan, TrunkPair


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: tuple[int, int]) -> Artifact:
    """Batches of P and Q and the pair's CRS → refined plans, highest bound first (see `unpack_plans`).

    ``bounds`` (k, 2) of P and of Q; ``which`` (k,) numbers the trunk pair among the scores; ``trunks`` (s, 4) corners
    of T and T̄, those of plan i from ``offsets[i]`` on. Plans before ``first`` lose contact as they are; the bound of
    that one can be reached. The document lists the reasons why those, and other trunk pairs, are no plan.
    """
    batch_p, batch_q, cross = inputs
    settings, spacing, allowed = parameters
    p, q = expect_shape(batch_p, spec[0]), expect_shape(batch_q, spec[1])
    choose = construction.plan_search
    pairs = choose.trunk_pairs(p, q, unpack_scores(cross), settings.reach)
    errors: list[ErrorRow] = []
    plans, unplanned = attempt(0, lambda: choose.plan_pairs(pairs, settings), errors) or ([], [])

    best = attempt(0, lambda: choose.refine_best(plans, settings), errors) or []
    kept, failed = attempt(0, lambda: choose.drop_without_contact(best, spacing, allowed), errors) or ([], [])
    return Artifact(
        {
            "bounds": np.array([[plan.bound_p, plan.bound_q] for plan in best]).reshape(-1, 2),
            "which": np.array([_number(plan.pair, pairs) for plan in best], dtype=np.int64),
            "offsets": np.cumsum([0, *(plan.trunks.shape[1] for plan in best)], dtype=np.int64),
            "trunks": np.concatenate([np.empty((0, 4)), *(np.hstack(list(plan.trunks)) for plan in best)]),
        },
        {
            "first": len(best) - len(kept),
            "errors": errors,
            "reasons": [[error.reason, str(error)] for error in (*failed, *unplanned)],
        },
    )


def _number(pair: TrunkPair, pairs: Sequence[TrunkPair]) -> int:
    return next(number for number, candidate in enumerate(pairs) if candidate is pair)


def bound(artifact: Artifact, pieces: Sequence[int] = ()) -> float:
    """The greatest IoU of the worse shape that any plan allows, or any of so many ``pieces``; 0 without a plan."""
    bounds, sizes = artifact.arrays["bounds"].min(axis=1), np.diff(artifact.arrays["offsets"])
    reached = np.arange(len(bounds)) >= artifact.document["first"]
    if pieces:
        reached &= np.isin(sizes, pieces)
    return float(bounds[reached].max(initial=0.0))


def unpack_plans(
    artifact: Artifact, cross: Artifact, p: Shape, q: Shape, reach: float, *, all_plans: bool = False
) -> tuple[list[ConstructionPlan], list[ConstructionError]]:
    """The plans that `run` packed, and the errors of the trunk pairs without a plan.

    With ``all_plans`` those are among them that lose contact as they are.
    """
    pairs, arrays = construction.plan_search.trunk_pairs(p, q, unpack_scores(cross), reach), artifact.arrays
    plans = [
        construction.plan.ConstructionPlan(
            pairs[which], np.stack([trunk[:, :2], trunk[:, 2:]]), float(bounds[0]), float(bounds[1])
        )
        for which, trunk, bounds in zip(
            arrays["which"],
            np.split(np.array(arrays["trunks"]), arrays["offsets"][1:-1]),
            arrays["bounds"],
            strict=False,
        )
    ]
    first = 0 if all_plans else artifact.document["first"]
    return plans[first:], [ConstructionError(reason, message) for reason, message in artifact.document["reasons"]]


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each pair with a CRS, in order."""
    recipe = progress.recipes["refine"]
    return [
        recipe.item(
            recipe.parts([cross.key]), [*cross.sources[:2], cross.reference], spec=cross.spec, members=cross.members
        )
        for cross in progress.work["crs"]
    ]


STAGE = Stage(
    name="refine",
    unit="pairs",
    after=("crs",),
    parameters=("refine", "construct.spacing", "construct.max_lost_contact"),
    items=items,
    run=run,
    scope="pair",
    known_after="select",
    at_most=lambda config: config.select.selected,
    bundle=4,
    tables=(
        TableColumns(
            "crs",
            (
                Column(
                    "bound", "float64", "greatest IoU of the worse shape on refined trunks, 0 = no trunks will do", "1"
                ),
            ),
            lambda artifact: {"bound": bound(artifact)},
        ),
    ),
)
