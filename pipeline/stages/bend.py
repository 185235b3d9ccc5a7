"""Bent plans of one pair of the shortlist: both shapes are bent, so that cutting changes them less (theory §12)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.modes import bends, unpack_modes
from pipeline.stages.refine import unpack_plans
from pipeline.stages.shape_arrays import ErrorRow, attempt, expect_shape
from pipeline.stages.shortlist import shortlisted
from pipeline.stages.stage import Stage
from pipeline.stages.trunk_arrays import unpack_trunks
from pipeline.store.artifact import AnyArray, Artifact
from riot import construction, geometry
from riot.geometry.shape import Shape
from riot.parameters import ConstructParameters

if TYPE_CHECKING:
    from riot.construction.bend import BentPlan


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: tuple[int, int]) -> Artifact:
    """Batches of P and Q, the pair's CRS and refined trunks, both shapes' modes and full trunks → bent plans.

    `unpack_bent` reads them. Without modes of either shape there are none.
    """
    batch_p, batch_q, cross, refined, modes_p, modes_q, *trunks = inputs
    settings, refinement, spacing, lost, cut_off = parameters
    limits = ConstructParameters(spacing=spacing, max_lost_contact=lost, max_cut_off=cut_off)
    p, q = expect_shape(batch_p, spec[0]), expect_shape(batch_q, spec[1])
    of_p, of_q = unpack_modes(modes_p, p), unpack_modes(modes_q, q)
    plans, _ = unpack_plans(refined, cross, p, q, refinement.reach, all_plans=True)
    errors: list[ErrorRow] = []
    best: list[BentPlan] = []
    if plans and of_p is not None and of_q is not None:

        def bend() -> list[BentPlan]:
            full_p, full_q = (unpack_trunks(full, 0) for full in trunks)
            more = construction.plan_search.sized_plans(p, q, full_p, full_q, refinement, settings.starts)
            starts = sorted([*plans, *more], key=lambda plan: -plan.bound)
            return construction.bend.bend_plans(starts, of_p, of_q, settings, refinement, limits)

        best = attempt(0, bend, errors) or []
    return Artifact(_pack(best), {"errors": errors})


def _pack(best: Sequence[BentPlan]) -> dict[str, AnyArray]:
    arrays: dict[str, AnyArray] = {
        "worth": np.array([one.worth for one in best]),
        "bounds": np.array([[one.plan.bound_p, one.plan.bound_q] for one in best]).reshape(-1, 2),
        "offsets": np.cumsum([0, *(one.plan.trunks.shape[1] for one in best)], dtype=np.int64),
        "trunks": np.concatenate([np.empty((0, 4)), *(np.hstack(list(one.plan.trunks)) for one in best)]),
        "corners": np.concatenate(
            [np.empty((0, 2), dtype=np.int64)]
            + [np.column_stack([one.plan.pair.trunk_p, one.plan.pair.trunk_q]) for one in best]
        ),
    }
    for side in ("p", "q"):
        made = [getattr(one, side) for one in best]
        arrays[f"coefficients_{side}"] = np.array([bend.coefficients for bend in made])
        arrays[f"moved_{side}"] = np.array([bend.field.moved for bend in made])
    return arrays


def unpack_bent(
    modes_p: Artifact, modes_q: Artifact, artifact: Artifact, p: Shape, q: Shape, reach: float
) -> list[BentPlan]:
    """The bent plans that `run` packed, the one of most worth first."""
    of_p, of_q = unpack_modes(modes_p, p), unpack_modes(modes_q, q)
    arrays = {name: np.array(values) for name, values in artifact.arrays.items()}
    if of_p is None or of_q is None:
        return []
    plans = []
    stops = arrays["offsets"][1:-1]
    rows = zip(np.split(arrays["corners"], stops), np.split(arrays["trunks"], stops), strict=True)
    for number, (corners, trunks) in enumerate(rows if len(arrays["worth"]) else ()):
        bend_p, bend_q = (
            geometry.bend.bent_by(modes, arrays[f"coefficients_{side}"][number], arrays[f"moved_{side}"][number])
            for side, modes in (("p", of_p), ("q", of_q))
        )
        pair = construction.plan.TrunkPair(p, q, p.points, q.points, corners[:, 0].copy(), corners[:, 1].copy(), reach)
        plan = construction.plan.ConstructionPlan(
            construction.bend.bent_pair(pair, bend_p, bend_q),
            np.stack([trunks[:, :2], trunks[:, 2:]]),
            *arrays["bounds"][number].tolist(),
        )
        plans.append(construction.bend.BentPlan(plan, bend_p, bend_q, float(arrays["worth"][number])))
    return plans


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each pair of the shortlist whose shapes' modes are done, the most promising first."""
    recipe, refined = progress.recipes["bend"], progress.finished("refine")
    modes = {item.members[0]: item for item in progress.finished("modes")}
    trunks = {item.members[0]: item for item in progress.work["trunks_full"]}
    work = []
    for position in shortlisted(progress):
        item = refined[position]
        p, q = item.members
        if p in modes and q in modes:
            full = [trunks[p], trunks[q]]
            keys = [item.key, modes[p].key, modes[q].key, *(one.key for one in full)]
            sources = [*item.sources, item.reference, modes[p].reference, modes[q].reference]
            sources += [one.reference for one in full]
            work.append(recipe.item(recipe.parts(keys), sources, spec=item.spec, members=item.members))
    return work


STAGE = Stage(
    name="bend",
    unit="pairs",
    after=("shortlist", "modes"),
    parameters=("bend", "refine", "construct.spacing", "construct.max_lost_contact", "construct.max_cut_off"),
    items=items,
    run=run,
    scope="pair",
    known_after="shortlist",
    at_most=lambda config: config.select.constructed,
    wanted=bends,
    bundle=4,
)
