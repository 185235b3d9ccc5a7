"""The nearest trunks of two shapes: the search of QCRS (theory §6; the bounds are ours).

The search gives the distance D and the winner of `riot.kernels.pairs`, exactly if `Scale.epsilon` is 0. It goes from
coarse to fine, with the distances of `riot.kernels.bounds`:

1. between boxes around leaves of 16 similar trunks (`row_bounds`), and of their trunks from a box (`lanes_beside`);
2. between the features of trunks, sixteen at a time (`lanes_within`);
3. all shifts of two trunks in single precision (`lanes_near`);
4. D itself in double precision (`exact_distance`), some two dozen times for two shapes.

The first three are lower bounds of D in single precision, and prune only what exceeds the best D so far by more than
all their rounding can be (`slack`). The leaf pairs of least bound come first, so that the best D is small early.

A `riot.kernels.forest.Forest` has the data that the search reads.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from riot.kernels.bounds import (
    CORNER_VALUES,
    FEATURES,
    INFINITY_BITS,
    LANE_BITS,
    QCRS_LEAF,
    TILE_LEAVES,
    exact_distance,
    improve,
    lanes_beside,
    lanes_near,
    lanes_within,
    least_bound,
    one_triangle,
    reach_of,
    row_bounds,
)
from riot.kernels.forest import Forest, Int32Array, Scale, Single
from riot.kernels.options import inner, kernel
from riot.types import FloatArray, IntArray

FIRST_ROWS = 8
"""Leaves that the first sweep visits, the nearest. Ours: any number gives the same result."""


@inner
def _sort(values: IntArray, count: int) -> None:
    """Sort the first ``count`` values, ascending (Shell's method)."""
    gap = 1
    while gap < count // 3:
        gap = 3 * gap + 1
    while gap > 0:
        for k in range(gap, count):
            value, at = values[k], k
            while at >= gap and values[at - gap] > value:
                values[at] = values[at - gap]
                at -= gap
            values[at] = value
        gap //= 3


class SearchBuffers(NamedTuple):
    """Scratch arrays of a search: the bounds of `row_bounds`, the least of each row, the leaves of each row, the rows
    in order, a box."""

    bounds: Single
    least: Int32Array
    rows: IntArray
    order: IntArray
    box: Single


@inner
def _nearest(
    i: int, a: Forest, j: int, b: Forest, scale: Scale, buffers: SearchBuffers, lone: bool, most: float, apart: Single,
    owners: Int32Array, earlier: int, tops: FloatArray, bests: FloatArray, winners: Int32Array, met: Int32Array,
    nearest: FloatArray,
) -> None:  # fmt: skip
    """For every owner of trunks of shape j, find the one nearest to a trunk of shape i, if the owner may be among the
    len(tops) nearest.

    If not ``lone``, j is a cell, and the leaves of shape i that are too far ``apart`` from it are passed over.

    ``owners`` (t,) are the owners of b's trunks; those below ``earlier`` come first in a pair, and shape i before the
    others: the order decides how sums run, and which of equal trunks wins. ``tops`` (k,) are the least distances of k
    owners so far, ascending; the search reaches as far as the last, times the margin of the scale, or as `reach_of`
    says once that is below ``most``, with which it began. For every owner ``bests`` becomes D, ``winners`` (T, T',
    shift), the trunk of the first shape first, with trunks numbered among all, and ``met`` 1 where D of two trunks was
    computed. ``nearest`` (a's trunks,) becomes the least D of every trunk that is within reach of another. An owner
    whose entry of ``bests`` is below 0 counts for nothing.
    """
    # To take an array out of a tuple costs more than most of what is done with it below.
    groups_a, sizes_a, leaves_a, tiles_a, begins_a = a.groups, a.sizes, a.leaves, a.tiles, a.begins
    trunks_a, features_a, boxes_a, facing_a, offsets_a = a.trunks, a.features, a.boxes, a.facing, a.offsets
    ea, aa, ba, wa = a.edges, a.alphas, a.betas, a.areas
    groups_b, sizes_b, leaves_b, tiles_b, begins_b = b.groups, b.sizes, b.leaves, b.tiles, b.begins
    trunks_b, features_b, boxes_b, facing_b, offsets_b = b.trunks, b.features, b.boxes, b.facing, b.offsets
    eb, ab, bb, wb = b.edges, b.alphas, b.betas, b.areas
    bounds, least, rows, order, box = buffers.bounds, buffers.least, buffers.rows, buffers.order, buffers.box
    sigma_edge, sigma_angle, sigma_area, slack = scale.edge, scale.angle, scale.area, scale.slack
    margin, epsilon = scale.margin, scale.epsilon
    reach = margin * reach_of(tops[-1], most, epsilon)
    area = np.float32(2.0 / sigma_area)
    limit = np.float32(np.float32(reach + slack)).view(np.int32)
    count, first_leaf = 0, leaves_a[groups_a[i]]
    g, h = groups_a[i], groups_b[j]
    while g < groups_a[i + 1] and h < groups_b[j + 1]:
        if sizes_a[g] != sizes_b[h]:
            if sizes_a[g] < sizes_b[h]:
                g += 1
            else:
                h += 1
            continue
        n = sizes_a[g]
        edge, angle = np.float32(1.0 / (n * sigma_edge)), np.float32(1.0 / (2.0 * n * sigma_angle))
        facing_leaves = leaves_b[h + 1] - leaves_b[h]
        for x in range(leaves_a[g + 1] - leaves_a[g]):
            if not lone:
                distance = apart[leaves_a[g] + x - first_leaf, j // TILE_LEAVES, j % TILE_LEAVES]
                if np.float32(distance).view(np.int32) > limit:
                    continue
            tile, lane = tiles_a[g] + x // TILE_LEAVES, x % TILE_LEAVES
            for f in range(2 * FEATURES):
                box[f] = boxes_a[tile, f, lane]
            low: Any = INFINITY_BITS
            for column in range(tiles_b[h + 1] - tiles_b[h]):
                wide = min(TILE_LEAVES, facing_leaves - column * TILE_LEAVES)
                low = min(
                    low, row_bounds(box, boxes_b, tiles_b[h] + column, wide, edge, angle, area, bounds, count, column)
                )
            least[count] = low
            rows[count, 0], rows[count, 1], rows[count, 2] = g, h, x
            count += 1
        g += 1
        h += 1
    # By the least bound, and among equals by the number of the row: both are in the bits of one number.
    for row in range(count):
        order[row] = (np.int64(least[row]) << 32) | row
    _sort(order, count)
    # The first sweep visits only the nearest leaf of a few leaves, and only its nearest trunks: it gives a limit to the
    # second. A search with a limit needs no first sweep.
    for sweep in range(0 if reach == np.inf else 1, 2):
        for rank in range(count if sweep == 1 else min(count, FIRST_ROWS)):
            r = order[rank] & 0xFFFFFFFF
            near = np.float32(reach + slack)
            if least[r] > np.float32(near).view(np.int32):
                break
            g, h, x = rows[r, 0], rows[r, 1], leaves_a[rows[r, 0]] + rows[r, 2]
            n = sizes_a[g]
            edge, angle = np.float32(1.0 / (n * sigma_edge)), np.float32(1.0 / (2.0 * n * sigma_angle))
            begin_a = begins_a[g] + rows[r, 2] * QCRS_LEAF * CORNER_VALUES * n
            enough = np.int32(least[r]) if sweep == 0 else np.float32(near).view(np.int32)
            for column in range(tiles_b[h + 1] - tiles_b[h]):
                for lane in range(min(TILE_LEAVES, leaves_b[h + 1] - leaves_b[h] - column * TILE_LEAVES)):
                    if np.float32(bounds[r, column, lane]).view(np.int32) > enough:
                        continue
                    y = leaves_b[h] + column * TILE_LEAVES + lane
                    begin_b = begins_b[h] + (column * TILE_LEAVES + lane) * QCRS_LEAF * CORNER_VALUES * n
                    near = np.float32(reach + slack)
                    if sweep == 0:
                        first = 0
                        lowest = INFINITY_BITS
                        for k in range(QCRS_LEAF):
                            low = least_bound(features_a, x, k, features_b, y, edge, angle, area)
                            if low < lowest:
                                lowest, first = low, k
                        near, lanes = np.int32(lowest).view(np.float32), LANE_BITS[first]
                    else:
                        lanes = lanes_beside(features_a, x, boxes_b, tiles_b[h] + column, lane, edge, angle, area, near)
                    k = -1
                    while lanes != 0:
                        k += 1
                        if lanes & LANE_BITS[k] == 0:
                            continue
                        lanes ^= LANE_BITS[k]
                        if k > 0 and trunks_a[x, k] == trunks_a[x, k - 1]:
                            break  # a short leaf repeats its last trunk
                        mask = lanes_within(features_a, x, k, features_b, y, edge, angle, area, near)
                        if sweep == 1 and mask != 0:
                            mask &= lanes_near(n, mask, facing_a, begin_a + k, facing_b, begin_b, edge, angle, near)
                        m = -1
                        while mask != 0:
                            m += 1
                            if mask & LANE_BITS[m] == 0:
                                continue
                            mask ^= LANE_BITS[m]
                            t, u = trunks_a[x, k], trunks_b[y, m]
                            o = owners[u]
                            met[o] = 1
                            inverse_edge, inverse_angle = 1.0 / (n * sigma_edge), 1.0 / (2.0 * n * sigma_angle)
                            one, two = t, u
                            if o < earlier:
                                one, two = u, t
                                far, s = exact_distance(
                                    n, offsets_b[u], offsets_a[t], eb, ab, bb, ea, aa, ba, inverse_edge, inverse_angle,
                                    2.0 * abs(wb[u] + wa[t] - 1.0) / sigma_area,
                                )  # fmt: skip
                            else:
                                far, s = exact_distance(
                                    n, offsets_a[t], offsets_b[u], ea, aa, ba, eb, ab, bb, inverse_edge, inverse_angle,
                                    2.0 * abs(wa[t] + wb[u] - 1.0) / sigma_area,
                                )  # fmt: skip
                            if bests[o] >= 0.0:
                                nearest[t] = min(nearest[t], far)
                            if far > tops[-1] or far > bests[o]:
                                continue
                            if far < bests[o] or one < winners[o, 0] or (one == winners[o, 0] and two < winners[o, 1]):
                                improve(tops, bests[o], far)
                                bests[o] = far
                                winners[o, 0], winners[o, 1], winners[o, 2] = one, two, s
                                reach = margin * reach_of(tops[-1], most, epsilon)
                                if sweep == 1:
                                    near = np.float32(reach + slack)
                    enough = np.int32(-1) if sweep == 0 else np.float32(near).view(np.int32)


@kernel
def _search(
    pairs: IntArray, limits: FloatArray, lone: bool, far: Single, a: Forest, b: Forest, scale: Scale,
    buffers: SearchBuffers, owners: Int32Array, earlier: int, tops: FloatArray, bests: FloatArray, winners: Int32Array,
    met: Int32Array, nearest: FloatArray, out: FloatArray, out_winners: Int32Array,
) -> None:  # fmt: skip
    """`_nearest` of ``pairs`` (k, 2) of shape numbers, one after the other.

    If ``lone``, every pair has its own limit and its own result, of one owner: ``out`` (k,), ``out_winners`` (k, 3).
    Otherwise the pairs share ``tops``, ``bests`` and ``winners``, and the search ends at the first pair whose limit is
    greater than the last of ``tops``. One kernel does both, since most of the compiler's work is `_nearest`.
    """
    most = tops[-1]
    for k in range(pairs.shape[0]):
        if lone:
            most = limits[k]
            tops[0], bests[0], winners[0, 0] = limits[k], np.inf, -1
            winners[0, 1] = winners[0, 2] = -1
        elif limits[k] > scale.margin * reach_of(tops[-1], most, scale.epsilon) + scale.slack:
            break
        _nearest(
            pairs[k, 0], a, pairs[k, 1], b, scale, buffers, lone, most, far, owners, earlier, tops, bests, winners, met,
            nearest,
        )  # fmt: skip
        if lone:
            out[k] = bests[0]
            for c in range(3):
                out_winners[k, c] = winners[0, c]


@kernel
def _cell_distances(i: int, a: Forest, b: Forest, crowns: Single, scale: Scale, far: Single, box: Single) -> None:
    """Fill ``far`` (leaves of shape i of a, tiles, TILE_LEAVES) with bounds of the leaves' distances from b's cells."""
    groups, sizes, leaves, tiles, boxes = a.groups, a.sizes, a.leaves, a.tiles, a.boxes
    cells, cell_sizes = b.groups, b.sizes
    area, lanes = np.float32(2.0 / scale.area), far.shape[2]
    for g in range(groups[i], groups[i + 1]):
        n = sizes[g]
        edge, angle = np.float32(1.0 / (n * scale.edge)), np.float32(1.0 / (2.0 * n * scale.angle))
        for x in range(leaves[g + 1] - leaves[g]):
            for f in range(2 * FEATURES):
                box[f] = boxes[tiles[g] + x // TILE_LEAVES, f, x % TILE_LEAVES]
            row = leaves[g] + x - leaves[groups[i]]
            for tile in range(crowns.shape[0]):
                first, last = tile * TILE_LEAVES, min((tile + 1) * TILE_LEAVES, len(cells) - 1) - 1
                # Cells come in order of n.
                if cell_sizes[cells[first]] <= n <= cell_sizes[cells[last]]:
                    row_bounds(box, crowns, tile, lanes, edge, angle, area, far, row, tile)
                for cell in range(first, last + 1):
                    if cell_sizes[cells[cell]] != n:
                        far[row, tile, cell - first] = np.inf


def make_buffers(a: Forest, b: Forest) -> SearchBuffers:
    """Scratch arrays for any shape of a against any of b."""
    rows = int(np.diff(a.leaves[a.groups]).max(initial=1))
    columns = int(np.diff(b.tiles).max(initial=1))
    return SearchBuffers(
        np.empty((rows, columns, TILE_LEAVES), np.float32),
        np.empty(rows, np.int32),
        np.empty((rows, 3), np.int64),
        np.empty(rows, np.int64),
        np.empty(2 * FEATURES, np.float32),
    )


def block(
    pairs: IntArray, a: Forest, b: Forest, scale: Scale, limits: FloatArray, out: FloatArray, winners: Int32Array
) -> None:
    """QCRS of ``pairs`` (k, 2) of shape numbers: fills ``out`` (k,) with D, ``winners`` (k, 3) with (T, T', shift).

    Only distances up to ``limits`` (k,) count; a pair without one has inf, −1. Trunks are numbered within their shapes;
    among equals the first by (T, T', shift) wins.
    """
    owners, met, far = np.zeros(len(b.areas), np.int32), np.empty(1, np.int32), np.empty((1, 1, 1), np.float32)
    top, best, winner, nearest = np.empty(1), np.empty(1), np.empty((1, 3), np.int32), np.empty(len(a.areas))
    buffers = make_buffers(a, b)
    _search(pairs, limits, True, far, a, b, scale, buffers, owners, 0, top, best, winner, met, nearest, out, winners)
    there = winners[:, 0] >= 0
    winners[there, 0] -= a.starts[pairs[there, 0]].astype(np.int32)
    winners[there, 1] -= b.starts[pairs[there, 1]].astype(np.int32)


def partners(
    i: int, a: Forest, b: Forest, owners: Int32Array, earlier: int, crowns: Single, scale: Scale, tops: FloatArray,
    bests: FloatArray, winners: Int32Array, met: Int32Array, nearest: FloatArray,
) -> None:  # fmt: skip
    """The nearest owners of b's trunks for shape i of a: see `_nearest`. b's "shapes" are cells of similar trunks.

    ``crowns`` (tiles, 2 FEATURES, TILE_LEAVES) are the boxes of the cells, laid out as those of leaves. Cells are
    searched in order of their distance, up to the last of ``tops``.
    """
    buffers, cells = make_buffers(a, b), len(b.groups) - 1
    rows = int(a.leaves[a.groups[i + 1]] - a.leaves[a.groups[i]])
    if rows == 0 or cells == 0:
        return
    far = np.empty((rows, len(crowns), TILE_LEAVES), np.float32)
    _cell_distances(i, a, b, crowns, scale, far, buffers.box)
    distances = far.min(axis=0).reshape(-1)[:cells]
    order = np.argsort(distances, kind="stable")
    pairs = np.empty((len(order), 2), np.int64)
    pairs[:, 0], pairs[:, 1] = i, order
    limits = distances[order].astype(np.float64)
    _search(
        pairs, limits, False, far, a, b, scale, buffers, owners, earlier, tops, bests, winners, met, nearest, bests,
        winners,
    )  # fmt: skip


def warm() -> None:
    """Compile on a triangle."""
    forest = one_triangle()
    out, winners = np.empty(1), np.empty((1, 3), np.int32)
    block(
        np.zeros((1, 2), np.int64),
        forest,
        forest,
        Scale(0.1, 0.5, 0.1, 1e-4, 1.0, 0.0),
        np.full(1, np.inf),
        out,
        winners,
    )
    crowns, met = np.ones((1, 2 * FEATURES, TILE_LEAVES), np.float32), np.zeros(1, np.int32)
    partners(
        0,
        forest,
        forest,
        met,
        0,
        crowns,
        Scale(0.1, 0.5, 0.1, 1e-4, 1.0, 0.0),
        np.ones(1),
        np.ones(1),
        winners,
        met,
        np.ones(1),
    )
