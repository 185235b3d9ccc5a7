"""Keep a stretch of an outline as far as the trunks have room for it (theory §8). Ours."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from riot.construction.dissected_plan import DissectedPlan
from riot.construction.drawn_lines import Side
from riot.construction.pinned_paths import kept_sections
from riot.construction.pins import Pin, Pins
from riot.construction.placed_outline import PinnedSection, PlacedOutline
from riot.construction.tuning import KEEP_TRIES, KEPT_POINT_REACH, PIN_POSITION_SLACK, PIN_TOLERANCE
from riot.errors import PinError
from riot.kernels.matching import along, at
from riot.types import BoolArray, FloatArray

_OUTSIDE = "it would reach beyond the trunk that its piece swings into"
_COVERED = "another piece lies there"


@dataclass(frozen=True, eq=False)
class PinnedStretch:
    """What can be pinned of a stretch.

    Parameters
    ----------
    pins : Pins
        Those of before and what can be met, one pin for every connected part of it.
    lost : (k, 2) float64
        Where it cannot be met, in the frame of the pins; empty if all of it can.
    reason : str
        Why not; empty if all of it can.
    """

    pins: Pins
    lost: FloatArray
    reason: str


def keep_stretch(
    dissected: DissectedPlan,
    side: Side,
    pins: Pins,
    points: FloatArray,
    stored: Callable[[FloatArray], FloatArray] = lambda points: points,
) -> PinnedStretch:
    """Keep the outline of P or Q (``side``) through points (k, 2), or what can be kept of it, beside other ``pins``.

    The trunks stay: what the other trunk does not hold, and where another piece must be, cannot be kept. ``stored``
    says what points become where pins are stored, since hardly other points may no longer be met.
    Raises `riot.errors.PinError` with the places if nothing can be kept.

    >>> from riot.construction import Pins, alternatives, dissect_plan
    >>> from riot.parameters import ConstructParameters
    >>> dissected = dissect_plan(alternatives(house, kite)[0], ConstructParameters())
    >>> kept = keep_stretch(dissected, "p", Pins(), house.points[house.points[:, 1].argmax()][None])
    >>> len(kept.pins.p), kept.reason
    (1, '')
    """
    whole = _with(pins, side, [stored(points)])
    if _missed(dissected, side, whole) is None:
        return PinnedStretch(whole, np.empty((0, 2)), "")
    dissection, outer, name = dissected.facing(side)
    outline = PlacedOutline(dissection, outer, dissection.arcs)
    wanted, places = _samples(outline, kept_sections(outline, Pin(points), f"the stretch to be kept of {name}"))
    reasons = [] if all(holds.all() for holds in places) else [_OUTSIDE]
    runs = [(k, *run) for k, holds in enumerate(places) for run in _runs(wanted[k], holds)]
    kept = list[tuple[int, int, int]]()
    for _ in range(KEEP_TRIES):
        if not runs:
            break
        runs.sort(key=lambda run: run[1] - run[2])
        k, first, last = runs.pop(0)
        tried = [*kept, (k, first, last)]
        missed = _missed(
            dissected, side, _with(pins, side, [stored(wanted[i][start:stop]) for i, start, stop in tried])
        )
        if missed is None:
            kept = tried
            continue
        stays = shapely.distance(missed, shapely.points(wanted[k][first:last])) > PIN_TOLERANCE
        parts = _runs(wanted[k][first:last], stays)
        if not stays.any():
            middle = (last - first) // 2  # what is too much at once may do by halves
            parts = [
                part for part in ((0, middle), (middle, last - first)) if _is_long(wanted[k][first:last][slice(*part)])
            ]
        reasons = [*dict.fromkeys([*reasons, _COVERED])]
        runs += [(k, first + start, first + stop) for start, stop in parts]
    lost = [np.ones(len(placed), dtype=np.bool_) for placed in wanted]
    for k, first, last in kept:
        lost[k][first:last] = False
    rest = np.concatenate([placed[is_lost] for placed, is_lost in zip(wanted, lost, strict=True)])
    why = ", and ".join(reasons) if len(rest) else ""
    if not kept:
        raise PinError(f"this stretch of {name} cannot be kept: {why}; other trunks may have room", None, (), side).at(
            rest
        )
    return PinnedStretch(_with(pins, side, [stored(wanted[k][first:last]) for k, first, last in kept]), rest, why)


def _samples(outline: PlacedOutline, sections: Sequence[PinnedSection]) -> tuple[list[FloatArray], list[BoolArray]]:
    """Points (k, 2) along every section, on the outline, and which of them (k,) the trunk holds."""
    trunk = shapely.Polygon(outline.trunk).buffer(PIN_POSITION_SLACK)
    placed, held = list[FloatArray](), list[BoolArray]()
    for section in sections:
        lengths, positions = outline.lengths[section.cell], outline.checks(section)
        placed.append(at(outline.arcs[section.cell], lengths, positions))
        inner = at(outline.inner_arcs[section.cell], lengths, positions)
        held.append(shapely.covers(trunk, shapely.points(inner)))
    return placed, held


def _runs(points: FloatArray, stays: BoolArray) -> list[tuple[int, int]]:
    """First and last, exclusive, of the runs of points (k, 2) that stay, but for parts hardly longer than a kept
    point."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], stays, [False]]).astype(np.int8)))
    runs = zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    return [run for run in runs if run == (0, len(points)) or _is_long(points[slice(*run)])]


def _is_long(points: FloatArray) -> bool:
    return len(points) > 1 and float(along(points)[-1]) >= KEPT_POINT_REACH


def with_pins(pins: Pins, side: Side, of_side: tuple[Pin, ...]) -> Pins:
    """The pins with others of one side.

    >>> with_pins(Pins(), "q", (Pin(house.points),)).p
    ()
    """
    return replace(pins, p=of_side) if side == "p" else replace(pins, q=of_side)


def _with(pins: Pins, side: Side, stretches: Sequence[FloatArray]) -> Pins:
    """The pins with these stretches (k, 2) of one side kept, too."""
    return with_pins(pins, side, (*(pins.p if side == "p" else pins.q), *map(Pin, stretches)))


def _missed(dissected: DissectedPlan, side: Side, pins: Pins) -> shapely.MultiPoint | None:
    """Where the last pin of one side is missed, anywhere if it is at the cost of another; None if all are met."""
    of_side = pins.p if side == "p" else pins.q
    try:
        dissected.transform(pins)
    except PinError as error:
        own = error.side == side and error.pin == len(of_side) - 1
        return shapely.MultiPoint(error.points if own else of_side[-1].points)
    return None
