"""CRS: the cross-reversibility score of two shapes, best-first over their full trunks (paper §4.2, theory §6)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from riot.geometry.polyline import swept_area
from riot.geometry.shape import Shape
from riot.kernels.candidates import TrunkSide, Units, arrange, leaf_pairs, nearest_candidates, piece_areas
from riot.kernels.coverage import best_area_terms
from riot.parameters import CrsParameters
from riot.scores.trunks import Trunks, full_trunks
from riot.types import FloatArray, IntArray
from riot.units import D_C

FIRST_LISTED = 64
"""Candidates that are listed at first. Ours: any number gives the same result, this one few area terms."""

_MORE_LISTED = 4
"""Factor by which this grows each time: every list is a search of its own, of all trunks that are not out of reach."""

AREA_SLACK = 2e-3
"""Greatest error of the area term by scanlines, by which its cheap bound is lowered. Ours: above the greatest
difference from polygon overlay that tests find."""


@dataclass(frozen=True, eq=False)
class CrossScore:
    """CRS of one pair and the trunk pair that gives it.

    Parameters
    ----------
    score : float
        min(s_edge, s_angle, s_area); 0 if the shapes have no trunks of one n.
    trunk_a, trunk_b : (n,) int64
        Corresponding trunk vertices, indices into the shapes' points: ``trunk_a`` counter-clockwise, ``trunk_b``
        clockwise.
    s_edge, s_angle, s_area : float
        The three terms' scores (eqs. 3–5).
    area : float
        d_A, the worse of the two directions.
    evaluations : int
        How many area terms were evaluated to find it.
    """

    score: float
    trunk_a: IntArray
    trunk_b: IntArray
    s_edge: float
    s_angle: float
    s_area: float
    area: float
    evaluations: int

    @property
    def n(self) -> int:
        """Number of trunk vertices; 0 without a trunk pair."""
        return len(self.trunk_a)


NO_SCORE = CrossScore(0.0, np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), 0.0, 0.0, 0.0, math.inf, 0)
"""CRS of shapes that have no trunks of the same number of vertices."""


@dataclass(frozen=True, eq=False)
class CrossSide:
    """One shape with its trunks, prepared for CRS with others (`prepare`).

    ``points`` (m, 2), ``offsets`` (t + 1,) and ``vertices`` (s,) int64 are the shape's and the trunks', in memory of
    their own; ``side`` holds the trunks in the order of the search.
    """

    trunks: Trunks
    points: FloatArray
    offsets: IntArray
    vertices: IntArray
    side: TrunkSide


def crs(
    a: Shape,
    b: Shape,
    trunks_a: Trunks | None = None,
    trunks_b: Trunks | None = None,
    parameters: CrsParameters | None = None,
) -> CrossScore:
    """Cross-reversibility score of two shapes (paper §4.2); without trunks, `full_trunks` finds them.

    d_A exists in both directions, P's arcs in Q's trunk and Q's in P's; the worse one counts (ours). Among equal
    scores the first by (T, T', shift) wins.

    >>> from riot import Shape
    >>> house = Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)])
    >>> kite = Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)])
    >>> full = crs(house, kite)
    >>> round(full.score, 3), full.score == min(full.s_edge, full.s_angle, full.s_area)
    (0.951, True)
    """
    best = best_trunk_pairs(a, b, trunks_a, trunks_b, parameters, count=1)
    return best[0] if best else NO_SCORE


def best_trunk_pairs(
    a: Shape,
    b: Shape,
    trunks_a: Trunks | None = None,
    trunks_b: Trunks | None = None,
    parameters: CrsParameters | None = None,
    count: int = 1,
) -> list[CrossScore]:
    """The ``count`` trunk pairs of highest score, best first; fewer if fewer exist.

    Candidates are evaluated in order of a lower bound of their distance, until the bound passes the worst pair of a
    full list. So the result is that of evaluating all. Pairs of equal score are ordered by (T, T', shift). Raises
    ValueError if ``count`` < 1.

    >>> [score.n for score in best_trunk_pairs(house, kite, count=2)]
    [4, 4]
    """
    return best_of_prepared(prepare(a, trunks_a), prepare(b, trunks_b), parameters, count)


def prepare(shape: Shape, trunks: Trunks | None = None) -> CrossSide:
    """Prepare a shape and its trunks for `best_of_prepared`; without ``trunks``, `full_trunks` finds them.

    >>> len(prepare(house).trunks)
    1455
    """
    trunks = full_trunks(shape) if trunks is None else trunks
    # Read-only arrays would have the kernels compiled once more.
    points, vertices = np.array(shape.points), trunks.vertices.astype(np.int64)
    offsets, betas = np.array(trunks.offsets, dtype=np.int64), trunks.betas
    edges, alphas, areas = (np.array(values) for values in (trunks.edges, trunks.alphas, trunks.areas))
    pieces = piece_areas(points, swept_area(points), offsets, vertices)
    return CrossSide(trunks, points, offsets, vertices, arrange(offsets, edges, alphas, betas, pieces, areas))


def best_of_prepared(
    a: CrossSide, b: CrossSide, parameters: CrsParameters | None = None, count: int = 1
) -> list[CrossScore]:
    """The same as `best_trunk_pairs`, for shapes that `prepare` has prepared, once for all their pairs.

    >>> best = best_of_prepared(prepare(house), prepare(kite), count=2)
    >>> [round(score.score, 3) for score in best]
    [0.951, 0.951]
    """
    if count < 1:
        raise ValueError(f"best_trunk_pairs({count=}): ask for one pair at least")
    parameters = parameters or CrsParameters()
    units = Units(parameters.sigma_e * D_C, parameters.sigma_angle, parameters.sigma_area, AREA_SLACK)
    kept, kept_which = np.empty((count, 2)), np.empty((count, 3), dtype=np.int64)
    bounds, pairs = leaf_pairs(a.side, b.side, units)
    order = np.argsort(bounds, kind="stable")
    bounds, pairs = bounds[order], pairs[order]
    trunks = ((a.offsets, a.vertices), (b.offsets, b.vertices))
    capacity, number, evaluations = FIRST_LISTED, 0, 0
    above, limit = -math.inf, math.inf
    while True:
        candidates, which = np.empty((capacity, 2)), np.empty((capacity, 3), dtype=np.int64)
        listed, reached = nearest_candidates(a.side, b.side, units, bounds, pairs, above, limit, candidates, which)
        capacity *= _MORE_LISTED
        if listed < 0:
            continue
        order = np.argsort(candidates[:listed, 0], kind="stable")
        number, begun = best_area_terms(
            *(a.points, b.points, *trunks, order, candidates, which),
            *(parameters.sigma_area, parameters.lines, number, kept, kept_which),
        )
        evaluations += begun
        # Nothing beyond the worst of a full list can be among the best.
        limit = float(kept[-1, 0]) if number == count else math.inf
        if reached >= limit:
            break
        above = reached
    return _describe(a.trunks, b.trunks, parameters, kept_which[:number], kept[:number, 1], evaluations)


def _describe(
    trunks_a: Trunks, trunks_b: Trunks, parameters: CrsParameters, which: IntArray, areas: FloatArray, evaluations: int
) -> list[CrossScore]:
    """Scores of (k, 3) ``which`` (T, T', shift) with d_A ``areas`` (k,)."""
    sizes = trunks_a.sizes[which[:, 0]]
    edges, angles = np.empty(len(which)), np.empty(len(which))
    corners = [(NO_SCORE.trunk_a, NO_SCORE.trunk_b)] * len(which)
    for n in np.unique(sizes):
        rows = np.flatnonzero(sizes == n)
        t, u, s = which[rows].T[:, :, None]
        j = np.arange(n)
        here = trunks_a.offsets[t] + j
        start = trunks_b.offsets[u]
        there, edge = start + (s - j) % n, start + (s - 1 - j) % n
        edges[rows] = np.abs(trunks_a.edges[here] - trunks_b.edges[edge]).sum(axis=1) / n
        alphas_a, alphas_b = trunks_a.alphas[here], trunks_b.alphas[there]
        betas_a = 2.0 * math.pi - trunks_a.thetas[here] - alphas_a
        betas_b = 2.0 * math.pi - trunks_b.thetas[there] - alphas_b
        angles[rows] = (np.abs(betas_a - alphas_b) + np.abs(alphas_a - betas_b)).sum(axis=1) / (2.0 * n)
        vertices_a, vertices_b = trunks_a.vertices[here].astype(np.int64), trunks_b.vertices[there].astype(np.int64)
        for row, trunk_a, trunk_b in zip(rows, vertices_a, vertices_b, strict=True):
            corners[row] = trunk_a.copy(), trunk_b.copy()
    scored = []
    for (trunk_a, trunk_b), *terms in zip(corners, edges.tolist(), angles.tolist(), areas.tolist(), strict=True):
        scores = (
            gaussian(terms[0], parameters.sigma_e * D_C),
            gaussian(terms[1], parameters.sigma_angle),
            gaussian(terms[2], parameters.sigma_area),
        )
        scored.append(CrossScore(min(scores), trunk_a, trunk_b, *scores, terms[2], evaluations))
    return scored


def gaussian(distance: float, sigma: float) -> float:
    """exp(−d²/(2σ²)): how every distance of the method becomes a score (eq. 6).

    >>> gaussian(0.0, 0.1), round(gaussian(0.1, 0.1), 4)
    (1.0, 0.6065)
    """
    return math.exp(-(distance**2) / (2.0 * sigma**2))
