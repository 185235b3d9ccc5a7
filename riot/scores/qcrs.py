"""QCRS: the quick cross-reversibility score of two shapes, and of all pairs of two stacks of shapes (paper §5.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from riot.geometry.shape import Shape
from riot.kernels.forest import Scale
from riot.kernels.pairs import Side, Sigmas, brute_block, mirrored
from riot.kernels.search import block
from riot.parameters import QCRS_VARIANTS, QcrsParameters, QcrsVariant, TrunkParameters
from riot.scores.trunk_stack import TrunkStack, stack
from riot.scores.trunks import compared_trunks
from riot.types import FloatArray, IntArray
from riot.units import D_C


@dataclass(frozen=True, eq=False)
class BlockScores:
    """QCRS of k pairs (i, j): numbers within the two stacks, score, and the pair of trunks that gives it.

    ``n``, ``trunk_i``, ``trunk_j`` and ``shift`` tell that vertex k of trunk ``trunk_i`` of shape i corresponds to
    vertex ``(shift − k) mod n`` of trunk ``trunk_j`` of shape j. Pairs without trunks of one n: score 0, n 0, the
    others −1.
    """

    i: npt.NDArray[np.int32]
    j: npt.NDArray[np.int32]
    score: FloatArray
    n: npt.NDArray[np.int8]
    trunk_i: npt.NDArray[np.int32]
    trunk_j: npt.NDArray[np.int32]
    shift: npt.NDArray[np.int8]


@dataclass(frozen=True, eq=False)
class QuickScore:
    """QCRS of one pair: the score, and corresponding trunk vertices, indices into the two shapes' points.

    ``trunk_a`` is counter-clockwise, ``trunk_b`` in corresponding order, hence clockwise; both empty if score is 0.
    """

    score: float
    trunk_a: IntArray
    trunk_b: IntArray


def score_block(
    a: TrunkStack,
    b: TrunkStack,
    parameters: QcrsParameters | None = None,
    same: bool = False,
    least: float = 0.0,
) -> BlockScores:
    """QCRS of every shape of ``a`` with every shape of ``b``; ``same``: only i < j, of one stack with itself.

    Exact, or with ``parameters.epsilon`` at most that much too low: a search that has found the distance D passes over
    trunks that are, by a lower bound, farther than D', where exp(−D'²/2) = exp(−D²/2) + ε. What it passes over scores
    less than ε above what it has then, and that only rises. (Fewer trunks, near copies of one another being merged,
    would lose as little by the triangle inequality of D, but smooth outlines have hardly any so near: ours.)

    Pairs come in order (i, j). Among trunk pairs of equal score the first by (trunk_i, trunk_j, shift) is reported. Of
    pairs that score below ``least`` no more than that need be known: theirs may be reported as 0, without trunks.

    >>> from riot.scores.trunks import quick_trunks
    >>> houses, kites = stack([quick_trunks(house)]), stack([quick_trunks(kite)])
    >>> score_block(houses, kites).score.round(3).tolist()
    [0.991]
    """
    return score_pairs(a, b, _all_pairs(a, b, same), parameters, least)


def score_pairs(
    a: TrunkStack,
    b: TrunkStack,
    pairs: IntArray,
    parameters: QcrsParameters | None = None,
    least: float | FloatArray = 0.0,
) -> BlockScores:
    """QCRS of ``pairs`` (k, 2) of shapes of ``a`` and of ``b``; ``least`` as for `score_block`, or (k,), one a pair.

    >>> from riot.scores.trunks import quick_trunks
    >>> both = stack([quick_trunks(house), quick_trunks(kite)])
    >>> score_pairs(both, both, np.array([[0, 1]])).score.round(3).tolist()
    [0.991]
    """
    parameters = parameters or QcrsParameters()
    distance = np.empty(len(pairs))
    winners = np.empty((len(pairs), 3), dtype=np.int32)
    limits = np.broadcast_to(np.asarray(distance_of(least), dtype=np.float64), len(pairs)).copy()
    block(pairs, a.forest, b.forest, scale_of(a, b, parameters), limits, distance, winners)
    return _scores(a, pairs, distance, winners)


_SCORE_SLACK, _DISTANCE_SLACK = 1e-12, 1e-7
"""Relative and absolute excess of `distance_of`. Ours: above the rounding of logarithm and root, also near score 1,
where the root magnifies it."""


def distance_of(score: float | FloatArray) -> FloatArray:
    """D of a score exp(−D²/2), rounded up so that no pair of that score is farther; inf for 0.

    >>> distance_of(np.array([1.0, 0.5])).round(4).tolist()
    [0.0, 1.1774]
    """
    with np.errstate(divide="ignore"):
        exact: FloatArray = np.sqrt(-2.0 * np.log(np.asarray(score, dtype=np.float64)))
    return np.where(np.isinf(exact), exact, exact * (1.0 + _SCORE_SLACK) + _DISTANCE_SLACK)


def brute_force(
    a: TrunkStack, b: TrunkStack, parameters: QcrsParameters | None = None, same: bool = False
) -> BlockScores:
    """The same as `score_block` by trying everything: the reference of its tests and benchmarks.

    >>> from riot.scores.trunks import quick_trunks
    >>> houses, kites = stack([quick_trunks(house)]), stack([quick_trunks(kite)])
    >>> bool(np.isclose(brute_force(houses, kites).score, score_block(houses, kites).score).all())
    True
    """
    parameters = parameters or QcrsParameters()
    pairs = _all_pairs(a, b, same)
    distance = np.empty(len(pairs))
    winners = np.empty((len(pairs), 3), dtype=np.int32)
    sigmas = Sigmas(parameters.sigma_e * D_C, parameters.sigma_angle, parameters.sigma_area)
    edges, alphas, betas = mirrored(b.offsets, b.edges, b.alphas, b.betas)
    side_a = Side(a.starts, np.diff(a.offsets), a.offsets, a.edges, a.alphas, a.betas, a.areas)
    side_b = Side(b.starts, np.diff(b.offsets), b.offsets, edges, alphas, betas, b.areas)
    brute_block(pairs, side_a, side_b, sigmas, distance, winners)
    return _scores(a, pairs, distance, winners)


def qcrs(
    a: Shape,
    b: Shape,
    trunk_parameters: TrunkParameters | None = None,
    parameters: QcrsParameters | None = None,
    variant: QcrsVariant = "paper",
) -> QuickScore:
    """Quick cross-reversibility score of two shapes and the trunk pair that gives it (paper §5.2).

    ``variant`` says which trunks are compared and, without ``parameters``, the sigmas.

    >>> from riot import Shape
    >>> house = Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)])
    >>> kite = Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)])
    >>> quick = qcrs(house, kite)
    >>> round(quick.score, 3), len(quick.trunk_a)
    (0.991, 4)
    """
    trunks_a, trunks_b = (compared_trunks(shape, variant, trunk_parameters) for shape in (a, b))
    best = score_block(stack([trunks_a]), stack([trunks_b]), parameters or QCRS_VARIANTS[variant])
    if best.n[0] == 0:
        nothing = np.zeros(0, dtype=np.int64)
        return QuickScore(0.0, nothing, nothing)
    return QuickScore(
        float(best.score[0]),
        trunks_a.of(int(best.trunk_i[0])),
        corresponding(trunks_b.of(int(best.trunk_j[0])), int(best.shift[0])),
    )


def corresponding(trunk_b: npt.NDArray[Any], shift: int) -> npt.NDArray[Any]:
    """Reorder b's trunk vertices so that entry k corresponds to vertex k of a's trunk: (shift − k) mod n.

    >>> corresponding(np.array([10, 11, 12, 13]), 1).tolist()
    [11, 10, 13, 12]
    """
    n = len(trunk_b)
    return trunk_b[(shift - np.arange(n)) % n]


def _all_pairs(a: TrunkStack, b: TrunkStack, same: bool) -> IntArray:
    i, j = np.triu_indices(len(a), 1) if same else np.indices((len(a), len(b))).reshape(2, -1)
    return np.stack([i, j], axis=1).astype(np.int64)


def _scores(a: TrunkStack, pairs: IntArray, distance: FloatArray, winners: npt.NDArray[np.int32]) -> BlockScores:
    sizes = np.append(np.diff(a.offsets), 0)  # the last stands for "none"
    trunk = np.where(winners[:, 0] >= 0, a.starts[pairs[:, 0]] + winners[:, 0], len(sizes) - 1)
    return BlockScores(
        i=pairs[:, 0].astype(np.int32),
        j=pairs[:, 1].astype(np.int32),
        score=np.exp(-0.5 * distance**2),
        n=sizes[trunk].astype(np.int8),
        trunk_i=winners[:, 0].copy(),
        trunk_j=winners[:, 1].copy(),
        shift=winners[:, 2].astype(np.int8),
    )


def scale_of(a: TrunkStack, b: TrunkStack, parameters: QcrsParameters, margin: float = 1.0) -> Scale:
    """The sigmas, and a bound of the rounding of the search's single-precision bounds.

    They are sums of up to 2n differences, each of two numbers of at most ``edge`` or ``angle``: every number,
    difference and running sum is rounded by at most 2⁻²⁴ of itself. The areas' term is one difference.
    """
    sigma_edge, sigma_angle, sigma_area = parameters.sigma_e * D_C, parameters.sigma_angle, parameters.sigma_area
    edge, angle, corners = map(max, a.extremes, b.extremes)
    greatest = 2.0 * (edge / sigma_edge + angle / sigma_angle + 2.0 / sigma_area)
    return Scale(
        sigma_edge, sigma_angle, sigma_area, 2.0**-24 * (2 * corners + 16) * greatest, margin, parameters.epsilon
    )
