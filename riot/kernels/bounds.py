"""Distances of trunks, and lower bounds of them: what the kernels of the search of QCRS share (theory §6; ours).

`row_bounds` and `lanes_beside` bound by boxes around leaves, `lanes_within` by the features of trunks, `lanes_near` by
all shifts in single precision, each sixteen trunks at a time; `exact_distance` is D itself.

Some code is written for the machine: loops over `QCRS_LEAF` or `TILE_LEAVES` lanes without branches, which LLVM
vectorises; indices that cannot be negative (constants, ranges, unsigned numbers), which spare Python's wrap-around;
kernels without arrays of their own (`inner`), which spare reference counts; sums over n corners unrolled for each small
n.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from riot.kernels.forest import Forest, Single
from riot.kernels.options import inlined, inner
from riot.types import FloatArray

QCRS_LEAF = 16
"""Trunks of a leaf: two vector registers of single-precision numbers. With fewer than 16 LLVM does not vectorise.
Ours."""

TILE_LEAVES = 32
"""Leaves of a tile: their boxes are stored side by side, for vectorised loops. Ours."""

EDGE_CONTRASTS = 3
"""Contrasts of the edges: features 1 to 3. Ours."""

ANGLE_CONTRASTS = 2
"""Contrasts of the alphas, from feature 4, and of the betas, from feature 6; the sum of the alphas is (n − 2)π, and
none of them. Ours."""

FEATURES = 1 + EDGE_CONTRASTS + 2 * ANGLE_CONTRASTS + 1
"""Numbers of a trunk: the first is the area, the last |Σβ − (n − 2)π|, the least value of Σ|β − α'|."""

CORNER_VALUES = 3
"""Values of each corner that `riot.kernels.leaves.facing` stores: edge, alpha and beta."""

FIRST_ALPHA = 1 + EDGE_CONTRASTS
FIRST_BETA = FIRST_ALPHA + ANGLE_CONTRASTS

INFINITY_BITS = np.int32(0x7F800000)
"""The bits of single-precision infinity. The bits of numbers from 0 up are in the order of the numbers."""

LANE_BITS = (1 << np.arange(QCRS_LEAF)).astype(np.int32)
"""The bit of each trunk of a leaf in a mask."""

U64 = np.uint64
LANES = U64(QCRS_LEAF)
F32: TypeAlias = np.float32


@inner
def row_bounds(
    box: Single, boxes: Single, tile: int, count: int, edge: F32, angle: F32, area: F32, out: Single, row: int,
    column: int,
) -> Any:  # fmt: skip
    """Bounds of one leaf against ``count`` leaves of a tile, into ``out[row, column]``; returns the bits of the
    least."""
    zero, unit = np.float32(0.0), np.float32(1.0)
    least = INFINITY_BITS
    for y in range(count):
        u, v = box[0] - (unit - boxes[tile, 0, y]), (unit - boxes[tile, 1, y]) - box[1]
        w = (u if u > v else v) * area
        e = zero
        for k in range(1, 1 + EDGE_CONTRASTS):
            u, v = box[2 * k] - boxes[tile, 2 * k + 1, y], boxes[tile, 2 * k, y] - box[2 * k + 1]
            g = u if u > v else v
            e = g if g > e else e
        p, q = boxes[tile, 2 * FEATURES - 2, y], box[2 * FEATURES - 2]
        for k in range(FIRST_ALPHA, FIRST_BETA):
            h = k + ANGLE_CONTRASTS
            u, v = box[2 * k] - boxes[tile, 2 * h + 1, y], boxes[tile, 2 * h, y] - box[2 * k + 1]
            g = u if u > v else v
            p = g if g > p else p
            u, v = box[2 * h] - boxes[tile, 2 * k + 1, y], boxes[tile, 2 * k, y] - box[2 * h + 1]
            g = u if u > v else v
            q = g if g > q else q
        e *= edge
        g = (p + q) * angle
        e = g if g > e else e
        e = w if w > e else e
        out[row, column, y] = e
    for y in range(count):
        least = min(least, np.float32(out[row, column, y]).view(np.int32))
    return least


@inlined
def _bound_beside(
    features: Single, leaf: int, k: int, boxes: Single, tile: int, lane: int, edge: F32, angle: F32, area: F32
) -> Any:
    """Bound of trunk k of a leaf against the trunks in the box at ``lane`` of a tile."""
    value = np.float32(1.0) - features[leaf, 0, k]
    u, v = boxes[tile, 0, lane] - value, value - boxes[tile, 1, lane]
    w = (u if u > v else v) * area
    e = np.float32(0.0)
    for f in range(1, 1 + EDGE_CONTRASTS):
        value = features[leaf, f, k]
        u, v = boxes[tile, 2 * f, lane] - value, value - boxes[tile, 2 * f + 1, lane]
        g = u if u > v else v
        e = g if g > e else e
    p, q = boxes[tile, 2 * FEATURES - 2, lane], features[leaf, FEATURES - 1, k]
    for f in range(FIRST_ALPHA, FIRST_BETA):
        h = f + ANGLE_CONTRASTS
        value = features[leaf, f, k]
        u, v = boxes[tile, 2 * h, lane] - value, value - boxes[tile, 2 * h + 1, lane]
        g = u if u > v else v
        p = g if g > p else p
        value = features[leaf, h, k]
        u, v = boxes[tile, 2 * f, lane] - value, value - boxes[tile, 2 * f + 1, lane]
        g = u if u > v else v
        q = g if g > q else q
    e *= edge
    g = (p + q) * angle
    e = g if g > e else e
    return w if w > e else e


