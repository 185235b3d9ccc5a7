"""Answer an edit: the state that follows, without a new search where the trunks stay."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TypeVar

import numpy as np
import shapely
from msgspec import structs

from riot.construction.contact import require_plan_cells
from riot.construction.dissected_plan import dissect_plan
from riot.construction.drawn_lines import pull
from riot.construction.line_over_hinges import draw_stretch
from riot.construction.pinned_stretch import PinnedStretch, keep_stretch
from riot.construction.pins import Pin as GeometryPin
from riot.construction.plan import ConstructionPlan
from riot.construction.plan_transform import construct_plan, construct_plans
from riot.construction.refine import refine
from riot.construction.replan import plan_of, with_corner
from riot.errors import ConstructionError, PinError
from riot.parameters import ConstructParameters, RefineParameters
from riot.transform.transform import Transform
from riot.types import FloatArray
from studio.messages import (
    Choose,
    Corner,
    Draw,
    Edit,
    Erase,
    Keep,
    Pull,
    RequestError,
    Side,
    Stiff,
    Unpin,
    Unstiff,
    Weight,
    flat_of,
    points_of,
)
from studio.session.state import Pin, State, StiffRegion
from studio.work.answer import Answer, Shortfall, draft, kept, timed
from studio.work.bent_plans import draft_bent, exact_bent, unbent
from studio.work.material import Files, back, dissected, forth, pins_of, side_pins, transform
from studio.work.painting import DIGITS, erased, painted
from studio.work.search import bent_soon, found_plans

GRASP = 0.3
"""A person may be so far off the outline that is meant, in the unit-area frame."""

OTHER_TRUNKS = " Another way to cut may have room for it: see Choose."

Item = TypeVar("Item")


@timed
def change(state: State, edit: Edit, files: Files, quick: bool) -> Answer:
    """What follows from an edit of a state that shows a transform; ``quick``: a draft, not to be kept.

    Raises `riot.errors.RiotError` if it cannot be done, `riot.errors.PinError` with the place where.
    """
    if state.base is None or state.root is None:
        raise RequestError("there is no transform yet that could be edited")
    base = transform(files, state.base)
    match edit:
        case Draw(side, line):
            given, stored = _with_ends_on(points_of(line), base, side), partial(_stored, base, side)
            drawn = draw_stretch(dissected(files, state.base), side, pins_of(state, base), given, stored)
            return _stretched(state, base, side, drawn, "draw", files, quick)
        case Pull(side, at, to, reach):
            pins = _pins(state, base, side)
            there = nearest(points_of(at), base.outline_p() if side == "p" else base.outline_q())[0]
            pins = pull(dissected(files, state.base), side, pins, there, points_of(to)[0], reach)
            return _pinned(_with_pins(state, base, side, pins, "pull"), files, quick)
        case Keep(side, points):
            there = nearest(points_of(points), (base.p if side == "p" else base.q).points)
            kept_stretch = keep_stretch(
                dissected(files, state.base), side, pins_of(state, base), there, partial(_stored, base, side)
            )
            return _stretched(state, base, side, kept_stretch, "keep", files, quick)
        case Unpin(side, index):
            pins = _without(_pins(state, base, side), index, "pin")
            return _pinned(_with_pins(state, base, side, pins, "unpin"), files, quick)
        case Corner(side, corner, to):
            lines = RefineParameters().bound_lines
            plan = with_corner(plan_of(base), side, corner, points_of(to)[0], lines)
            return _planned(structs.replace(state, step="move corner"), plan, True, quick)
        case Choose(digest):
            chosen = structs.replace(state, step="choose", root=digest, base=digest)
            return _pinned(chosen, files, quick)
        case Weight(weight):
            return _bent(structs.replace(state, step="weight", weight=weight), files, quick)
        case Stiff(side, stroke, radius, factor):
            region = painted(back(points_of(stroke), base, side), radius, factor)
            return _stiffened(state, side, (*state.stiff(side), region), files, quick)
        case Erase(side, stroke, radius):
            regions = erased(state.stiff(side), back(points_of(stroke), base, side), radius)
            if regions == state.stiff(side):
                raise RequestError("nothing is painted there")
            return _stiffened(state, side, regions, files, quick)
        case Unstiff(side, index):
            return _stiffened(state, side, _without(state.stiff(side), index, "stiff region"), files, quick)
    raise RequestError("this edit needs no transform, and is no change of one")


def nearest(points: FloatArray, outline: FloatArray) -> FloatArray:
    """(k, 2) the points of an outline (m, 2) that are nearest to ``points``; raises RequestError if one is far off.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> nearest(np.array([[0.5, -0.1]]), square).tolist()
    [[0.5, 0.0]]
    """
    ring, given = shapely.LinearRing(outline), shapely.points(points)
    if (shapely.distance(ring, given) > GRASP).any():
        raise RequestError("this is far from the outline")
    on_it = shapely.line_interpolate_point(ring, shapely.line_locate_point(ring, given))
    return np.asarray(shapely.get_coordinates(on_it))


def _with_ends_on(line: FloatArray, base: Transform, side: Side) -> FloatArray:
    """A drawn line (k, 2) whose ends are moved to the outline that the pieces make."""
    outline = base.outline_p() if side == "p" else base.outline_q()
    return np.concatenate([nearest(line[:1], outline), line[1:-1], nearest(line[-1:], outline)])


def _pins(state: State, base: Transform, side: Side) -> tuple[GeometryPin, ...]:
    return side_pins(state.pins(side), base, side)


def _with_pins(state: State, base: Transform, side: Side, pins: tuple[GeometryPin, ...], step: str) -> State:
    """A state with other pins of one side, which are those of the shapes of ``base``."""
    kept_pins = tuple(
        Pin("draw" if pin.drawn else "keep", tuple(flat_of(back(pin.points, base, side), DIGITS))) for pin in pins
    )
    return structs.replace(state, step=step, **{f"pins_{side}": kept_pins})


def _without(items: tuple[Item, ...], index: int, noun: str) -> tuple[Item, ...]:
    if index >= len(items):
        raise RequestError(f"there is no {noun} {index}: there are {len(items)}")
    return items[:index] + items[index + 1 :]


def _stored(base: Transform, side: Side, points: FloatArray) -> FloatArray:
    """Points (k, 2) as they are when they come back from a state."""
    return forth(points_of(tuple(flat_of(back(points, base, side), DIGITS))), base, side)


def _stretched(
    state: State, base: Transform, side: Side, stretch: PinnedStretch, step: str, files: Files, quick: bool
) -> Answer:
    """The pieces with the pins of a stretch, and where they do not follow it."""
    answer = _pinned(
        _with_pins(state, base, side, stretch.pins.p if side == "p" else stretch.pins.q, step), files, quick
    )
    if not stretch.reason:
        return answer
    words = f"Not where it is marked: {stretch.reason}.{OTHER_TRUNKS if step == 'keep' else ''}"
    return replace(answer, shortfall=Shortfall(side, tuple(flat_of(stretch.lost)), words))


def _pinned(state: State, files: Files, quick: bool) -> Answer:
    """Cut the pieces of a state's base again, with its pins; the partitions stay."""
    assert state.base is not None
    base = transform(files, state.base)
    pins = pins_of(state, base)
    return _answer(state, dissected(files, state.base).transform(pins) if pins else base, quick)


