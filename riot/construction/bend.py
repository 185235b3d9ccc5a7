"""Bend both shapes of a plan along their elastic modes, together with its trunks (theory §12; ours).

The exact construction changes a shape only by moving area, so that a tail which fits nowhere is cut off. A shape
that is a little slimmer, or whose legs stand closer, is forgiven far more readily. So both shapes are bent as little
as pays, and cut afterwards; what bending costs is reported apart from what cutting costs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from riot.construction.bend_climb import BendClimb, BendState
from riot.construction.bend_objective import BendObjective
from riot.construction.bent_side import BentSide
from riot.construction.contact import require_plan_cells
from riot.construction.plan import ConstructionPlan, TrunkPair, plan_on
from riot.construction.refine import refine
from riot.construction.stiff import StiffRegions
from riot.construction.tuning import (
    CONJUGATE_STEPS,
    EDGE_TOLERANCE,
    EXACT_BOUND,
    HELD_CONTACT,
    HELD_STARTS,
    LARGE_TURN,
    NEAR_COPY,
    SHARPNESS,
    SOFTEST,
)
from riot.errors import ConstructionError
from riot.geometry.bend import Bend, bent_by
from riot.geometry.modes import Modes, modes
from riot.geometry.polyline import is_simple
from riot.kernels.conjugate import conjugated
from riot.parameters import BendParameters, ConstructParameters, RefineParameters
from riot.types import FloatArray

_SHRINKS = (1.0, 0.7, 0.4, 0.0)
"""Shares of a bend that are tried in turn until both bent outlines are simple."""


@dataclass(frozen=True, eq=False)
class BentPlan:
    """A plan on bent shapes.

    Parameters
    ----------
    plan : ConstructionPlan
        Its shapes are the bent ones, and its bounds are against them.
    p, q : Bend
        What was done to the inputs.
    worth : float
        The bound of the worse shape less what the strain costs.
    """

    plan: ConstructionPlan
    p: Bend
    q: Bend
    worth: float


def bend_best(
    plans: Sequence[ConstructionPlan],
    parameters: BendParameters,
    refinement: RefineParameters | None = None,
    construction: ConstructParameters | None = None,
    stiff: StiffRegions | None = None,
) -> list[BentPlan]:
    """Bend the most promising plans of one pair of shapes, of which there is at least one, as `bend_plans` (ours).

    Regions that are ``stiff`` bend less.

    >>> from riot.construction import alternatives, construct_plan
    >>> bent = bend_best(alternatives(house, kite), BendParameters(steps=8))
    >>> construct_plan(bent[0].plan, ConstructParameters()).p is bent[0].p.bent
    True
    """
    pair = plans[0].pair
    stiff = stiff or StiffRegions()
    modes_p, modes_q = (
        modes(shape, parameters.modes, parameters.straight, regions)
        for shape, regions in ((pair.p, stiff.p), (pair.q, stiff.q))
    )
    return bend_plans(plans, modes_p, modes_q, parameters, refinement, construction)


def bend_plans(
    plans: Sequence[ConstructionPlan],
    modes_p: Modes,
    modes_q: Modes,
    parameters: BendParameters,
    refinement: RefineParameters | None = None,
    construction: ConstructParameters | None = None,
) -> list[BentPlan]:
    """Bend the most promising plans a little, and the best of these to the end; the one of most worth first (ours).

    Arguments as of `bend_plan`. The plans are of one pair of shapes, the one of highest bound first.

    >>> from riot.construction import alternatives
    >>> from riot.geometry.modes import modes
    >>> bent = bend_plans(alternatives(house, kite), modes(house), modes(kite), BendParameters(steps=8))
    >>> len(bent)
    4
    """
    sides, refinement = _sides(plans[0], modes_p, modes_q), refinement or RefineParameters()
    construction = construction or ConstructParameters()
    bent = _bend_round(plans, sides, parameters, refinement, construction)
    if not any(_can_be_cut(one.plan, construction) for one in bent):
        held = replace(
            parameters, contact=HELD_CONTACT * parameters.contact, sketched=HELD_STARTS * parameters.sketched
        )
        bent += _bend_round(plans, sides, held, refinement, construction)
    return sorted(bent, key=lambda plan: -plan.worth)


def _bend_round(
    plans: Sequence[ConstructionPlan],
    sides: tuple[BentSide, BentSide],
    parameters: BendParameters,
    refinement: RefineParameters,
    construction: ConstructParameters,
) -> list[BentPlan]:
    chosen = _promising(plans, parameters.sketched, construction)
    tasks = [_Task.of(plan, sides, parameters, refinement, construction) for plan in chosen]
    tasks = sorted((task.sketched() for task in tasks), key=lambda task: -task.worth)
    count = parameters.finished
    return [*(task.finished().bent() for task in tasks[:count]), *(task.bent() for task in tasks[count:])]


def bend_plan(
    plan: ConstructionPlan,
    modes_p: Modes,
    modes_q: Modes,
    parameters: BendParameters,
    refinement: RefineParameters | None = None,
    construction: ConstructParameters | None = None,
) -> BentPlan:
    """Bend both shapes of a plan and move its trunks with them to where bound less cost is greatest (theory §12; ours).

    ``modes_p`` and ``modes_q`` are those of the plan's shapes. Of ``construction`` what decides
    whether a plan can be cut is read. A plan whose bound leaves nothing to gain is not bent.

    >>> from riot.construction import alternatives
    >>> from riot.geometry.modes import modes
    >>> plan = alternatives(house, kite)[0]
    >>> bent = bend_plan(plan, modes(house), modes(kite), BendParameters(steps=8))
    >>> bent.p.max_strain <= 0.35
    True
    """
    sides = _sides(plan, modes_p, modes_q)
    task = _Task.of(plan, sides, parameters, refinement or RefineParameters(), construction)
    return task.sketched().finished().bent()


@dataclass(frozen=True, eq=False)
class _Task:
    """A plan on its way, its first amplitudes in units of energy, and what it is worth so far."""

    plan: ConstructionPlan
    state: BendState
    coefficients: tuple[FloatArray, FloatArray]
    worth: float
    parameters: BendParameters
    refinement: RefineParameters
    allowed: float

    @classmethod
    def of(
        cls,
        plan: ConstructionPlan,
        sides: tuple[BentSide, BentSide],
        parameters: BendParameters,
        refinement: RefineParameters,
        construction: ConstructParameters | None,
    ) -> _Task:
        p, q = sides
        still = np.zeros(len(p.moves)), np.zeros(len(q.moves))
        state = BendState(sides, plan.trunks, still)
        allowed = (construction or ConstructParameters()).max_lost_contact
        return cls(plan, state, still, plan.bound, parameters, refinement, allowed)

    def climbed(self, sharpness: float, steps: int) -> _Task:
        if self.plan.bound >= EXACT_BOUND:
            return self
        _, windows_p, _, windows_q = self.plan.pair.windowed_outlines
        objective = BendObjective(
            self.state.sides, (windows_p, windows_q), self.refinement.lines, sharpness,
            self.refinement.attach, self.parameters.weight, self.parameters.contact, self.allowed,
        )  # fmt: skip
        climb = BendClimb(self.plan, self.state, objective, self.parameters, self.refinement.slide)
        state, worth = climb.run(self.state, steps)
        return replace(self, state=state, worth=worth)

    def with_coefficients(self) -> _Task:
        shares = [np.sqrt(values / (values + SOFTEST)) for values in (s.modes.eigenvalues for s in self.state.sides)]
        p, q = self.state.amplitudes
        return replace(self, coefficients=(p * shares[0], q * shares[1]))

    def sketched(self) -> _Task:
        return self.climbed(SHARPNESS[0], self.parameters.sketch_steps).with_coefficients()

    def finished(self) -> _Task:
        task = self
        for sharpness in SHARPNESS:
            task = task.climbed(sharpness, self.parameters.steps // len(SHARPNESS))
        task = task.with_coefficients()
        for _ in range(self.parameters.turns):
            if not _turns_far(task.state):
                break
            (p, q), (by_p, by_q) = task.state.sides, task.state.amplitudes
            if not (p.is_unfolded(by_p) and q.is_unfolded(by_q)):
                break
            again = BendState(
                (p.bent_again(by_p), q.bent_again(by_q)), task.state.trunks, (np.zeros_like(by_p), np.zeros_like(by_q))
            )
            task = replace(task, state=again)
            task = task.climbed(SHARPNESS[-1], self.parameters.steps // len(SHARPNESS))
        return task

    def bent(self) -> BentPlan:
        for share in _SHRINKS:
            p, q = self.state.amplitudes
            bent = _bent_plan(replace(self, state=replace(self.state, amplitudes=(share * p, share * q))))
            if is_simple(bent.p.bent.points) and is_simple(bent.q.bent.points):
                break
        return bent if share == 1.0 else replace(bent, plan=refine(bent.plan, self.refinement.steps, self.refinement))


def _sides(plan: ConstructionPlan, modes_p: Modes, modes_q: Modes) -> tuple[BentSide, BentSide]:
    pair = plan.pair
    return BentSide.unbent(modes_p, pair.outline_p), BentSide.unbent(modes_q, pair.outline_q)


def _promising(
    plans: Sequence[ConstructionPlan], count: int, construction: ConstructParameters
) -> list[ConstructionPlan]:
    """The first plans that are no near copies of better ones, with one among them that can be cut as it is, if any
    can."""
    distinct: list[ConstructionPlan] = []
    for plan in plans:
        if len(distinct) == count:
            break
        if not any(is_near(plan.trunks, other.trunks) for other in distinct):
            distinct.append(plan)
    keeping = next((plan for plan in plans if _can_be_cut(plan, construction)), None)
    if keeping is None or keeping in distinct:
        return distinct
    return [*distinct[: count - 1], keeping]


def is_near(trunks: FloatArray, others: FloatArray) -> bool:
    """Whether all corners of conjugate trunks (2, n, 2) lie near those of others in some order.

    >>> from riot.construction import alternatives
    >>> trunks = alternatives(house, kite)[0].trunks
    >>> is_near(trunks, trunks), is_near(trunks, trunks + 0.1)
    (True, False)
    """
    n = trunks.shape[1]
    return trunks.shape == others.shape and any(
        np.abs(trunks - np.roll(others, shift, axis=1)).max() < NEAR_COPY for shift in range(n)
    )


def _can_be_cut(plan: ConstructionPlan, construction: ConstructParameters) -> bool:
    try:
        require_plan_cells(plan, construction)
    except ConstructionError:
        return False
    return True


def bent_pair(pair: TrunkPair, p: Bend, q: Bend) -> TrunkPair:
    """The trunk pair of inputs with which the bends of both go along (ours).

    >>> from riot.construction import alternatives
    >>> from riot.geometry.bend import bend_shape
    >>> from riot.geometry.modes import modes
    >>> p, q = (bend_shape(modes(shape), np.full(16, 0.01)) for shape in (house, kite))
    >>> bent_pair(alternatives(house, kite)[0].pair, p, q).outline_p is p.bent.points
    True
    """
    outline_p, outline_q = (
        bend.bent.points if outline is bend.shape.points else bend.field.at(outline)
        for bend, outline in ((p, pair.outline_p), (q, pair.outline_q))
    )
    return TrunkPair(p.bent, q.bent, outline_p, outline_q, pair.trunk_p, pair.trunk_q, pair.reach, p, q)


def _turns_far(state: BendState) -> bool:
    for side, amplitudes in zip(state.sides, state.amplitudes, strict=True):
        maps = side.maps(amplitudes)
        turn = np.arctan2(maps[:, 1, 0] - maps[:, 0, 1], maps[:, 0, 0] + maps[:, 1, 1])
        if np.abs(turn).max() > LARGE_TURN:
            return True
    return False


def _bent_plan(task: _Task) -> BentPlan:
    """Bring both bent shapes to the frame of shapes, and the trunks with them."""
    bends, trunks = [], []
    for which, (side, amplitudes) in enumerate(zip(task.state.sides, task.state.amplitudes, strict=True)):
        _, scale = side.scaled_outline(amplitudes)
        nodes = scale * side.nodes_at(amplitudes)
        bend = bent_by(side.modes, task.coefficients[which], nodes)
        bends.append(bend)
        # The frame is shifted, and scaled by a rounding's worth, since the outline has more points than the shape.
        trunks.append(bend.field.moved.mean(axis=0) + task.state.trunks[which] - nodes.mean(axis=0))
    pair = bent_pair(task.plan.pair, bends[0], bends[1])
    conjugate, _ = conjugated(np.stack(trunks), EDGE_TOLERANCE, CONJUGATE_STEPS)
    plan = plan_on(pair, conjugate, task.refinement.bound_lines)
    strain = bends[0].rms_strain ** 2 + bends[1].rms_strain ** 2
    return BentPlan(plan, bends[0], bends[1], plan.bound - task.parameters.weight * strain)
