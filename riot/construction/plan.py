"""Plan a construction: corresponding trunks, made conjugate, with both outlines' arcs swung in (theory §7, §8)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from riot.construction.conjugate import is_convex, make_conjugate
from riot.errors import ConstructionError
from riot.geometry.polyline import arc_length, trunk_angles
from riot.geometry.shape import Shape
from riot.kernels.change import feet, least_changes, placed_arcs
from riot.parameters import RefineParameters
from riot.transform.pose import Placement
from riot.transform.transform import Piece, Transform
from riot.types import FloatArray, IntArray
from riot.units import L_C

if TYPE_CHECKING:  # a plan computes nothing with it
    from riot.geometry.bend import Bend

WindowedOutlines = tuple[FloatArray, IntArray, FloatArray, IntArray]
"""Outline and windows of P, of Q, as `riot.kernels.change.least_changes` reads them."""


@dataclass(frozen=True, eq=False)
class TrunkPair:
    """Corresponding trunks of two outlines.

    Parameters
    ----------
    p, q : Shape
        The inputs, or what they were bent to.
    outline_p, outline_q : (m, 2) float64
        Their outlines, with the trunk vertices among the points.
    trunk_p, trunk_q : (n,) int64
        Trunk vertices among those points, in corresponding order: counter-clockwise on P, clockwise on Q.
    reach : float
        How far along the outline from its trunk vertex the point may lie where two arcs part, in units of ``L_c``;
        never farther than half-way to the next trunk vertex.
    bend_p, bend_q : Bend, optional
        What was done to the inputs, where they were bent to ``p`` and ``q``.
    """

    p: Shape
    q: Shape
    outline_p: FloatArray
    outline_q: FloatArray
    trunk_p: IntArray
    trunk_q: IntArray
    reach: float = RefineParameters.reach
    bend_p: Bend | None = None
    bend_q: Bend | None = None

    @cached_property
    def corners(self) -> FloatArray:
        """(2, n, 2) the trunk vertices on P and on Q."""
        return np.stack([self.outline_p[self.trunk_p], self.outline_q[self.trunk_q]])

    @cached_property
    def windowed_outlines(self) -> WindowedOutlines:
        """Outline and windows of P, of Q, as `riot.kernels.change.least_changes` reads them."""
        # Read-only arrays would have the kernels compiled once more.
        p, q = np.array(self.outline_p), np.array(self.outline_q)
        return p, _windows(p, self.trunk_p, self.reach * L_C), q, _windows(q, self.trunk_q[::-1], self.reach * L_C)


@dataclass(frozen=True, eq=False)
class ConstructionPlan:
    """A trunk pair made conjugate, and how close to the inputs an exact construction on it can come.

    Parameters
    ----------
    pair : TrunkPair
    trunks : (2, n, 2) float64
        T in P's frame, counter-clockwise, and T̄ in Q's, clockwise, conjugate and in corresponding order. Their corners
        need not lie on the outlines: where one is off, the two arcs that meet there reach it by a straight connector.
    bound_p, bound_q : float
        The highest IoU with P and with Q that an exact construction on these trunks can have (theory §8); the
        partition reaches it.
    """

    pair: TrunkPair
    trunks: FloatArray
    bound_p: float
    bound_q: float

    @property
    def bound(self) -> float:
        """Of the worse shape."""
        return min(self.bound_p, self.bound_q)

    @property
    def trunk_p(self) -> FloatArray:
        """(n, 2) T, counter-clockwise, in P's frame."""
        return np.array(self.trunks[0])

    @property
    def trunk_q(self) -> FloatArray:
        """(n, 2) T̄, clockwise, in Q's frame."""
        return np.array(self.trunks[1])

    @cached_property
    def arcs_p(self) -> FloatArray:
        """(s, 2) P's arcs in T̄, in Q's frame: from ``offsets_p[i]`` on arc i, from corner i to corner i + 1 of T̄."""
        return self._swung_p[0]

    @cached_property
    def offsets_p(self) -> IntArray:
        """(n + 1,) where each of P's arcs starts."""
        return self._swung_p[1]

    @cached_property
    def arcs_q(self) -> FloatArray:
        """(s, 2) Q's arcs in T, in P's frame: arc i from corner n − i − 1 to corner n − 2 − i of T (mod n)."""
        return self._swung_q[0]

    @cached_property
    def offsets_q(self) -> IntArray:
        """(n + 1,) where each of Q's arcs starts."""
        return self._swung_q[1]

    @cached_property
    def feet(self) -> FloatArray:
        """(2, n, 2) where the arcs part: the boundary points of P and of Q nearest to the corners."""
        return feet_of(self.pair.windowed_outlines, self.trunks)

    @cached_property
    def _swung_p(self) -> tuple[FloatArray, IntArray]:
        outline, windows, _, _ = self.pair.windowed_outlines
        return _swing(outline, windows, self.trunk_p, self.trunk_q)

    @cached_property
    def _swung_q(self) -> tuple[FloatArray, IntArray]:
        _, _, outline, windows = self.pair.windowed_outlines
        return _swing(outline, windows, self.trunk_q[::-1].copy(), self.trunk_p[::-1].copy())

    def assembled(self, pieces: Sequence[Piece], trunk_p: FloatArray, trunk_q: FloatArray) -> Transform:
        """The transform of the n pieces in chain order; ``trunk_p``, ``trunk_q`` (n, 2) are where the arcs part."""
        return Transform(
            pieces=tuple(pieces),
            angles=trunk_angles(self.trunk_p),
            conjugate_angles=trunk_angles(self.trunk_q),
            place_p=Placement.of(self.trunk_p),
            place_q=Placement.of(self.trunk_q),
            p=self.pair.p,
            q=self.pair.q,
            trunk_p=trunk_p,
            trunk_q=trunk_q,
            bound_p=self.bound_p,
            bound_q=self.bound_q,
            bend_p=self.pair.bend_p,
            bend_q=self.pair.bend_q,
        )


