"""A plan with both its trunks dissected once, so that pieces can be cut again with other pins (theory §8). Ours."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import shapely

from riot.construction.contact import backwards
from riot.construction.dissection import Dissection, dissect
from riot.construction.pinned_paths import pinned_paths
from riot.construction.pins import Pins
from riot.errors import PinError
from riot.geometry.polyline import edge_lengths
from riot.parameters import ConstructParameters, DetailParameters
from riot.transform.certificate import certify
from riot.transform.pose import rotate
from riot.transform.transform import Piece, Transform
from riot.types import FloatArray

if TYPE_CHECKING:
    from riot.construction.plan import ConstructionPlan


@dataclass(frozen=True, eq=False)
class DissectedPlan:
    """A plan with its two trunks dissected.

    Parameters
    ----------
    plan : ConstructionPlan
    lower, upper : Dissection
        Of Q's trunk by P's arcs, and of P's trunk by Q's, as they are dissected: counter-clockwise.
    """

    plan: ConstructionPlan
    lower: Dissection
    upper: Dissection

    def transform(self, pins: Pins | None = None) -> Transform:
        """Cut the pieces. Raises `riot.errors.PinError` if a pin cannot be met.

        Without pins, the detail of a tree gives way to its middle lines where only these unfold without crossings. With
        pins nothing gives way: the certificate says whether the pieces tile both shapes.
        """
        if pins:
            return self._pinned(pins)
        transform = self._cut(self.lower.paths, self.upper.paths)
        if certify(transform).passed:
            return transform
        for lower, upper in (
            (self.lower.plain_paths, self.upper.paths),
            (self.lower.paths, self.upper.plain_paths),
            (self.lower.plain_paths, self.upper.plain_paths),
        ):
            transform = self._cut(lower, upper)
            if certify(transform).passed:
                break
        return transform

    def facing(self, side: str) -> tuple[Dissection, FloatArray, str]:
        """The dissection in which the outline of P or Q (``side``) lives, the trunk around which it lies, its name.

        >>> from riot.construction import alternatives
        >>> dissected = dissect_plan(alternatives(house, kite)[0], ConstructParameters())
        >>> dissected.facing("p")[2]
        'house'
        """
        plan = self.plan
        if side == "p":
            return self.lower, plan.trunk_p[::-1], plan.pair.p.name or "P"
        return self.upper, plan.trunk_q, plan.pair.q.name or "Q"

    def _pinned(self, pins: Pins) -> Transform:
        paths = []
        for side, of_side in (("p", pins.p), ("q", pins.q)):
            dissection, outer, name = self.facing(side)
            try:
                paths.append(pinned_paths(dissection, outer, of_side, name))
            except PinError as error:
                raise error.on(side) from None
        transform = self._cut(*paths)
        if not certify(transform).passed:
            message = f"with these pins the pieces do not unfold ({certify(transform).failure}): move them, or pin less"
            side, crossing = _crossing(transform)
            raise PinError(message, None, crossing, side)
        return transform

    def _cut(self, lower: Sequence[FloatArray], upper: Sequence[FloatArray]) -> Transform:
        plan = self.plan
        n = len(plan.trunk_p)
        lengths = 0.5 * (edge_lengths(plan.trunk_p) + edge_lengths(plan.trunk_q))
        pieces = []
        for i in range(n):
            # Corner i + 1 of Q's trunk in corresponding order is corner n − 2 − i of it read backwards.
            below = lower[(n - 2 - i) % n][::-1]
            above = upper[i][::-1]
            pieces.append(
                Piece(
                    float(lengths[i]),
                    _in_piece_frame(below, plan.trunk_q[i], plan.trunk_q[(i + 1) % n], float(lengths[i])),
                    _in_piece_frame(above, plan.trunk_p[i], plan.trunk_p[(i + 1) % n], float(lengths[i])),
                )
            )
        return plan.assembled(pieces, *plan.feet)


def dissect_plan(
    plan: ConstructionPlan, parameters: ConstructParameters, detail: DetailParameters | None = None
) -> DissectedPlan:
    """Dissect both trunks of a plan (theory §8, ours). Raises ConstructionError with the reason if a partition fails.

    >>> from riot import Shape, alternatives
    >>> house = Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)])
    >>> kite = Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)])
    >>> dissected = dissect_plan(alternatives(house, kite)[0], ConstructParameters())
    >>> len(dissected.transform())  # pieces
    4
    """
    # A dissection is made in a counter-clockwise trunk, region k on the edge from corner k to corner k + 1.
    lower, upper = backwards(plan.arcs_p, plan.offsets_p), backwards(plan.arcs_q, plan.offsets_q)
    return DissectedPlan(
        plan,
        dissect(plan.trunk_q[::-1], lower, parameters, "Q's trunk", detail),
        dissect(plan.trunk_p, upper, parameters, "P's trunk", detail),
    )


def _crossing(transform: Transform) -> tuple[str, tuple[tuple[float, float], ...]]:
    """The side whose outline crosses itself, and where; nothing if none does."""
    for side, outline in (("p", transform.outline_p()), ("q", transform.outline_q())):
        place = re.search(r"\[(\S+) (\S+)\]", shapely.is_valid_reason(shapely.Polygon(outline)))
        if place:
            return side, ((float(place[1]), float(place[2])),)
    return "", ()


def _in_piece_frame(path: FloatArray, start: FloatArray, stop: FloatArray, length: float) -> FloatArray:
    """Move a path from ``start`` to ``stop``, or back, so that these lie at (0, 0) and (length, 0), exactly."""
    edge = stop - start
    moved = rotate(path - start, -math.atan2(edge[1], edge[0]))
    ends = np.array([[0.0, 0.0], [length, 0.0]])
    forwards = abs(moved[0, 0]) < 0.5 * length
    moved[0], moved[-1] = (ends[0], ends[1]) if forwards else (ends[1], ends[0])
    return moved
