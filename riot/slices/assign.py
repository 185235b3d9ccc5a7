"""Which counterpart a slice may become: shortlists by QCRS, deformations that trunks allow, the assignment. Ours."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from riot.construction.plan import ConstructionPlan
from riot.construction.plan_search import drop_without_contact, find_plans
from riot.errors import ConstructionError, TrunkError
from riot.geometry.shape import Shape
from riot.parameters import ConstructParameters, RefineParameters
from riot.scores.qcrs import score_block
from riot.scores.trunk_stack import stack
from riot.scores.trunks import Trunks, quick_trunks
from riot.types import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Candidate:
    """A counterpart on a slice's shortlist: its shape, and the quick score of the two."""

    shape: Shape
    qcrs: float


Shortlist = tuple[Candidate, ...]
"""Of one slice, best QCRS first; counterparts are told apart by their names."""


@dataclass(frozen=True, eq=False)
class Planned:
    """A slice and a candidate with their refined trunk pairs, the best first; none if ``reason`` says why not."""

    candidate: Candidate
    plans: tuple[ConstructionPlan, ...]
    unplanned: tuple[ConstructionError, ...]
    reason: str = ""

    @property
    def deformation(self) -> float:
        """1 − the highest IoU that an exact construction can have with the worse of the two shapes; inf without."""
        return 1.0 - self.plans[0].bound if self.plans else math.inf


def shortlists(slices: Sequence[Shape], counterparts: Sequence[Shape], keep: int) -> tuple[Shortlist, ...]:
    """The ``keep`` best counterparts of every slice by QCRS, of those that score above 0.

    Raises `riot.errors.TrunkError` if no counterpart has a trunk.
    """
    trunks = _trunks(counterparts)
    if not any(len(of_shape) for of_shape in trunks):
        names = ", ".join(shape.name for shape in counterparts)
        raise TrunkError(f"no counterpart has a trunk ({names}): give shapes that are plumper, or have fewer limbs")
    scores = score_block(stack(_trunks(slices)), stack(trunks))
    table = scores.score.reshape(len(slices), len(counterparts))
    lists = []
    for row in table:
        best = np.argsort(-row, kind="stable")[:keep]
        lists.append(tuple(Candidate(counterparts[j], float(row[j])) for j in best.tolist() if row[j] > 0.0))
    return tuple(lists)


def _trunks(shapes: Sequence[Shape]) -> list[Trunks]:
    return [quick_trunks(shape) for shape in shapes]


def plan_slice(shape: Shape, candidate: Candidate) -> Planned:
    """Refine the trunk pairs of a slice and a candidate; a pair that has none is no error, but says why."""
    try:
        plans, unplanned = find_plans(shape, candidate.shape, RefineParameters())
    except TrunkError as error:
        return Planned(candidate, (), (), str(error))
    plans, lost = drop_without_contact(plans, ConstructParameters.spacing, ConstructParameters.max_lost_contact)
    errors = (*lost, *unplanned)
    return Planned(candidate, tuple(plans), errors, "" if plans else str(errors[0]))


def assign(costs: FloatArray, *, distinct: bool) -> IntArray:
    """Which column each row takes, (rows,), −1 for none; inf in ``costs`` (rows, columns) is forbidden.

    Every row takes its cheapest column; if ``distinct`` a column is taken once at most, as many rows as can be have
    one, and among these ways the sum of costs is least.
    """
    rows = len(costs)
    columns = np.full(rows, -1, dtype=np.int64)
    allowed = np.isfinite(costs)
    if not allowed.any():
        return columns
    if not distinct:
        some = allowed.any(axis=1)
        columns[some] = costs[some].argmin(axis=1)
        return columns
    # Here, not above: it takes long to import, and every command of riot would wait for it.
    from scipy.optimize import linear_sum_assignment

    # One forbidden column costs more than all allowed ones together, so that as few as can be are taken.
    span = float(costs[allowed].max() - costs[allowed].min()) + 1.0
    forbidden = float(costs[allowed].max()) + span * (rows + 1)
    taken, by = linear_sum_assignment(np.where(allowed, costs, forbidden))
    kept = allowed[taken, by]
    columns[taken[kept]] = by[kept]
    return columns
