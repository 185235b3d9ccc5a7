"""The trunks of a state on bent shapes: while a slider is dragged, and when it is let go."""

from __future__ import annotations

from dataclasses import replace

from riot.construction.bend import bend_plan
from riot.construction.plan import ConstructionPlan
from riot.construction.replan import plan_of, unbent_plan
from riot.errors import ConstructionError, TrunkError
from riot.parameters import BendParameters, RefineParameters
from studio.session.state import State
from studio.work.material import Files, once, transform
from studio.work.search import both_modes, found_plans

DRAFT = BendParameters(method="elastic", contact=16.0, sketch_steps=7, steps=0, turns=0)
"""A bend that is answered while a slider is dragged. As few steps must do, contact weighs more than in a search."""

EXACT = BendParameters(method="elastic", contact=4.0, steps=16)
"""A bend that is answered when it is released: a third of the steps of a search, on one plan."""

REFINEMENT = RefineParameters(lines=64)
"""Scanlines of the bound while one plan is bent: half of a search's."""


def draft_bent(state: State, files: Files) -> ConstructionPlan:
    """The root's trunks after a few steps of bending; kept, since they tell when a slider is let go what will fail."""
    key = ("draft bent", state.root, state.weight, state.stiff_p, state.stiff_q)
    return once(key, lambda: _bent(state, files, DRAFT))


def exact_bent(state: State, files: Files) -> ConstructionPlan:
    """The root's trunks, bent to the end."""
    return _bent(state, files, EXACT)


def unbent(state: State, files: Files) -> ConstructionPlan:
    """The root's trunks on the inputs; the best trunks there are if those cannot be had without the bend."""
    root = state.root
    assert root is not None

    def find() -> ConstructionPlan:
        try:
            return unbent_plan(plan_of(transform(files, root)), RefineParameters().bound_lines)
        except (ConstructionError, TrunkError):
            return found_plans(state, files)[0]

    return once(("unbent", root), find)


def _bent(state: State, files: Files, parameters: BendParameters) -> ConstructionPlan:
    assert state.weight is not None
    weighed = replace(parameters, weight=state.weight)
    return bend_plan(unbent(state, files), *both_modes(state, files), weighed, REFINEMENT).plan
