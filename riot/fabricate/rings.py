"""Rings around a hinge's axis, and slopes that print without supports, as stairs of the printer's layers. Ours."""

from __future__ import annotations

import math
from dataclasses import dataclass

from riot.fabricate.tuning import HEIGHT_DIGITS, SLOPE


@dataclass(frozen=True)
class Ring:
    """What lies around a hinge's axis between two heights: a disc with a hole, or none, and a slit, or none.

    ``low``, ``high``, ``radius``, ``hole`` (radius) and ``slit`` (width, along the piece's edge) in mm. The hole is
    round, or a regular polygon of so many ``sides`` around that circle.
    """

    low: float
    high: float
    radius: float
    hole: float = 0.0
    slit: float = 0.0
    sides: int = 0


def taper(low: float, first: float, last: float, layer: float) -> list[Ring]:
    """A layer's ring on another from height ``low`` up, each wider or narrower by `SLOPE` of its height at most.

    The lowest differs from ``first`` by one step, the highest has the radius ``last``.

    >>> [(ring.low, ring.radius) for ring in taper(8.0, 2.4, 2.76, 0.2)]
    [(8.0, 2.52), (8.2, 2.64), (8.4, 2.76)]
    """
    count = steps(last - first, layer)
    return [
        Ring(
            round(low + k * layer, 9),
            round(low + (k + 1) * layer, 9),
            round(first + (k + 1) / count * (last - first), 9),
        )
        for k in range(count)
    ]


def steps(width: float, layer: float) -> int:
    """How many layers a slope takes to go so far sideways, mm.

    >>> steps(-0.5, 0.2)
    4
    """
    return math.ceil(round(abs(width) / (SLOPE * layer), HEIGHT_DIGITS))


def whole_layers(length: float, layer: float) -> float:
    """A length in whole layers, not less than asked for, mm.

    >>> whole_layers(0.5, 0.2)
    0.6
    """
    return round(math.ceil(round(length / layer, HEIGHT_DIGITS)) * layer, 9)
