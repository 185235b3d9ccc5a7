"""QCRS: the quick cross-reversibility score of two shapes, and of all pairs of two stacks of shapes (paper §5.2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from riot.geometry.shape import Shape
from riot.kernels.forest import Forest, Scale
from riot.kernels.leaves import FEATURES, LEAF, WIDE, facing, features, lay_out
from riot.kernels.pairs import Side, Sigmas, brute_block, mirrored
from riot.kernels.search import block
from riot.parameters import QCRS_VARIANTS, QcrsParameters, QcrsVariant, TrunkParameters
from riot.scores.leaves import gather_leaves
from riot.scores.trunks import Trunks, compared_trunks
from riot.types import FloatArray, IntArray
from riot.units import D_C


@dataclass(frozen=True, eq=False)
class TrunkStack:
    """The trunks of many shapes, concatenated.

    Parameters
    ----------
    starts : (shapes + 1,) int64
        Offsets of every shape's trunks.
    offsets : (t + 1,) int64
        Offsets of every trunk's corners in the following three.
    edges, alphas, betas : (s,) float64
        Edge lengths, trunk angles α, and β = 2π − θ − α.
    areas : (t,) float64
        Trunk areas; within a shape ordered by (n, area).
    leaf_starts : (shapes + 1,) int64
        Offsets of every shape's leaves.
    leaves : (l, 16) int32
        Similar trunks of one n, numbered within their shapes, in order of n (`riot.kernels.leaves`): what the search
        goes through. They decide how long it takes, and nothing else.
    """

    starts: IntArray
    offsets: IntArray
    edges: FloatArray
    alphas: FloatArray
    betas: FloatArray
    areas: FloatArray
    leaf_starts: IntArray
    leaves: npt.NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.starts) - 1

    def shape(self, number: int) -> TrunkStack:
        """One shape's trunks as a stack of their own."""
        low, high = self.starts[number], self.starts[number + 1]
        first, last = self.offsets[low], self.offsets[high]
        leaves = self.leaves[self.leaf_starts[number] : self.leaf_starts[number + 1]]
        return TrunkStack(
            np.array([0, high - low], dtype=np.int64),
            self.offsets[low : high + 1] - first,
            self.edges[first:last].copy(),
            self.alphas[first:last].copy(),
            self.betas[first:last].copy(),
            self.areas[low:high].copy(),
            np.array([0, len(leaves)], dtype=np.int64),
            leaves.copy(),
        )

    @cached_property
    def forest(self) -> Forest:
        """What the search reads of these trunks, laid out for it once."""
        shape = np.repeat(np.arange(len(self)), np.diff(self.leaf_starts))
        trunks = (self.leaves + self.starts[shape, None]).astype(np.int32)
        n = np.diff(self.offsets)[trunks[:, 0]]
        new = np.ones(len(n), dtype=bool)
        new[1:] = (n[1:] != n[:-1]) | (shape[1:] != shape[:-1])
        first = np.flatnonzero(new)
        groups = np.searchsorted(shape[first], np.arange(len(self) + 1))
        return lay_out_forest(self, trunks, np.append(first, len(n)), groups)

    @cached_property
    def extremes(self) -> tuple[float, float, int]:
        """The longest edge, the greatest alpha or beta without its sign, and the greatest n."""
        edge, alpha, beta = (float(np.abs(each).max(initial=0.0)) for each in (self.edges, self.alphas, self.betas))
        return edge, max(alpha, beta), int(np.diff(self.offsets).max(initial=3))

    def to_arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Plain arrays by field name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, npt.NDArray[Any]]) -> TrunkStack:
        """Undo `to_arrays`."""
        return cls(**{field.name: arrays[field.name] for field in fields(cls)})


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


def stack(trunks: Sequence[Trunks], leaves: Sequence[npt.NDArray[np.int32]] | None = None) -> TrunkStack:
    """Concatenate the trunks of several shapes; their ``leaves`` are gathered (`gather_leaves`) if not given."""
    leaves = [gather_leaves(each) for each in trunks] if leaves is None else leaves
    counts = [len(each) for each in trunks]
    sizes = np.concatenate([np.zeros(0, dtype=np.int64), *[each.sizes for each in trunks]])
    none = np.zeros(0)
    return TrunkStack(
        starts=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        offsets=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64),
        edges=np.concatenate([none, *[each.edges for each in trunks]]),
        alphas=np.concatenate([none, *[each.alphas for each in trunks]]),
        betas=np.concatenate([none, *[each.betas for each in trunks]]),
        areas=np.concatenate([none, *[each.areas for each in trunks]]),
        leaf_starts=_running(np.array([len(each) for each in leaves], dtype=np.int64)),
        leaves=np.concatenate([np.empty((0, LEAF), np.int32), *leaves]),
    )


