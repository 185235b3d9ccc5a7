"""The distance of two shapes by all pairs of trunks: the definition of QCRS, which the search must equal (theory §6).

Distance of trunk T of P and trunk T' of Q, both n-gons, at shift s, with vertex j of T on vertex (s − j) mod n of T'::

    D = max( Σ|e − e'| / (n σ_E),  (Σ|β − α'| + Σ|α − β'|) / (2 n σ_∠),  area term )

The score is exp(−D²/2). The winner is the least D; among equals the first by (T, T', s).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from riot.kernels.options import kernel
from riot.types import FloatArray, IntArray


class Side(NamedTuple):
    """The trunks of shapes, laid out for these kernels; those of a shape are ordered by (n, area).

    ``starts`` (shapes + 1,) offsets of every shape's trunks; ``sizes`` (t,) their n; ``offsets`` (t + 1,) of every
    trunk's corners; ``edges``, ``alphas``, ``betas`` (s,), on Q's side `mirrored` and (2 s,); ``areas`` (t,).
    """

    starts: IntArray
    sizes: IntArray
    offsets: IntArray
    edges: FloatArray
    alphas: FloatArray
    betas: FloatArray
    areas: FloatArray


class Sigmas(NamedTuple):
    """σ_E, σ_∠ and σ_A in absolute units."""

    edge: float
    angle: float
    area: float


class Winner(NamedTuple):
    """The least distance, its trunks, numbered within their shapes, and its shift; −1 if there is none."""

    distance: float
    trunk_a: int
    trunk_b: int
    shift: int


@kernel
def mirrored(offsets: IntArray, edges: FloatArray, alphas: FloatArray, betas: FloatArray) -> FloatArray:
    """(3, 2 s) edges, alphas and betas of trunks listed backwards, twice: entry −s mod n + j faces corner j of P's."""
    out = np.empty((3, 2 * len(edges)))
    for t in range(len(offsets) - 1):
        base, n = offsets[t], offsets[t + 1] - offsets[t]
        for m in range(2 * n):
            out[0, 2 * base + m] = edges[base + (-1 - m) % n]
            out[1, 2 * base + m] = alphas[base + (-m) % n]
            out[2, 2 * base + m] = betas[base + (-m) % n]
    return out


@kernel
def _edge_sum(ea: FloatArray, x: int, eb: FloatArray, y: int, n: int) -> float:
    """Σ |e − e'| over n corners from x and from y."""
    total = 0.0
    for j in range(n):
        total += abs(ea[x + j] - eb[y + j])
    return total


@kernel
def _angle_sum(aa: FloatArray, ba: FloatArray, x: int, ab: FloatArray, bb: FloatArray, y: int, n: int) -> float:
    """Σ |β − α'| + |α − β'| over n corners from x and from y."""
    total = 0.0
    for j in range(n):
        total += abs(ba[x + j] - ab[y + j]) + abs(aa[x + j] - bb[y + j])
    return total


@kernel
def brute_pair(a: Side, i: int, b: Side, j: int, sigmas: Sigmas) -> Winner:
    """The winner between shape i of a and shape j of b, by all pairs of trunks and all shifts."""
    best, best_t, best_u, best_s = np.inf, -1, -1, -1
    for t in range(a.starts[i], a.starts[i + 1]):
        n, x = a.sizes[t], a.offsets[t]
        edge_unit, angle_unit = 1.0 / (n * sigmas.edge), 1.0 / (2.0 * n * sigmas.angle)
        for u in range(b.starts[j], b.starts[j + 1]):
            if b.sizes[u] != n:
                continue
            area = 2.0 * abs(a.areas[t] + b.areas[u] - 1.0) / sigmas.area
            for s in range(n):
                y = 2 * b.offsets[u] + (n - s) % n
                edge = _edge_sum(a.edges, x, b.edges, y, n) * edge_unit
                angle = _angle_sum(a.alphas, a.betas, x, b.alphas, b.betas, y, n) * angle_unit
                far = max(area, max(edge, angle))
                if far < best:
                    best, best_t, best_u, best_s = far, t - a.starts[i], u - b.starts[j], s
    return Winner(best, best_t, best_u, best_s)


@kernel
def brute_block(
    pairs: IntArray, a: Side, b: Side, sigmas: Sigmas, out: FloatArray, winners: npt.NDArray[np.int32]
) -> None:
    """QCRS of ``pairs`` (k, 2) of shape numbers: fills ``out`` (k,) with D, ``winners`` (k, 3) with (T, T', shift)."""
    for k in range(pairs.shape[0]):
        best = brute_pair(a, pairs[k, 0], b, pairs[k, 1], sigmas)
        out[k] = best.distance
        winners[k, 0], winners[k, 1], winners[k, 2] = best.trunk_a, best.trunk_b, best.shift


def warm() -> None:
    """Compile on two triangles."""
    starts, offsets = np.array([0, 1], dtype=np.int64), np.array([0, 3], dtype=np.int64)
    corners, area = np.ones(3), np.ones(1)
    first = Side(starts, 3 * np.ones(1, dtype=np.int64), offsets, corners, corners, corners, area)
    twice = mirrored(offsets, corners, corners, corners)
    second = first._replace(edges=twice[0], alphas=twice[1], betas=twice[2])
    pair, out, winners = np.zeros((1, 2), dtype=np.int64), np.empty(1), np.empty((1, 3), dtype=np.int32)
    brute_block(pair, first, second, Sigmas(0.1, 0.5, 0.1), out, winners)
