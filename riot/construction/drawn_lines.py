"""Lines drawn on an outline while it is edited: a point that is pulled, and lines on one piece joined. Ours."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from riot.construction.dissected_plan import DissectedPlan
from riot.construction.dissection import Dissection
from riot.construction.pinned_paths import drawn_section
from riot.construction.pins import Pin
from riot.construction.placed_outline import PinnedSection, PlacedOutline, carried
from riot.construction.tuning import MERGE_DISTANCE
from riot.kernels.matching import along, at
from riot.types import FloatArray

Side = Literal["p", "q"]

_SAMPLES = 24
"""Points of a pulled stretch, at least, beside those that it has."""

_HINGE_SHARE = 0.02
"""Share of an arc at either end that is not pulled: there is the hinge."""


def pull(
    dissected: DissectedPlan, side: Side, pins: Sequence[Pin], at_point: FloatArray, to: FloatArray, reach: float
) -> tuple[Pin, ...]:
    """Pins of one side with one more: the boundary at a point (2,) is pulled to another, with what is near it.

    The stretch within ``reach`` along the outline follows, the less the farther, up to the next hinge. Raises
    `riot.errors.PinError` as `add_line`.

    >>> from riot.construction import alternatives, dissect_plan
    >>> from riot.parameters import ConstructParameters
    >>> dissected = dissect_plan(alternatives(house, kite)[0], ConstructParameters())
    >>> ridge = house.points[house.points[:, 1].argmax()]
    >>> pins = pull(dissected, "p", (), ridge, ridge + [0.0, 0.02], 0.1)
    >>> bool(abs(pins[0].points - ridge - [0.0, 0.02]).sum(axis=1).min() < 0.01)
    True
    """
    dissection, outer, name = dissected.facing(side)
    outline = edited_outline(dissection, outer, pins, name)
    position = outline.position(at_point, "the pulled point")
    cell = int(np.searchsorted(outline.starts, position, side="right")) - 1
    cell = min(cell, len(outline.arcs) - 1)
    arc, lengths = outline.arcs[cell], outline.lengths[cell]
    middle = position - float(outline.starts[cell])
    margin = _HINGE_SHARE * float(lengths[-1])
    low, high = max(middle - reach, margin), min(middle + reach, float(lengths[-1]) - margin)
    low, high = min(low, middle), max(high, middle)
    inside = lengths[(lengths > low) & (lengths < high)]
    positions = np.unique(np.concatenate([np.linspace(low, high, _SAMPLES), inside, [middle]]))
    positions = positions[np.append(True, np.diff(positions) > MERGE_DISTANCE)]
    points = at(arc, lengths, positions)
    ahead = np.where(positions >= middle, high - middle, middle - low)
    share = np.divide(np.abs(positions - middle), ahead, out=np.ones_like(positions), where=ahead > 0.0)
    moved = points + ((1.0 - share**2) ** 2)[:, None] * (to - at(arc, lengths, np.array([middle]))[0])
    return add_line(dissected, side, pins, moved)


def add_line(dissected: DissectedPlan, side: Side, pins: Sequence[Pin], line: FloatArray) -> tuple[Pin, ...]:
    """Pins of one side with one more drawn line (k, 2); with another line on the same piece it becomes one.

    Raises `riot.errors.PinError` if the line cannot be drawn there.

    >>> from riot.construction import alternatives, dissect_plan
    >>> from riot.parameters import ConstructParameters
    >>> dissected = dissect_plan(alternatives(house, kite)[0], ConstructParameters())
    >>> ridge = house.points[house.points[:, 1].argmax()]
    >>> pins = pull(dissected, "p", (), ridge, ridge + [0.0, 0.02], 0.1)
    >>> len(add_line(dissected, "p", pins, pins[0].points[2:-2] * 1.01))  # on the same piece
    1
    """
    dissection, outer, name = dissected.facing(side)
    outline, sections = _edited(dissection, outer, pins, name)
    drawn = Pin(np.asarray(line, dtype=np.float64), drawn=True)
    arc, section = drawn_section(outline, drawn, f"the line drawn on {name}")
    before = sections.get(section.cell)
    if before is None:
        return (*pins, drawn)
    number, old = before
    growth = float(along(arc)[-1] - outline.lengths[section.cell][-1])
    start, stop = min(old.start, section.start), max(old.stop + growth, section.stop)
    inner, outside = outline.edges[section.cell]
    lengths = along(arc)
    inside = lengths[(lengths > start) & (lengths < stop)]
    joined = at(arc, lengths, np.concatenate([[start], inside, [stop]]))
    pin = Pin(carried(joined, inner, outside), drawn=True)
    return tuple(pin if k == number else other for k, other in enumerate(pins))


def edited_outline(dissection: Dissection, outer: FloatArray, pins: Sequence[Pin], name: str) -> PlacedOutline:
    """The outline as it is with the lines that are drawn on it already; arguments as of
    `riot.construction.pinned_paths.pinned_paths`."""
    return _edited(dissection, outer, pins, name)[0]


def _edited(
    dissection: Dissection, outer: FloatArray, pins: Sequence[Pin], name: str
) -> tuple[PlacedOutline, dict[int, tuple[int, PinnedSection]]]:
    """The outline as it is, with the lines that are drawn on it already, and by cell their pins and sections."""
    arcs, sections = list(dissection.paths), dict[int, tuple[int, PinnedSection]]()
    for k, pin in enumerate(pins):
        if pin.drawn:
            arc, section = drawn_section(PlacedOutline(dissection, outer, arcs), pin, f"pin {k} of {name}")
            arcs[section.cell] = arc
            sections[section.cell] = k, section
    return PlacedOutline(dissection, outer, arcs), sections
