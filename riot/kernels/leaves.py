"""Leaves of the QCRS search: the trunks of one n of a shape in groups of sixteen similar ones (ours).

Trunks are compared by `FEATURES` numbers first, which no shift changes: the area, and contrasts of the edges, alphas
and betas in ascending order. A contrast is a sum with signs ±1. The L1 distance of two sorted vectors is at most that
of the vectors in any order, and the difference of their contrasts is at most that distance. So every contrast bounds
the distance of two trunks from below, and so do the distances between boxes around the features of two leaves.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from riot.kernels.bounds import EDGE_CONTRASTS, FEATURES, QCRS_LEAF, TILE_LEAVES
from riot.kernels.options import inner, kernel
from riot.types import FloatArray, IntArray

_STACK = 64
"""Ranges that wait to be halved: more than the binary logarithm of any number of trunks."""

_RUN = 20
"""Runs of so many are sorted by insertion, then merged. Ours: any number gives the same order, this one soon."""


@inner
def _contrasts(values: FloatArray, n: int) -> tuple[float, float, float]:
    """Three sums of ascending values: all; the upper half less the lower half; the middle half less both ends."""
    total, low, middle = 0.0, 0.0, 0.0
    for rank in range(n):
        total += values[rank]
        if rank < n // 2:
            low += values[rank]
        if 2 * abs(2 * rank - (n - 1)) < n:
            middle += values[rank]
    return total, total - 2.0 * low, 2.0 * middle - total


@inner
def _sort(values: FloatArray, source: FloatArray, start: int, n: int) -> None:
    for k in range(n):
        value = source[start + k]
        at = k
        while at > 0 and values[at - 1] > value:
            values[at] = values[at - 1]
            at -= 1
        values[at] = value


@kernel
def features(
    offsets: IntArray, edges: FloatArray, alphas: FloatArray, betas: FloatArray, areas: FloatArray
) -> FloatArray:
    """(t, FEATURES) of ragged trunks: area, contrasts of edges, alphas, betas, and the betas' excess."""
    count = len(areas)
    out = np.empty((count, FEATURES))
    longest = 1
    for t in range(count):
        longest = max(longest, offsets[t + 1] - offsets[t])
    values = np.empty(longest)
    for t in range(count):
        start, n = offsets[t], offsets[t + 1] - offsets[t]
        out[t, 0] = areas[t]
        _sort(values, edges, start, n)
        out[t, 1], out[t, 2], out[t, 3] = _contrasts(values, n)
        _sort(values, alphas, start, n)
        _, out[t, 4], out[t, 5] = _contrasts(values, n)
        _sort(values, betas, start, n)
        total, out[t, 6], out[t, 7] = _contrasts(values, n)
        out[t, FEATURES - 1] = abs(total - (n - 2) * math.pi)
    return out


