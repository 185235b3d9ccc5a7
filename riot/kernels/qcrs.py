"""Least distance between the trunks of two shapes: the hot loop of QCRS (paper §5.2; pruning ours, theory §6).

Distance of trunk T of P and trunk T' of Q, both n-gons, at shift s, with vertex j of T on vertex (s − j) mod n of T'::

    D = max( Σ|e − e'| / (n σ_E),  (Σ|β − α'| + Σ|α − β'|) / (2 n σ_∠),  2 |a + a' − 1| / σ_A )

The score is exp(−D²/2). The winner is the least D; among equals the first by (T, T', s).

A *side* is a tuple of arrays: ``starts`` (shapes + 1,), ``sizes`` (t,) and ``offsets`` (t + 1,) int64; ``edges``, ``alphas``,
``betas`` and ``ranked`` (the edges of every trunk in ascending order), each (s,) for P; ``areas``, ``perimeters`` and ``spreads``
(t,). On Q's side the corners are listed in the opposite direction and twice over (`mirrored`), so that at any shift the
corresponding corners lie side by side.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from riot.kernels.options import kernel
from riot.shape import FloatArray, IntArray

SLACK = 1e-12
"""Lower bounds are summed in another order than D; one that exceeds the best D by less prunes nothing."""


@kernel
def mirrored(offsets: IntArray, edges: FloatArray, alphas: FloatArray, betas: FloatArray) -> FloatArray:
    """(3, 2 s) edges, alphas and betas listed backwards, twice: at o = −s mod n, entry o + j faces corner j of P's."""
    out = np.empty((3, 2 * len(edges)))
    for t in range(len(offsets) - 1):
        base, n = offsets[t], offsets[t + 1] - offsets[t]
        for m in range(2 * n):
            out[0, 2 * base + m] = edges[base + (-1 - m) % n]
            out[1, 2 * base + m] = alphas[base + (-m) % n]
            out[2, 2 * base + m] = betas[base + (-m) % n]
    return out


@kernel
def edge_sum(ea: FloatArray, x: int, eb: FloatArray, y: int, n: int) -> float:
    """Σ |e − e'| over n corners from x and from y."""
    total = 0.0
    for j in range(n):
        total += abs(ea[x + j] - eb[y + j])
    return total


@kernel
def angle_sum(aa: FloatArray, ba: FloatArray, x: int, ab: FloatArray, bb: FloatArray, y: int, n: int) -> float:
    """Σ |β − α'| + |α − β'| over n corners from x and from y."""
    total = 0.0
    for j in range(n):
        total += abs(ba[x + j] - ab[y + j]) + abs(aa[x + j] - bb[y + j])
    return total


@kernel
def brute_pair(
    a0: int, a1: int, na: IntArray, oa: IntArray, ea: FloatArray, aa: FloatArray, ba: FloatArray, sa: FloatArray,
    b0: int, b1: int, nb: IntArray, ob: IntArray, eb: FloatArray, ab: FloatArray, bb: FloatArray, sb: FloatArray,
    sigma_e: float, sigma_angle: float, sigma_area: float,
) -> tuple[float, int, int, int]:  # fmt: skip
    """(D, T, T', shift) by trying everything; (inf, −1, −1, −1) without two trunks of one n. The reference."""
    best, best_a, best_b, best_s = np.inf, -1, -1, -1
    for t in range(a0, a1):
        n = na[t]
        edge_unit, angle_unit = 1.0 / (n * sigma_e), 1.0 / (2.0 * n * sigma_angle)
        for u in range(b0, b1):
            if nb[u] != n:
                continue
            area = 2.0 * abs(sa[t] + sb[u] - 1.0) / sigma_area
            for s in range(n):
                y = 2 * ob[u] + (n - s) % n
                edge = edge_sum(ea, oa[t], eb, y, n) * edge_unit
                angle = angle_sum(aa, ba, oa[t], ab, bb, y, n) * angle_unit
                far = max(area, max(edge, angle))
                if far < best:
                    best, best_a, best_b, best_s = far, t - a0, u - b0, s
    return best, best_a, best_b, best_s


