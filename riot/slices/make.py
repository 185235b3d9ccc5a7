"""From slices and their shortlists to puzzles: assign, construct, plan the motion, design, certify. Ours.

A slice whose best counterpart comes to nothing takes the next; one that has none left is told with its reasons, and
stops no other.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from riot.construction.plan_transform import construct_plans
from riot.errors import FabricationError, RiotError, SilhouetteError
from riot.fabricate.certificate import BuiltPuzzle, FabricationCertificate, build, fix
from riot.fabricate.plates import lay_out
from riot.geometry.polyline import extent
from riot.geometry.shape import Shape
from riot.motion.planner import with_motion
from riot.parameters import ConstructParameters, FabricationParameters, ShapeParameters, allowed_range
from riot.slices.assign import Planned, Shortlist, assign, plan_slice
from riot.slices.cut import Slice, Stack
from riot.slices.tuning import MOST_ATTEMPTS
from riot.transform.transform import Transform


@dataclass(frozen=True)
class Attempt:
    """A counterpart that a slice could not become, and why."""

    counterpart: str
    reason: str


@dataclass(frozen=True, eq=False)
class Puzzle:
    """A slice that is made: its transform (P is the slice), solids and certificate, and what was changed to mend it."""

    counterpart: str
    qcrs: float
    transform: Transform
    built: BuiltPuzzle

    @property
    def certificate(self) -> FabricationCertificate:
        """Of the solids."""
        return self.built.certificate


@dataclass(frozen=True, eq=False)
class SliceOutcome:
    """The result of one slice: its puzzle, or None with the reason, and the counterparts that were tried in vain."""

    slice: Slice
    puzzle: Puzzle | None
    reason: str
    attempts: tuple[Attempt, ...]


Find = Callable[[Sequence[Shape]], Sequence[Shortlist]]
"""The shortlists of some slices' shapes."""


def make_puzzles(
    stack: Stack,
    find: Find,
    parameters: FabricationParameters | None = None,
    *,
    distinct: bool = False,
    mend: bool = False,
    sampling: ShapeParameters | None = None,
    note: Callable[[str], None] = lambda message: None,
) -> tuple[SliceOutcome, ...]:
    """Make every slice of a stack; of ``parameters`` size and thickness are the slices' own.

    ``distinct``: each counterpart is taken once at most. ``mend``: pins may get thinner and knuckles thicker, but no
    slice larger. ``sampling``: how outlines become shapes. ``note`` is told what is done.

    Raises `riot.errors.FabricationError` if the thickness is out of its range.
    """
    parameters = replace(parameters or FabricationParameters(), thickness_mm=stack.thickness)
    shapes, reasons = _shapes(stack, sampling)
    known = [k for k, shape in enumerate(shapes) if shape is not None]
    lists = dict(zip(known, find([shape for shape in shapes if shape is not None]), strict=True))
    table: dict[int, dict[str, Planned]] = {}
    for k, shortlist in lists.items():
        shape = shapes[k]
        assert shape is not None
        note(f"slice {k + 1}: trunks of {len(shortlist)} counterparts")
        table[k] = {slice_.shape.name: plan_slice(shape, slice_) for slice_ in shortlist}
        reasons[k] = _none_left(shape.name, list(table[k].values()))
    puzzles, attempts = _rounds(stack, table, parameters, distinct=distinct, mend=mend, note=note)
    outcomes = []
    for k, slice_ in enumerate(stack.slices):
        tried, reason = tuple(attempts.get(k, ())), reasons.get(k, "")
        if k in puzzles:
            reason = ""
        elif tried:
            reason = f"{len(tried)} tried in vain; the most promising, {tried[0].counterpart}: {tried[0].reason}"
        elif distinct and any(planned.plans for planned in table.get(k, {}).values()):
            reason = "other slices took the counterparts that it can become: give more counterparts"
        outcomes.append(SliceOutcome(slice_, puzzles.get(k), reason, tried))
    return tuple(outcomes)