@kernel
def gather(
    values: FloatArray, numbers: IntArray, sizes: IntArray, kinds: IntArray, edge: float, angle: float, area: float
) -> npt.NDArray[np.int32]:
    """(l, QCRS_LEAF) numbers of trunks, leaf by leaf, in order of n and kind; a short leaf repeats its last trunk.

    ``values`` (t, FEATURES); ``numbers`` (t,) of the trunks in order of n and kind, and ``sizes`` (t,) and ``kinds``
    (t,) in that order. The trunks of one n and kind are halved across the feature of greatest spread, in units of the
    given sigmas, until they fit. The search finds the same with any order, but not as quickly.
    """
    count = len(sizes)
    order, keys = np.empty(count, dtype=np.int64), np.empty(count)
    spare_keys, spare = np.empty(count), np.empty(count, dtype=np.int64)
    for k in range(count):
        order[k] = numbers[k]
    leaves = 0
    start = 0
    while start < count:
        stop = start
        while stop < count and sizes[stop] == sizes[start] and kinds[stop] == kinds[start]:
            stop += 1
        leaves += (stop - start + QCRS_LEAF - 1) // QCRS_LEAF
        start = stop
    out = np.empty((leaves, QCRS_LEAF), dtype=np.int32)
    scale = np.empty(FEATURES)
    lows, highs = np.empty(_STACK, dtype=np.int64), np.empty(_STACK, dtype=np.int64)
    leaf = 0
    start = 0
    while start < count:
        n = sizes[start]
        stop = start
        while stop < count and sizes[stop] == n and kinds[stop] == kinds[start]:
            stop += 1
        for f in range(FEATURES):
            scale[f] = 1.0 / (n * edge) if f < 1 + EDGE_CONTRASTS else 1.0 / (2.0 * n * angle)
        scale[0] = 2.0 / area
        lows[0], highs[0] = start, stop
        depth = 1
        while depth > 0:
            depth -= 1
            low, high = lows[depth], highs[depth]
            if high - low <= QCRS_LEAF:
                for k in range(QCRS_LEAF):
                    out[leaf, k] = order[min(low + k, high - 1)]
                leaf += 1
                continue
            widest = _widest(values, order, low, high, scale)
            for k in range(low, high):
                keys[k] = values[order[k], widest]
            _sort_stably(keys, order, low, high, spare_keys, spare)
            middle = low + ((high - low + QCRS_LEAF - 1) // QCRS_LEAF) // 2 * QCRS_LEAF
            # The lower half comes next, so that leaves are in order.
            lows[depth], highs[depth] = middle, high
            lows[depth + 1], highs[depth + 1] = low, middle
            depth += 2
        start = stop
    return out


@inner
def _sort_stably(
    keys: FloatArray, order: IntArray, low: int, high: int, spare_keys: FloatArray, spare: IntArray
) -> None:
    """Sort ``order[low:high]`` and its keys by the keys; equals stay in order (sorted runs are merged in pairs)."""
    for start in range(low, high, _RUN):
        for k in range(start + 1, min(start + _RUN, high)):
            key, number, at = keys[k], order[k], k
            while at > start and keys[at - 1] > key:
                keys[at], order[at] = keys[at - 1], order[at - 1]
                at -= 1
            keys[at], order[at] = key, number
    width = _RUN
    while width < high - low:
        for start in range(low, high - width, 2 * width):
            middle, stop = start + width, min(start + 2 * width, high)
            for k in range(start, middle):
                spare_keys[k], spare[k] = keys[k], order[k]
            i, j, at = start, middle, start
            while i < middle:
                if j < stop and keys[j] < spare_keys[i]:
                    keys[at], order[at] = keys[j], order[j]
                    j += 1
                else:
                    keys[at], order[at] = spare_keys[i], spare[i]
                    i += 1
                at += 1
        width *= 2


@inner
def _widest(values: FloatArray, order: IntArray, low: int, high: int, scale: FloatArray) -> int:
    """The feature of greatest spread among the trunks ``order[low:high]``."""
    widest, spread = 0, -1.0
    for f in range(values.shape[1]):
        least, most = values[order[low], f], values[order[low], f]
        for k in range(low + 1, high):
            value = values[order[k], f]
            least, most = min(least, value), max(most, value)
        if (most - least) * scale[f] > spread:
            widest, spread = f, (most - least) * scale[f]
    return widest


@kernel
def lay_out(
    leaves: npt.NDArray[np.int32],
    begins: IntArray,
    tiles: IntArray,
    values: FloatArray,
    out: npt.NDArray[np.float32],
    boxes: npt.NDArray[np.float32],
) -> None:
    """Fill ``out`` (l, FEATURES, QCRS_LEAF) and ``boxes`` (tiles, 2 FEATURES, TILE_LEAVES): least and greatest of every
    feature.

    ``begins`` (g + 1,) the leaves at which groups begin, ``tiles`` (g + 1,) the tiles at which their boxes do.
    """
    for group in range(len(begins) - 1):
        for leaf in range(begins[group], begins[group + 1]):
            position = leaf - begins[group]
            tile, lane = tiles[group] + position // TILE_LEAVES, position % TILE_LEAVES
            for f in range(FEATURES):
                least, most = np.float32(np.inf), np.float32(-np.inf)
                for k in range(QCRS_LEAF):
                    value = np.float32(values[leaves[leaf, k], f])
                    out[leaf, f, k] = value
                    least, most = min(least, value), max(most, value)
                boxes[tile, 2 * f, lane], boxes[tile, 2 * f + 1, lane] = least, most


@kernel
def facing(
    leaves: npt.NDArray[np.int32],
    begins: IntArray,
    offsets: IntArray,
    edges: FloatArray,
    alphas: FloatArray,
    betas: FloatArray,
    out: npt.NDArray[np.float32],
) -> None:
    """Fill ``out``: from ``begins[leaf]`` on, n edges, n alphas and n betas of the trunks of a leaf, each value of all
    trunks side by side. They run backwards, so that corners that face those of another trunk ascend with it."""
    for leaf in range(leaves.shape[0]):
        for k in range(QCRS_LEAF):
            trunk = leaves[leaf, k]
            start, n, x = offsets[trunk], offsets[trunk + 1] - offsets[trunk], begins[leaf] + k
            for m in range(n):
                back = 0 if m == 0 else n - m
                out[x + m * QCRS_LEAF] = edges[start + n - 1 - m]
                out[x + (n + m) * QCRS_LEAF] = alphas[start + back]
                out[x + (2 * n + m) * QCRS_LEAF] = betas[start + back]


def warm() -> None:
    """Compile on a triangle."""
    offsets, corners, area = np.array([0, 3], dtype=np.int64), np.ones(3), np.ones(1)
    values = features(offsets, corners, corners, corners, area)
    zero, three = np.zeros(1, dtype=np.int64), np.array([3], dtype=np.int64)
    leaves = gather(values, zero, three, three, 1.0, 1.0, 1.0)
    begins = np.array([0, 1], dtype=np.int64)
    out, boxes = np.zeros((1, FEATURES, QCRS_LEAF), np.float32), np.zeros((1, 2 * FEATURES, TILE_LEAVES), np.float32)
    lay_out(leaves, begins, begins, values, out, boxes)
    facing(leaves, begins, offsets, corners, corners, corners, np.empty(9 * QCRS_LEAF, np.float32))
