"""Make two trunks conjugate: equal corresponding edges at the least movement of their vertices (theory §7)."""

from __future__ import annotations

import numpy as np

from riot.construction.tuning import ACCEPTED_EDGE_DIFFERENCE, CONJUGATE_STEPS, EDGE_TOLERANCE, FULL_TURN_TOLERANCE
from riot.errors import ConstructionError
from riot.kernels.conjugate import conjugated, turns
from riot.types import FloatArray


def make_conjugate(trunk_p: FloatArray, trunk_q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Move two corresponding n-gons, (n, 2) each, least until |e_j| = |e'_j| for all j.

    ``trunk_p`` is counter-clockwise, ``trunk_q`` clockwise. Equality-constrained least squares over all 4n
    coordinates, by Gauss–Newton: every step goes to the point nearest to the start on the linearised constraints.
    Raises ConstructionError if that fails or leaves a trunk that is not strictly convex. Ours; the paper says only
    that it is done.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> trunk_p, trunk_q = make_conjugate(square, 1.1 * square[::-1])
    >>> (np.roll(trunk_p, -1, axis=0) - trunk_p)[0].round(9).tolist()  # both sides move half of the way
    [1.05, 0.0]
    """
    (conjugate_p, conjugate_q), worst = conjugated(np.stack([trunk_p, trunk_q]), EDGE_TOLERANCE, CONJUGATE_STEPS)
    if not worst <= ACCEPTED_EDGE_DIFFERENCE:
        raise ConstructionError(
            "not-conjugate", "the trunks could not be made conjugate: the iteration does not settle"
        )
    for name, trunk in (("P", conjugate_p), ("Q", conjugate_q[::-1])):
        if not is_convex(trunk):
            raise ConstructionError("not-convex", f"made conjugate, the trunk of {name} is no longer convex")
    return conjugate_p, conjugate_q


def is_convex(polygon: FloatArray) -> bool:
    """Whether an (n, 2) polygon is strictly convex, counter-clockwise and goes round once.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> is_convex(square), is_convex(square[::-1])
    (True, False)
    """
    least, turn = turns(np.ascontiguousarray(polygon))
    return bool(least > 0.0 and abs(turn - 2.0 * np.pi) < FULL_TURN_TOLERANCE)