def _shapes(stack: Stack, sampling: ShapeParameters | None) -> tuple[list[Shape | None], dict[int, str]]:
    shapes: list[Shape | None] = []
    reasons: dict[int, str] = {}
    for k, slice_ in enumerate(stack.slices):
        try:
            shapes.append(slice_.shape(f"{stack.name}-{slice_.number}", sampling))
        except SilhouetteError as error:
            shapes.append(None)
            reasons[k] = str(error)
    return shapes, reasons


def _none_left(name: str, planned: Sequence[Planned]) -> str:
    if not planned:
        return f"no counterpart has trunks that fit {name}: give others, or cut another way (count, along)"
    return f"no counterpart will do; the most promising, {planned[0].candidate.shape.name}: {planned[0].reason}"


def _rounds(
    stack: Stack,
    table: dict[int, dict[str, Planned]],
    parameters: FabricationParameters,
    *,
    distinct: bool,
    mend: bool,
    note: Callable[[str], None],
) -> tuple[dict[int, Puzzle], dict[int, list[Attempt]]]:
    """Assign and make, and again without the pairs that came to nothing."""
    names = sorted({name for row in table.values() for name in row})
    costs = np.full((len(stack.slices), len(names)), math.inf)
    for k, row in table.items():
        for column, name in enumerate(names):
            if name in row:
                costs[k, column] = row[name].deformation
    puzzles: dict[int, Puzzle] = {}
    attempts: dict[int, list[Attempt]] = {}
    for _ in range(MOST_ATTEMPTS):
        chosen = assign(costs, distinct=distinct)
        if (chosen < 0).all():
            break
        for k, column in enumerate(chosen.tolist()):
            if column < 0:
                continue
            planned = table[k][names[column]]
            note(f"slice {k + 1}: becomes {names[column]} …")
            try:
                puzzles[k] = make_puzzle(stack.slices[k], planned, parameters, mend=mend)
            except RiotError as error:
                attempts.setdefault(k, []).append(Attempt(names[column], str(error)))
                costs[k, column] = math.inf
            else:
                costs[k] = math.inf  # it is done,
                if distinct:
                    costs[:, column] = math.inf  # and so is its counterpart
    return puzzles, attempts


def make_puzzle(slice_: Slice, planned: Planned, parameters: FabricationParameters, *, mend: bool) -> Puzzle:
    """Construct, design and verify one slice, at its own size.

    Raises `riot.errors.ConstructionError`, or `riot.errors.FabricationError`.
    """
    transform = with_motion(construct_plans(planned.plans, planned.unplanned, ConstructParameters()))
    size = mm_per_unit(transform.p) * max(extent(transform.outline_p()), extent(transform.outline_q()))
    least, greatest = allowed_range(FabricationParameters, "size_mm")
    if not least <= size <= greatest:
        raise FabricationError(
            "out-of-range",
            f"it is {size:.1f} mm long, and {least:g} to {greatest:g} mm can be made: make the object "
            f"{'larger' if size < least else 'smaller'} (thickness, count, size)",
            "size_mm",
            least if size < least else greatest,
        )
    built = _built(transform, replace(parameters, size_mm=size), mend)
    lay_out(built.parts, built.design.parameters)  # it raises if a part is larger than the bed
    return Puzzle(planned.candidate.shape.name, planned.candidate.qcrs, transform, built)


def mm_per_unit(shape: Shape) -> float:
    """How many mm of the stack a unit of a slice's shape is."""
    return math.sqrt(abs(float(np.linalg.det(shape.to_source[:, :2]))))


def _built(transform: Transform, parameters: FabricationParameters, mend: bool) -> BuiltPuzzle:
    size = parameters.size_mm
    try:
        built = fix(transform, parameters, enlarge=False) if mend else build(transform, parameters)
    except FabricationError as error:
        if error.parameter != "size_mm" or error.value > allowed_range(FabricationParameters, "size_mm")[1]:
            raise
        times = f"{error.value / size:.2f} times as large" if error.value > size else "larger"
        raise FabricationError(
            "too-small",
            f"it is only {size:.0f} mm long: {error}; slices keep their size: make the object {times}, or cut it into "
            "fewer, thicker slices",
            "size_mm",
            error.value,
        ) from error
    if not built.certificate.passed:
        raise FabricationError("uncertified", "; ".join(built.certificate.failures))
    return built
