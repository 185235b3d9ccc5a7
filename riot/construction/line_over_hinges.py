"""Draw a line over hinges: it is led through them, and every piece gets its part of it (theory §8). Ours.

A hinge stays where it is. Beside it the outline of both pieces is one and the same cut, swung to either side: what is
drawn on one of them decides the other, as far as that cut reaches. So the longest part is drawn first, and of the
others those that do not contradict it.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import shapely

from riot.construction.dissected_plan import DissectedPlan
from riot.construction.drawn_lines import Side, add_line, edited_outline
from riot.construction.pinned_stretch import PinnedStretch, with_pins
from riot.construction.pins import Pins
from riot.construction.placed_outline import PlacedOutline
from riot.construction.tuning import HINGE_REACH, SECTION_SLACK
from riot.errors import PinError
from riot.kernels.matching import along, at
from riot.types import FloatArray

_SAME_CUT = "on the other side of the hinge the outline is the same cut, and follows from it"


def draw_stretch(
    dissected: DissectedPlan,
    side: Side,
    pins: Pins,
    line: FloatArray,
    stored: Callable[[FloatArray], FloatArray] = lambda points: points,
) -> PinnedStretch:
    """Draw a line (k, 2) from one point of the outline of P or Q (``side``) to another, beside other ``pins``.

    ``stored`` as of `riot.construction.pinned_stretch.keep_stretch`. Raises `riot.errors.PinError` with the places if
    no part of it can be drawn, or a hinge is too far from it.

    >>> from riot.construction import Pins, alternatives, dissect_plan
    >>> from riot.parameters import ConstructParameters
    >>> dissected = dissect_plan(alternatives(house, kite)[0], ConstructParameters())
    >>> outline = dissected.transform().outline_p()
    >>> len(draw_stretch(dissected, "p", Pins(), outline[1:4]).pins.p)
    1
    """
    drawn = pins.p if side == "p" else pins.q
    dissection, outer, name = dissected.facing(side)
    parts = _parted(edited_outline(dissection, outer, drawn, name), line, f"the line drawn on {name}")
    lost, refusal, met = list[FloatArray](), None, pins
    for part in sorted(parts, key=lambda part: -float(along(part)[-1])):
        try:
            tried = with_pins(pins, side, add_line(dissected, side, met.p if side == "p" else met.q, stored(part)))
            dissected.transform(tried)
        except PinError as error:
            lost.append(part)
            refusal = refusal or (error if error.points else error.at(part)).on(error.side or side)
            continue
        met = tried
    if refusal is not None and met is pins:
        raise refusal
    return PinnedStretch(met, np.concatenate([np.empty((0, 2)), *lost]), _SAME_CUT if lost else "")


def _parted(outline: PlacedOutline, line: FloatArray, label: str) -> list[FloatArray]:
    """The parts of a line between hinges, led through these; the line alone if there is none between its ends."""
    start, stop, forwards = outline.shorter_way([outline.position(line[k], label) for k in (0, -1)])
    total = float(outline.starts[-1])
    hinges = [
        (float(first) + turn * total, arc[0])
        for turn in (0, 1)
        for first, arc in zip(outline.starts[:-1], outline.arcs, strict=True)
        if start + SECTION_SLACK < first + turn * total < stop - SECTION_SLACK
    ]
    if not hinges:
        return [line]
    line = line if forwards else line[::-1]
    points = [hinge for _, hinge in sorted(hinges, key=lambda item: item[0])]
    lengths = along(line)
    nearest = [float(shapely.line_locate_point(shapely.LineString(line), shapely.Point(hinge))) for hinge in points]
    passes = np.array([0.0, *nearest, lengths[-1]])
    missed = [
        hinge
        for hinge, length in zip(points, nearest, strict=True)
        if np.hypot(*(at(line, lengths, np.array([length]))[0] - hinge)) > HINGE_REACH
    ]
    if missed or (np.diff(passes) < SECTION_SLACK).any():
        raise PinError(f"{label} leaves out a hinge, which stays where it is: draw it through the marked point").at(
            missed or points
        )
    positions = np.unique(np.concatenate([lengths, passes]))
    led = at(line, lengths, positions)
    for k, hinge in enumerate(points, start=1):
        reach = np.where(positions < passes[k], passes[k] - passes[k - 1], passes[k + 1] - passes[k])
        share = np.minimum(np.abs(positions - passes[k]) / reach, 1.0)
        led += ((1.0 - share**2) ** 2)[:, None] * (hinge - at(line, lengths, passes[k : k + 1])[0])
        led[positions == passes[k]] = hinge
    cuts = np.searchsorted(positions, passes)
    return [led[first : last + 1] for first, last in pairwise(cuts.tolist())]
