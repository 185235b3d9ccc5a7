"""Measure gaps, overlaps and outside of the pieces in either trunk, whether they tile it or not (theory §6, ours)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from riot.construction.tuning import RESIDUAL_LINES
from riot.kernels.coverage import uncovered
from riot.transform.pose import Pose
from riot.transform.transform import Transform
from riot.types import FloatArray, IntArray


@dataclass(frozen=True)
class Residual:
    """Areas that the pieces of one trunk cover wrongly; see `riot.kernels.coverage`."""

    gaps: float
    overlaps: float
    outside: float

    @property
    def total(self) -> float:
        """All three together: d_A of the trunk."""
        return self.gaps + self.overlaps + self.outside


def residual(trunk: FloatArray, arcs: FloatArray, offsets: IntArray, lines: int = RESIDUAL_LINES) -> Residual:
    """Measure arcs (s, 2) with ``offsets`` (n + 1,) in a convex trunk (n, 2), each piece on its arc's left.

    By scanlines and winding numbers, so that arcs may cross each other and themselves.
    """
    areas = uncovered(np.ascontiguousarray(trunk), np.ascontiguousarray(arcs), offsets, lines)
    return Residual(*map(float, areas))


def residuals(transform: Transform, lines: int = RESIDUAL_LINES) -> tuple[Residual, Residual]:
    """Measure Q's arcs in P's trunk, the chain closed as P, and P's arcs in Q's trunk, the chain closed as Q (ours).

    Areas of unit-area shapes, by so many scanlines; all 0 but for rounding where the transform is exact. Unlike the
    certificate's, they mean something where outlines cross.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> max(residual.total for residual in residuals(exact_transform(dudeney()))) < 1e-9
    True
    """
    p, q = transform.pose(0.0), transform.pose(1.0)
    return (
        _placed(p, [piece.upper for piece in transform.pieces], lines),
        _placed(q, [piece.lower for piece in transform.pieces], lines),
    )


def _placed(pose: Pose, arcs: list[FloatArray], lines: int) -> Residual:
    offsets = np.concatenate([[0], np.cumsum([len(arc) for arc in arcs])]).astype(np.int64)
    placed = np.concatenate([pose.place(i, arc) for i, arc in enumerate(arcs)])
    return residual(pose.origins, placed, offsets, lines)
