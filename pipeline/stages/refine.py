"""Trunks of one pair made conjugate and refined: what construction may build on, most promising first (theory §7)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pipeline.stages.crs import unpack_scores
from pipeline.stages.items import ErrorRow, attempt, expect_shape
from pipeline.store.artifact import Artifact
from riot.construction.choose import drop_without_contact, plan_pairs, refine_best, trunk_pairs
from riot.construction.plan import Plan, TrunkPair
from riot.errors import ConstructionError
from riot.geometry.shape import Shape


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: tuple[int, int]) -> Artifact:
    """Batches of P and Q and the pair's CRS → refined plans, highest bound first (see `unpack_plans`).

    ``bounds`` (k, 2) of P and of Q; ``which`` (k,) numbers the trunk pair among the scores; ``trunks`` (s, 4) corners
    of T and T̄, those of plan i from ``offsets[i]`` on. Plans that lose contact and come before any that does not are
    left out, so that the first bound can be had. The document says why others gave no plan.
    """
    batch_p, batch_q, cross = inputs
    settings, spacing, allowed = parameters
    p, q = expect_shape(batch_p, spec[0]), expect_shape(batch_q, spec[1])
    pairs = trunk_pairs(p, q, unpack_scores(cross), settings.reach)
    errors: list[ErrorRow] = []
    found = attempt(0, lambda: plan_pairs(pairs, settings), errors)
    plans, unplanned = found if found is not None else ([], [])
    refined = attempt(0, lambda: drop_without_contact(refine_best(plans, settings), spacing, allowed), errors)
    best, failed = refined if refined is not None else ([], [])
    return Artifact(
        {
            "bounds": np.array([[plan.bound_p, plan.bound_q] for plan in best]).reshape(-1, 2),
            "which": np.array([_place(plan.pair, pairs) for plan in best], dtype=np.int64),
            "offsets": np.cumsum([0, *(plan.trunks.shape[1] for plan in best)], dtype=np.int64),
            "trunks": np.concatenate([np.empty((0, 4)), *(np.hstack(list(plan.trunks)) for plan in best)]),
        },
        {"errors": errors, "reasons": [[one.reason, str(one)] for one in (*failed, *unplanned)]},
    )


def _place(pair: TrunkPair, pairs: Sequence[TrunkPair]) -> int:
    return next(place for place, other in enumerate(pairs) if other is pair)


def bound(artifact: Artifact) -> float:
    """The highest IoU of the worse shape that the best plan allows; 0 without a plan."""
    return float(artifact.arrays["bounds"].min(axis=1).max(initial=0.0))


def unpack_plans(
    artifact: Artifact, cross: Artifact, p: Shape, q: Shape, reach: float
) -> tuple[list[Plan], list[ConstructionError]]:
    """The plans that `run` made, and why there are no others."""
    pairs, arrays = trunk_pairs(p, q, unpack_scores(cross), reach), artifact.arrays
    plans = [
        Plan(pairs[which], np.stack([trunk[:, :2], trunk[:, 2:]]), float(bounds[0]), float(bounds[1]))
        for which, trunk, bounds in zip(
            arrays["which"],
            np.split(np.array(arrays["trunks"]), arrays["offsets"][1:-1]),
            arrays["bounds"],
            strict=False,
        )
    ]
    return plans, [ConstructionError(reason, message) for reason, message in artifact.document["reasons"]]