@inner
def lanes_beside(
    features: Single, leaf: int, boxes: Single, tile: int, lane: int, edge: F32, angle: F32, area: F32, limit: F32
) -> Any:
    """Which trunks of a leaf may be within ``limit`` of a trunk in the box at ``lane`` of a tile: one bit each."""
    mask = np.int32(0)
    for k in range(QCRS_LEAF):
        near = _bound_beside(features, leaf, k, boxes, tile, lane, edge, angle, area) <= limit
        mask = np.int32(mask | (LANE_BITS[k] if near else np.int32(0)))
    return mask


@inner
def lanes_beside_each(
    features: Single, leaf: int, boxes: Single, tile: int, lane: int, edge: F32, angle: F32, area: F32, limits: Single,
    row: int,
) -> Any:  # fmt: skip
    """As `lanes_beside`, each trunk k within a limit of its own, ``limits[row, k]``."""
    mask = np.int32(0)
    for k in range(QCRS_LEAF):
        near = _bound_beside(features, leaf, k, boxes, tile, lane, edge, angle, area) <= limits[row, k]
        mask = np.int32(mask | (LANE_BITS[k] if near else np.int32(0)))
    return mask


@inlined
def _bound(fa: Single, x: int, k: int, fb: Single, y: int, j: int, edge: F32, angle: F32, area: F32) -> Any:
    """Bound of trunk k of leaf x against trunk j of leaf y."""
    w = abs((np.float32(1.0) - fa[x, 0, k]) - fb[y, 0, j]) * area
    e = abs(fa[x, 1, k] - fb[y, 1, j])
    for f in range(2, 1 + EDGE_CONTRASTS):
        g = abs(fa[x, f, k] - fb[y, f, j])
        e = g if g > e else e
    p, q = fb[y, FEATURES - 1, j], fa[x, FEATURES - 1, k]
    for f in range(FIRST_ALPHA, FIRST_BETA):
        g = abs(fa[x, f, k] - fb[y, f + ANGLE_CONTRASTS, j])
        p = g if g > p else p
        g = abs(fa[x, f + ANGLE_CONTRASTS, k] - fb[y, f, j])
        q = g if g > q else q
    e *= edge
    g = (p + q) * angle
    e = g if g > e else e
    return w if w > e else e


@inner
def lanes_within(fa: Single, x: int, k: int, fb: Single, y: int, edge: F32, angle: F32, area: F32, limit: F32) -> Any:
    """Which trunks of leaf y may be within ``limit`` of trunk k of leaf x: one bit each."""
    mask = np.int32(0)
    for j in range(QCRS_LEAF):
        near = _bound(fa, x, k, fb, y, j, edge, angle, area) <= limit
        mask = np.int32(mask | (LANE_BITS[j] if near else np.int32(0)))
    return mask


@inner
def least_bound(fa: Single, x: int, k: int, fb: Single, y: int, edge: F32, angle: F32, area: F32) -> Any:
    """Bits of the least bound of trunk k of leaf x against the trunks of leaf y."""
    least = INFINITY_BITS
    for j in range(QCRS_LEAF):
        least = min(least, np.float32(_bound(fa, x, k, fb, y, j, edge, angle, area)).view(np.int32))
    return least


def _near_for(n: int) -> Callable[..., Any]:
    """`lanes_near` for trunks of n corners, n known to the compiler."""
    size = U64(n)

    @inner
    def near(lanes: np.int32, ca: Single, x: int, cb: Single, y: int, edge: F32, angle: F32, limit: F32) -> Any:
        own, first = U64(x), U64(y)
        mask = np.int32(0)
        for s in range(size):
            # At most shifts the edges of no trunk match, so that angles need not be compared.
            close = np.int32(0)
            for lane in range(LANES):
                e = np.float32(0.0)
                for j in range(size):
                    m = s + j if s + j < size else s + j - size
                    e += abs(ca[own + (size - U64(1) - j) * LANES] - cb[first + m * LANES + lane])
                close = np.int32(close | (LANE_BITS[lane] if e * edge <= limit else np.int32(0)))
            close = np.int32(close & lanes)
            if close == 0:
                continue
            for lane in range(LANES):
                g = np.float32(0.0)
                for j in range(size):
                    m = s + j if s + j < size else s + j - size
                    back = size - j if j > U64(0) else U64(0)
                    g += abs(ca[own + (size + size + back) * LANES] - cb[first + (size + m) * LANES + lane])
                    g += abs(ca[own + (size + back) * LANES] - cb[first + (size + size + m) * LANES + lane])
                mask = np.int32(mask | ((close & LANE_BITS[lane]) if g * angle <= limit else np.int32(0)))
        return mask

    return near