def feet_of(outlines: WindowedOutlines, trunks: FloatArray) -> FloatArray:
    """(2, n, 2) the boundary points of P and of Q nearest to the corners of ``trunks`` (2, n, 2)."""
    p, windows_p, q, windows_q = outlines
    return np.stack([feet(p, windows_p, trunks[0].copy())[0], feet(q, windows_q, trunks[1, ::-1].copy())[0][::-1]])


def plan_pair(pair: TrunkPair, lines: int = RefineParameters.bound_lines) -> ConstructionPlan:
    """Make the trunks conjugate with the least movement of their vertices, and bound the IoU by so many scanlines.

    Raises ConstructionError if the trunks cannot be made conjugate and convex.

    >>> from riot import Shape
    >>> house = Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)])
    >>> kite = Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)])
    >>> from riot.construction import alternatives
    >>> pair = alternatives(house, kite)[0].pair
    >>> 0.0 < plan_pair(pair).bound < 1.0
    True
    """
    for name, trunk in (("P", pair.corners[0]), ("Q", pair.corners[1, ::-1])):
        if not is_convex(trunk):
            raise ConstructionError("not-convex", f"the trunk of {name} is not convex")
    return plan_on(pair, np.stack(make_conjugate(*pair.corners)), lines)


def plan_on(pair: TrunkPair, trunks: FloatArray, lines: int) -> ConstructionPlan:
    """The plan on conjugate ``trunks`` (2, n, 2), its bounds by so many scanlines."""
    (bound_p, bound_q), _ = least_changes(*pair.windowed_outlines, trunks, lines)
    return ConstructionPlan(pair, trunks, float(bound_p), float(bound_q))


def _swing(
    outline: FloatArray, windows: IntArray, source: FloatArray, target: FloatArray
) -> tuple[FloatArray, IntArray]:
    n = len(source)
    # The most that the kernel fills.
    arcs, offsets = np.empty((len(outline) + 5 * n, 2)), np.empty(n + 1, dtype=np.int64)
    total = placed_arcs(outline, windows, source, target, arcs, offsets)
    return arcs[:total].copy(), offsets


def _windows(outline: FloatArray, trunk: IntArray, reach: float) -> IntArray:
    """(n, 2) first and last vertex of the section where each corner's foot is looked for; trunk vertices ascend."""
    m, n = len(outline), len(trunk)
    lengths = arc_length(outline)
    windows = np.empty((n, 2), dtype=np.int64)
    for i, vertex in enumerate(trunk):
        along = (lengths[:-1] - lengths[vertex]) % lengths[-1]
        ahead = min(reach, 0.5 * along[trunk[(i + 1) % n]])
        behind = min(reach, 0.5 * (lengths[-1] - along[trunk[i - 1]]))
        windows[i, 0] = (vertex - np.count_nonzero(along >= lengths[-1] - behind)) % m
        windows[i, 1] = (vertex + np.count_nonzero(along <= ahead) - 1) % m
    return windows
