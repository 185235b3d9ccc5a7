"""Find transforms of the two inputs of a state: the first one, and others to choose from."""

from __future__ import annotations

from dataclasses import replace

from msgspec import structs

from riot.construction.bend import bend_plan, bend_plans, is_near
from riot.construction.bent_choice import construct_bent
from riot.construction.plan import ConstructionPlan
from riot.construction.plan_search import find_plans
from riot.construction.plan_transform import construct_plan, construct_plans
from riot.errors import ConstructionError, TrunkError
from riot.geometry.modes import Modes
from riot.geometry.shape import Shape
from riot.parameters import BendParameters, ConstructParameters, RefineParameters
from riot.transform.deformation import overlap_ratios
from riot.transform.transform import Transform
from studio.session.state import State
from studio.work.answer import Answer, Made, kept, timed
from studio.work.material import Files, once, shape, shape_modes

PER_SIZE = BendParameters.starts
"""Trunk pairs of each number of vertices among the alternatives, beside those of highest CRS."""

MOST = 16
"""So many alternatives are constructed at most."""


SOON = BendParameters(method="elastic", contact=4.0, sketched=3, sketch_steps=8, finished=0, steps=0, turns=0, judged=3)
"""A bend of a few plans, in a quarter of the time of a whole search. Contact weighs more: fewer plans fall apart."""

SOON_REFINEMENT = RefineParameters(lines=64)
"""Scanlines of the bound for that: half of a search's."""


def bending(state: State) -> BendParameters | None:
    """How shapes are bent in this state; None for not at all."""
    return None if state.weight is None else BendParameters(method="elastic", weight=state.weight)


@timed
def first_transform(state: State, files: Files) -> Answer:
    """A transform to be seen at once: without a bend, or bent a little if no trunks will do without.

    Raises TrunkError, ConstructionError.
    """
    try:
        return _chosen(state, construct_plans(found_plans(state, files), [], ConstructParameters()))
    except ConstructionError:
        if state.weight is None:
            raise
    return bent_soon(state, files)


def bent_soon(state: State, files: Files) -> Answer:
    """The best transform of a few plans that are bent a little. Raises TrunkError, ConstructionError."""
    assert state.weight is not None
    plans, bend = found_plans(state, files), replace(SOON, weight=state.weight)
    bent = bend_plans(plans, *both_modes(state, files), bend, SOON_REFINEMENT)
    return _chosen(state, construct_bent(bent, plans, [], bend, ConstructParameters()))


@timed
def best_transform(state: State, files: Files) -> Answer:
    """The transform that `riot make` would make. Raises TrunkError, ConstructionError."""
    bend = bending(state)
    if bend is None:
        return first_transform(state, files)
    plans = found_plans(state, files)
    bent = bend_plans(plans, *both_modes(state, files), bend)
    return _chosen(state, construct_bent(bent, plans, [], bend, ConstructParameters()))


def count_alternatives(state: State, files: Files) -> int:
    """How many alternatives there are to construct, by `alternative`. Raises TrunkError if there is none."""
    return len(_distinct(state, files))


def alternative(state: State, files: Files, number: int) -> Made | None:
    """An alternative by number, the most promising first; None if it cannot be constructed."""
    plan, bend = _distinct(state, files)[number], bending(state)
    try:
        if bend is not None:
            plan = bend_plan(plan, *both_modes(state, files), bend).plan
        transform = construct_plan(plan, ConstructParameters())
    except ConstructionError:
        return None
    strain = sum(bent.rms_strain**2 for bent in (transform.bend_p, transform.bend_q) if bent is not None)
    return kept(transform, thumbnail=True, worth=min(overlap_ratios(transform)) - (state.weight or 0.0) * strain)


def found_plans(state: State, files: Files) -> list[ConstructionPlan]:
    """The refined trunk pairs of the two inputs, the one of highest bound first. Raises TrunkError if there is none."""
    a, b = inputs(state, files)

    def find() -> list[ConstructionPlan]:
        plans, unplanned = find_plans(a, b, RefineParameters(), state.pieces, PER_SIZE)
        if not plans:
            raise TrunkError(f"no trunk pair of {a.name} and {b.name} will do: {unplanned[0]}")
        return plans

    return once(("plans", state.p, state.q, state.pieces), find)


def both_modes(state: State, files: Files) -> tuple[Modes, Modes]:
    """The elastic modes of both inputs."""
    return shape_modes(files, state, "p"), shape_modes(files, state, "q")


def inputs(state: State, files: Files) -> tuple[Shape, Shape]:
    """Both inputs of a state that has them."""
    if state.p is None or state.q is None:
        raise TrunkError("two shapes are needed: one of them is missing")
    return shape(files, state.p), shape(files, state.q)


def _chosen(state: State, transform: Transform) -> Answer:
    made = kept(transform)
    return Answer(structs.replace(state, root=made.digest, base=made.digest, shown=made.digest), made)


def _distinct(state: State, files: Files) -> list[ConstructionPlan]:
    """Plans that are no near copies of better ones."""
    chosen: list[ConstructionPlan] = []
    for plan in found_plans(state, files):
        if not any(is_near(plan.trunks, other.trunks) for other in chosen):
            chosen.append(plan)
    return chosen[:MOST]