_near_3, _near_4, _near_5, _near_6 = _near_for(3), _near_for(4), _near_for(5), _near_for(6)


@inner
def _near_any(
    n: int, lanes: np.int32, ca: Single, x: int, cb: Single, y: int, edge: F32, angle: F32, limit: F32
) -> Any:
    """As `lanes_near`, of some ``lanes`` of the leaf, one by one: with many corners most shifts end at the edges."""
    size, own, first = U64(n), U64(x), U64(y)
    mask = np.int32(0)
    for lane in range(LANES):
        if lanes & LANE_BITS[lane] == 0:
            continue
        for s in range(size):
            e, g = np.float32(0.0), np.float32(0.0)
            for j in range(size):
                m = s + j if s + j < size else s + j - size
                e += abs(ca[own + (size - U64(1) - j) * LANES] - cb[first + m * LANES + lane])
            if e * edge > limit:
                continue
            for j in range(size):
                m = s + j if s + j < size else s + j - size
                back = size - j if j > U64(0) else U64(0)
                g += abs(ca[own + (size + size + back) * LANES] - cb[first + (size + m) * LANES + lane])
                g += abs(ca[own + (size + back) * LANES] - cb[first + (size + size + m) * LANES + lane])
            if g * angle <= limit:
                mask = np.int32(mask | LANE_BITS[lane])
                break
    return mask


@inlined
def lanes_near(
    n: int, lanes: np.int32, ca: Single, x: int, cb: Single, y: int, edge: F32, angle: F32, limit: F32
) -> Any:
    """Which trunks of a leaf may be, at some shift, within ``limit`` of another trunk, their areas aside: one bit each.

    The leaf's corners begin at y, those of the other trunk at x.
    """
    if n == 4:
        return _near_4(lanes, ca, x, cb, y, edge, angle, limit)
    if n == 3:
        return _near_3(lanes, ca, x, cb, y, edge, angle, limit)
    if n == 5:
        return _near_5(lanes, ca, x, cb, y, edge, angle, limit)
    if n == 6:
        return _near_6(lanes, ca, x, cb, y, edge, angle, limit)
    return _near_any(n, lanes, ca, x, cb, y, edge, angle, limit)


@inner
def exact_distance(
    n: int, x: int, y: int, ea: FloatArray, aa: FloatArray, ba: FloatArray, eb: FloatArray, ab: FloatArray,
    bb: FloatArray, edge: float, angle: float, area: float,
) -> tuple[float, int]:  # fmt: skip
    """D of two trunks whose corners begin at x and y, and the first shift that gives it; ``area`` is its area term.

    Sums run as in `riot.kernels.pairs.brute_pair`, to the same bits.
    """
    best, shift = np.inf, -1
    for s in range(n):
        e, g = 0.0, 0.0
        k = s
        for j in range(n):
            g += abs(ba[x + j] - ab[y + k]) + abs(aa[x + j] - bb[y + k])
            k = k - 1 if k > 0 else n - 1
            e += abs(ea[x + j] - eb[y + k])
        far = max(area, max(e * edge, g * angle))
        if far < best:
            best, shift = far, s
    return best, shift


@inner
def improve(tops: FloatArray, old: float, new: float) -> None:
    """Replace an owner's old distance among the least distances, ascending, by its new one; the last one if it is not
    there."""
    at = len(tops) - 1
    while at > 0 and tops[at] > old:
        at -= 1
    if tops[at] != old:
        at = len(tops) - 1
    while at > 0 and tops[at - 1] > new:
        tops[at] = tops[at - 1]
        at -= 1
    tops[at] = new


@inner
def reach_of(worst: float, limit: float, epsilon: float) -> float:
    """How far a search looks that has found partners up to the distance ``worst``, if that is less than its ``limit``.

    What is farther scores less than exp(−worst²/2) + ε: the search loses at most ε of any score.
    """
    if epsilon == 0.0 or worst >= limit:
        return worst
    score = math.exp(-0.5 * worst * worst) + epsilon
    return math.sqrt(-2.0 * math.log(score)) if score < 1.0 else 0.0


def one_triangle() -> Forest:
    """A forest of one trunk, on which kernels compile: its arrays have the types of those of any forest."""
    ends, corners = np.array([0, 1], dtype=np.int64), np.ones(3)
    forest = Forest(
        ends, np.array([3], dtype=np.int64), ends, ends, np.array([0, 9 * QCRS_LEAF], dtype=np.int64),
        np.zeros((1, QCRS_LEAF), np.int32), np.ones((1, FEATURES, QCRS_LEAF), np.float32),
        np.ones((1, 2 * FEATURES, TILE_LEAVES), np.float32), np.ones(9 * QCRS_LEAF, np.float32),
        ends, np.array([0, 3], dtype=np.int64), corners, corners, corners, np.ones(1),
    )  # fmt: skip
    for array in forest:
        array.flags.writeable = False
    return forest