def _answer(state: State, shown: Transform, quick: bool) -> Answer:
    if quick:
        return Answer(state, draft(shown))
    made = kept(shown)
    return Answer(structs.replace(state, shown=made.digest), made)


def _planned(state: State, plan: ConstructionPlan, as_root: bool, quick: bool) -> Answer:
    """Cut on another plan, which becomes the base of the state, and its root as well if ``as_root``."""
    if quick:
        plans = dissect_plan(plan, ConstructParameters())
        base = plans.transform()
        pins = pins_of(state, base)
        return _answer(state, plans.transform(pins) if pins else base, quick)
    base = construct_plan(plan, ConstructParameters())
    pins = pins_of(state, base)
    return _based(state, base, construct_plan(plan, ConstructParameters(), pins) if pins else None, as_root)


def _based(state: State, base: Transform, shown: Transform | None, as_root: bool) -> Answer:
    made = kept(base)
    state = structs.replace(state, base=made.digest, root=made.digest if as_root else state.root)
    if shown is None or not (state.pins_p or state.pins_q):
        return Answer(structs.replace(state, shown=made.digest), made)
    answer = _answer(state, shown, False)
    return Answer(answer.state, answer.shown, (made,))


def _bent(state: State, files: Files, quick: bool) -> Answer:
    """Bend the root's trunks and shapes as the state says."""
    if state.weight is None:
        return _unbent_answer(state, unbent(state, files), files, quick)
    drafted = draft_bent(state, files)
    if quick:
        return _planned(state, drafted, False, quick)
    try:
        require_plan_cells(drafted, ConstructParameters())
        return _planned(state, exact_bent(state, files), False, quick)
    except PinError:
        raise
    except ConstructionError:
        # These trunks fall apart when they are bent so: take others that do not.
        found = bent_soon(state, files)
    answer = _pinned(found.state, {**files, found.shown.digest: found.shown.text}, quick)
    return replace(answer, others=(found.shown,))


def _unbent_answer(state: State, plan: ConstructionPlan, files: Files, quick: bool) -> Answer:
    """Refine the trunks for shapes that do not bend; where they give no transform, take the best that do."""
    refinement = RefineParameters()
    refined = refine(plan, refinement.steps, refinement)
    try:
        return _planned(state, refined, False, quick)
    except ConstructionError:
        base = construct_plans(found_plans(state, files), [], ConstructParameters())
        pins = pins_of(state, base)
        shown = dissect_plan(plan_of(base), ConstructParameters()).transform(pins) if pins else None
        return _answer(state, shown or base, True) if quick else _based(state, base, shown, False)


def _stiffened(state: State, side: Side, regions: tuple[StiffRegion, ...], files: Files, quick: bool) -> Answer:
    state = structs.replace(state, step="stiffness", **{f"stiff_{side}": regions})
    return _pinned(state, files, quick) if state.weight is None else _bent(state, files, quick)
