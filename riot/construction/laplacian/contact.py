"""Where the arcs in a trunk meet, overlap and leave gaps (paper §4.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from riot.construction.laplacian.editing import as_complex, as_points
from riot.construction.laplacian.residual import Residual, residual
from riot.construction.tuning import CONTACT_DISTANCE
from riot.kernels.laplacian import ComplexArray, meet
from riot.types import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class TrunkArcs:
    """The arcs in one trunk, and the distances of every vertex to every arc; the arrays' contents change.

    Parameters
    ----------
    trunk : (n, 2) float64
        Convex, clockwise.
    points : (s + n + 1,) complex128
        Arc i runs from corner i to corner i + 1, its piece on its left; the trunk's own outline comes last, as arc n.
    offsets : (n + 2,) int64
    owner : (s,) int64
        Arc of each vertex.
    ends : (s,) bool
        Whether it lies on a corner of the trunk.
    distance, foot, inside, ahead, ahead_foot : (s, n + 1)
        See `riot.kernels.laplacian.meet`.
    """

    trunk: FloatArray
    points: ComplexArray
    offsets: IntArray
    owner: IntArray
    ends: BoolArray
    distance: FloatArray
    foot: ComplexArray
    inside: BoolArray
    ahead: FloatArray
    ahead_foot: ComplexArray

    @classmethod
    def of(cls, trunk: FloatArray, arcs: list[FloatArray]) -> TrunkArcs:
        """Arcs (m_i, 2) each, whose end points are the trunk's corners."""
        outline = np.concatenate([trunk, trunk[:1]])
        sizes = np.array([len(arc) for arc in arcs])
        offsets = np.concatenate([[0], np.cumsum(sizes), [sizes.sum() + len(outline)]]).astype(np.int64)
        count, columns = int(sizes.sum()), len(arcs) + 1
        ends = np.zeros(count, dtype=np.bool_)
        ends[offsets[:-2]] = ends[offsets[1:-1] - 1] = True
        trunk_arcs = cls(
            trunk,
            as_complex(np.concatenate([*arcs, outline])),
            offsets,
            np.repeat(np.arange(len(arcs)), sizes),
            ends,
            np.full((count, columns), np.inf),
            np.zeros((count, columns), dtype=np.complex128),
            np.zeros((count, columns), dtype=np.bool_),
            np.full((count, columns), np.inf),
            np.zeros((count, columns), dtype=np.complex128),
        )
        trunk_arcs.renew(-1)
        return trunk_arcs

    def __len__(self) -> int:
        return len(self.offsets) - 2

    def span(self, i: int) -> slice:
        """Vertices of arc i."""
        return slice(int(self.offsets[i]), int(self.offsets[i + 1]))

    def arc(self, i: int) -> FloatArray:
        """(m_i, 2) points of arc i."""
        return as_points(self.points[self.span(i)])

    def renew(self, changed: int) -> None:
        """Arc ``changed`` has changed; −1: all of them."""
        tables = self.distance, self.foot, self.inside, self.ahead, self.ahead_foot
        meet(self.points, self.offsets, self.owner, changed, *tables)

    def overlaps(self) -> tuple[FloatArray, ComplexArray]:
        """Of each vertex (s,): how deep it lies in another piece or outside the trunk, and the nearest point where it
        would not; 0 of a vertex that does neither."""
        wrong = self.inside.copy()
        wrong[:, -1] = ~wrong[:, -1]
        depth = np.where(wrong, self.distance, 0.0)
        depth[self.ends] = 0.0
        return self._most(depth, self.foot)

    def gaps(self) -> tuple[FloatArray, ComplexArray]:
        """Of each vertex (s,): how wide the gap before it is, and the nearest point of another arc across it; 0 where
        the vertex lies in another piece, or an arc touches it."""
        ahead = self.ahead[:, :-1]
        column = ahead.argmin(axis=1)
        rows = np.arange(len(ahead))
        width = ahead[rows, column]
        width[self.ends | self.inside[:, :-1].any(axis=1) | ~np.isfinite(width)] = 0.0
        return width, self.ahead_foot[rows, column]

    def contact(self, *, trunk: bool) -> BoolArray:
        """(s,) vertices that touch another arc; with ``trunk``, also those that touch the trunk's edges."""
        columns = self.distance if trunk else self.distance[:, :-1]
        return np.asarray((columns < CONTACT_DISTANCE).any(axis=1))

    def residual(self, lines: int) -> Residual:
        """The areas, by so many scanlines."""
        last = int(self.offsets[-2])
        return residual(self.trunk, as_points(self.points[:last]), self.offsets[:-1], lines)

    @staticmethod
    def _most(depth: FloatArray, foot: ComplexArray) -> tuple[FloatArray, ComplexArray]:
        column = depth.argmax(axis=1)
        rows = np.arange(len(depth))
        return depth[rows, column], foot[rows, column]