def lay_out_forest(
    trunks: TrunkStack, leaves: npt.NDArray[np.int32], first: npt.NDArray[Any], groups: npt.NDArray[Any]
) -> Forest:
    """Leaves as the search reads them: (l, 16) numbers among all trunks, (g + 1,) first of each group of one n."""
    n = np.diff(trunks.offsets)[leaves[:, 0]]
    counts, sizes = np.diff(first), n[first[:-1]]
    tiles, begins = _running(-(-counts // WIDE)), _running(counts * LEAF * 6 * sizes)
    values = features(trunks.offsets, trunks.edges, trunks.alphas, trunks.betas, trunks.areas)
    laid = np.empty((len(n), FEATURES, LEAF), dtype=np.float32)
    boxes = np.zeros((int(tiles[-1]), 2 * FEATURES, WIDE), dtype=np.float32)
    lay_out(leaves, first.astype(np.int64), tiles, values, laid, boxes)
    corners = np.empty(int(begins[-1]), dtype=np.float32)
    slots = _running(np.repeat(6 * n, LEAF))
    facing(leaves, slots, trunks.offsets, trunks.edges, trunks.alphas, trunks.betas, corners)
    return Forest(
        groups=groups.astype(np.int64),
        sizes=sizes,
        leaves=first.astype(np.int64),
        tiles=tiles,
        begins=begins,
        trunks=leaves,
        features=laid,
        boxes=boxes,
        facing=corners,
        starts=trunks.starts,
        offsets=trunks.offsets,
        edges=trunks.edges,
        alphas=trunks.alphas,
        betas=trunks.betas,
        areas=trunks.areas,
    )


def _running(counts: npt.NDArray[Any]) -> IntArray:
    """0 and the running sums."""
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)


def score_block(
    a: TrunkStack,
    b: TrunkStack,
    parameters: QcrsParameters | None = None,
    same: bool = False,
    least: float = 0.0,
) -> BlockScores:
    """QCRS of every shape of ``a`` with every shape of ``b``, exact; ``same``: only i < j, of one stack with itself.

    Pairs come in order (i, j). Among trunk pairs of equal score the first by (trunk_i, trunk_j, shift) is reported. Of
    pairs that score below ``least`` no more than that need be known: theirs may be reported as 0, without trunks.
    """
    return score_pairs(a, b, _all_pairs(a, b, same), parameters, least)


def score_pairs(
    a: TrunkStack,
    b: TrunkStack,
    pairs: IntArray,
    parameters: QcrsParameters | None = None,
    least: float | FloatArray = 0.0,
) -> BlockScores:
    """QCRS of ``pairs`` (k, 2) of shapes of ``a`` and of ``b``; ``least`` as for `score_block`, or (k,), one a pair."""
    parameters = parameters or QcrsParameters()
    distance = np.empty(len(pairs))
    winners = np.empty((len(pairs), 3), dtype=np.int32)
    limits = np.broadcast_to(np.asarray(distance_of(least), dtype=np.float64), len(pairs)).copy()
    block(pairs, a.forest, b.forest, scale_of(a, b, parameters), limits, distance, winners)
    return _scores(a, pairs, distance, winners)


def distance_of(score: float | FloatArray) -> FloatArray:
    """D of a score exp(−D²/2), rounded up so that no pair of that score is farther; inf for 0."""
    with np.errstate(divide="ignore"):
        exact: FloatArray = np.sqrt(-2.0 * np.log(np.asarray(score, dtype=np.float64)))
    return np.where(np.isinf(exact), exact, exact * (1.0 + 1e-12) + 1e-7)


def brute_force(
    a: TrunkStack, b: TrunkStack, parameters: QcrsParameters | None = None, same: bool = False
) -> BlockScores:
    """The same as `score_block` by trying everything: the reference of its tests and benchmarks."""
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
    found = score_block(stack([trunks_a]), stack([trunks_b]), parameters or QCRS_VARIANTS[variant])
    if found.n[0] == 0:
        nothing = np.zeros(0, dtype=np.int64)
        return QuickScore(0.0, nothing, nothing)
    return QuickScore(
        float(found.score[0]),
        trunks_a.of(int(found.trunk_i[0])),
        corresponding(trunks_b.of(int(found.trunk_j[0])), int(found.shift[0])),
    )


def corresponding(trunk_b: npt.NDArray[Any], shift: int) -> npt.NDArray[Any]:
    """Reorder b's trunk vertices so that entry k corresponds to vertex k of a's trunk: (shift − k) mod n."""
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


def scale_of(a: TrunkStack, b: TrunkStack, parameters: QcrsParameters) -> Scale:
    """The sigmas, and a bound of the rounding of the search's single-precision bounds.

    They are sums of up to 2n differences, each of two numbers of at most ``edge`` or ``angle``: every number,
    difference and running sum is rounded by at most 2⁻²⁴ of itself. The areas' term is one difference.
    """
    sigma_edge, sigma_angle, sigma_area = parameters.sigma_e * D_C, parameters.sigma_angle, parameters.sigma_area
    edge, angle, corners = map(max, a.extremes, b.extremes)
    greatest = 2.0 * (edge / sigma_edge + angle / sigma_angle + 2.0 / sigma_area)
    return Scale(sigma_edge, sigma_angle, sigma_area, 2.0**-24 * (2 * corners + 16) * greatest)
