"""QCRS: the quick cross-reversibility score of two shapes, and of all pairs of two stacks of shapes (paper §5.2)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from riot.kernels.pairs import Side, Sigmas, block, brute_block, mirrored
from riot.parameters import D_C, QcrsParameters, TrunkParameters
from riot.shape import FloatArray, IntArray, Shape
from riot.trunks import Trunks, quick_trunks

FIRST_LIMIT = 1.0
"""First try at the distance D below which partners are looked for; any value gives the same result."""


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
    """

    starts: IntArray
    offsets: IntArray
    edges: FloatArray
    alphas: FloatArray
    betas: FloatArray
    areas: FloatArray

    def __len__(self) -> int:
        return len(self.starts) - 1

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


def stack(trunks: Sequence[Trunks]) -> TrunkStack:
    """Concatenate the trunks of several shapes."""
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
    )


def score_block(
    a: TrunkStack, b: TrunkStack, parameters: QcrsParameters | None = None, same: bool = False
) -> BlockScores:
    """QCRS of every shape of ``a`` with every shape of ``b``, exact; ``same``: only i < j, of one stack with itself.

    Pairs come in order (i, j). Among trunk pairs of equal score the first by (trunk_i, trunk_j, shift) is reported.
    """
    return _score(a, b, parameters or QcrsParameters(), same, block)


def brute_force(
    a: TrunkStack, b: TrunkStack, parameters: QcrsParameters | None = None, same: bool = False
) -> BlockScores:
    """The same as `score_block` without pruning: the reference of its tests and benchmarks."""
    return _score(a, b, parameters or QcrsParameters(), same, brute_block)


def qcrs(
    a: Shape,
    b: Shape,
    trunk_parameters: TrunkParameters | None = None,
    parameters: QcrsParameters | None = None,
) -> QuickScore:
    """Quick cross-reversibility score of two shapes and the trunk pair that gives it (paper §5.2)."""
    trunks_a, trunks_b = quick_trunks(a, trunk_parameters), quick_trunks(b, trunk_parameters)
    found = score_block(stack([trunks_a]), stack([trunks_b]), parameters)
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


def _score(
    a: TrunkStack, b: TrunkStack, parameters: QcrsParameters, same: bool, kernel: Callable[..., None]
) -> BlockScores:
    i, j = np.triu_indices(len(a), 1) if same else np.indices((len(a), len(b))).reshape(2, -1)
    distance = np.empty(len(i))
    winners = np.empty((len(i), 3), dtype=np.int32)
    sigmas = Sigmas(parameters.sigma_e * D_C, parameters.sigma_angle, parameters.sigma_area)
    pairs = np.stack([i, j], axis=1).astype(np.int64)
    kernel(pairs, side(a), mirrored_side(b), sigmas, FIRST_LIMIT, distance, winners)
    sizes = np.append(np.diff(a.offsets), 0)  # the last stands for "none"
    trunk = np.where(winners[:, 0] >= 0, a.starts[i] + winners[:, 0], len(sizes) - 1)
    return BlockScores(
        i=i.astype(np.int32),
        j=j.astype(np.int32),
        score=np.exp(-0.5 * distance**2),
        n=sizes[trunk].astype(np.int8),
        trunk_i=winners[:, 0].copy(),
        trunk_j=winners[:, 1].copy(),
        shift=winners[:, 2].astype(np.int8),
    )


def side(trunks: TrunkStack) -> Side:
    """P's side of the kernels."""
    sizes = np.diff(trunks.offsets)
    trunk = np.repeat(np.arange(len(sizes)), sizes)
    perimeters = np.bincount(trunk, weights=trunks.edges, minlength=len(sizes)).astype(np.float64)
    beta_sums = np.bincount(trunk, weights=trunks.betas, minlength=len(sizes))
    spreads: FloatArray = np.abs(beta_sums - (sizes - 2) * math.pi)
    ranked: FloatArray = trunks.edges[np.lexsort([trunks.edges, trunk])]
    corners = (trunks.edges, trunks.alphas, trunks.betas)
    return Side(trunks.starts, sizes, trunks.offsets, *corners, ranked, trunks.areas, perimeters, spreads)


def mirrored_side(trunks: TrunkStack) -> Side:
    """Q's side of the kernels: the corners backwards, twice."""
    edges, alphas, betas = mirrored(trunks.offsets, trunks.edges, trunks.alphas, trunks.betas)
    return side(trunks)._replace(edges=edges, alphas=alphas, betas=betas)