@kernel
def pruned_pair(
    a0: int, a1: int, na: IntArray, oa: IntArray, ea: FloatArray, aa: FloatArray, ba: FloatArray, sa: FloatArray,
    ra: FloatArray, pa: FloatArray, ga: FloatArray,
    b0: int, b1: int, nb: IntArray, ob: IntArray, eb: FloatArray, ab: FloatArray, bb: FloatArray, sb: FloatArray,
    rb: FloatArray, pb: FloatArray, gb: FloatArray,
    sigma_e: float, sigma_angle: float, sigma_area: float, start: float,
) -> tuple[float, int, int, int]:  # fmt: skip
    """The same as `brute_pair`, pruned; a shape's trunks come ordered by (n, area).

    Lower bounds of D, cheapest first: the area term; the difference of the perimeters ``p``; the spreads ``g`` = |Σβ − (n −
    2)π|, the least that Σ|β − α'| can be; the L1 distance of the ranked edges ``r``. A first pass looks only for D ≤
    ``start``; if there is none, the limit doubles, and is dropped at last.
    """
    best, best_a, best_b, best_s = np.inf, -1, -1, -1
    limit = start
    while True:
        bound = limit + SLACK
        t, group_b = a0, b0
        while t < a1:
            n = na[t]
            while group_b < b1 and nb[group_b] < n:
                group_b += 1
            end_b = group_b
            while end_b < b1 and nb[end_b] == n:
                end_b += 1
            end_a = t
            while end_a < a1 and na[end_a] == n:
                end_a += 1
            edge_unit, angle_unit = 1.0 / (n * sigma_e), 1.0 / (2.0 * n * sigma_angle)
            # As T's area grows, the window of areas that T' may have only moves down.
            high = end_b
            for row in range(t, end_a):
                room = bound / angle_unit - ga[row]
                if room < 0.0:
                    continue
                most = 1.0 - sa[row] + 0.5 * bound * sigma_area
                least = 1.0 - sa[row] - 0.5 * bound * sigma_area
                while high > group_b and sb[high - 1] > most:
                    high -= 1
                reach = bound / edge_unit
                x = oa[row]

                low = _first_at_least(sb, group_b, high, least)
                for u in range(low, high):
                    if abs(pa[row] - pb[u]) > reach or gb[u] > room:
                        continue
                    y0 = 2 * ob[u]
                    if edge_sum(ra, x, rb, ob[u], n) > reach:
                        continue
                    area = 2.0 * abs(sa[row] + sb[u] - 1.0) / sigma_area
                    if area > bound:
                        continue
                    for s in range(n):
                        y = y0 + (n - s) % n
                        edge = edge_sum(ea, x, eb, y, n) * edge_unit
                        if edge > bound:
                            continue
                        angle = angle_sum(aa, ba, x, ab, bb, y, n) * angle_unit
                        far = max(area, max(edge, angle))
                        if far <= limit and far < best:
                            best, best_a, best_b, best_s = far, row - a0, u - b0, s
                            bound = best + SLACK
                            reach = bound / edge_unit
                            room = bound / angle_unit - ga[row]
            t, group_b = end_a, end_b
        if best < np.inf or limit == np.inf:
            return best, best_a, best_b, best_s
        limit = np.inf if limit > 4.0 * start else 2.0 * limit


@kernel
def _first_at_least(values: FloatArray, low: int, high: int, wanted: float) -> int:
    while low < high:
        middle = (low + high) // 2
        if values[middle] < wanted:
            low = middle + 1
        else:
            high = middle
    return low


@kernel
def block(
    pairs: IntArray,
    ta: IntArray, na: IntArray, oa: IntArray, ea: FloatArray, aa: FloatArray, ba: FloatArray,
    ra: FloatArray, sa: FloatArray, pa: FloatArray, ga: FloatArray,
    tb: IntArray, nb: IntArray, ob: IntArray, eb: FloatArray, ab: FloatArray, bb: FloatArray,
    rb: FloatArray, sb: FloatArray, pb: FloatArray, gb: FloatArray,
    sigma_e: float, sigma_angle: float, sigma_area: float, start: float, brute: bool,
    out: FloatArray, winners: npt.NDArray[np.int32],
) -> None:  # fmt: skip
    """All ``pairs`` (k, 2) of local shape numbers: fills ``out`` (k,) with D, ``winners`` (k, 3) with (T, T', shift).

    Winners are numbered within their shape.
    """
    for k in range(pairs.shape[0]):
        i, j = pairs[k, 0], pairs[k, 1]
        if brute:
            best, t, u, s = brute_pair(
                ta[i], ta[i + 1], na, oa, ea, aa, ba, sa,
                tb[j], tb[j + 1], nb, ob, eb, ab, bb, sb,
                sigma_e, sigma_angle, sigma_area,
            )  # fmt: skip
        else:
            best, t, u, s = pruned_pair(
                ta[i], ta[i + 1], na, oa, ea, aa, ba, sa, ra, pa, ga,
                tb[j], tb[j + 1], nb, ob, eb, ab, bb, sb, rb, pb, gb,
                sigma_e, sigma_angle, sigma_area, start,
            )  # fmt: skip
        out[k] = best
        winners[k, 0], winners[k, 1], winners[k, 2] = t, u, s


def warm() -> None:
    """Compile on two triangles."""
    one = np.ones(1, dtype=np.int64)
    offsets = np.array([0, 3], dtype=np.int64)
    three, single = np.ones(3), np.ones(1)
    head = (np.array([0, 1], dtype=np.int64), 3 * one, offsets)
    tail = (three, single, single, single)
    twice = mirrored(offsets, three, three, three)
    winners = np.empty((1, 3), dtype=np.int32)
    sides = (*head, three, three, three, *tail, *head, twice[0], twice[1], twice[2], *tail)
    block(np.zeros((1, 2), dtype=np.int64), *sides, 0.1, 0.5, 0.1, 1.0, False, np.empty(1), winners)
