"""The nearest trunks of many shapes in an index at once: a k-nearest-neighbour join (theory §6; the join is ours).

Both sides are laid out in cells: on the one the trunks of all queries, on the other those of the index. Two cells, then
two leaves, then trunks are compared as in `riot.kernels.search`, each trunk as far as its shape's worst partner so far.
What the queries share is read and bounded once, where a search for each of them would do so every time.
"""

from __future__ import annotations

from typing import NamedTuple

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
    lanes_beside_each,
    lanes_near,
    lanes_within,
    one_triangle,
    reach_of,
    row_bounds,
)
from riot.kernels.forest import Forest, Int32Array, Scale, Single
from riot.kernels.options import inner, kernel
from riot.types import FloatArray, IntArray

SAME_SCORE = 2.0
"""How many times the rounding of a bound a distance may exceed the worst partner's: it may have the same score."""


class Found(NamedTuple):
    """What a join finds: ``tops`` (q, k) the least distances of every query's partners so far, ascending; for query i
    and owner j ``bests`` (q, p) D, below 0 for a pair that does not count, ``winners`` (q, p, 3) trunks, that of the
    first shape first, and shift."""

    tops: FloatArray
    bests: FloatArray
    winners: Int32Array


class Cells(NamedTuple):
    """One side: its cells as a forest, their boxes laid out as those of leaves, and the owner (shape) of each trunk."""

    forest: Forest
    crowns: Single
    owners: Int32Array


@inner
def _reaches(
    cell: int, a: Forest, owners: Int32Array, scale: Scale, most: FloatArray, tops: FloatArray, reaches: Single
) -> np.float32:
    """Fill ``reaches`` (leaves, QCRS_LEAF + 1): how far each trunk of a cell looks, and the farthest of each leaf;
    returns the farthest of all."""
    last = tops.shape[1] - 1
    farthest = np.float32(-1.0)
    for x in range(a.leaves[cell], a.leaves[cell + 1]):
        row, far = x - a.leaves[cell], np.float32(-1.0)
        for k in range(QCRS_LEAF):
            o = owners[a.trunks[x, k]]
            reach = np.float32(reach_of(tops[o, last], most[o], scale.epsilon) + SAME_SCORE * scale.slack)
            reaches[row, k] = reach
            far = max(far, reach)
        reaches[row, QCRS_LEAF] = far
        farthest = max(farthest, far)
    return farthest


@kernel
def _join(
    queries: Cells, index: Cells, scale: Scale, earlier: IntArray, most: FloatArray, found: Found, reaches: Single,
    of_leaves: Single, bounds: Single, box: Single,
) -> None:  # fmt: skip
    # To take an array out of a tuple costs more than most of what is done with it below.
    a, b, owners_a, owners_b = queries.forest, index.forest, queries.owners, index.owners
    crowns_a, crowns_b = queries.crowns, index.crowns
    sizes_a, leaves_a, tiles_a, begins_a = a.sizes, a.leaves, a.tiles, a.begins
    trunks_a, features_a, boxes_a, facing_a, offsets_a = a.trunks, a.features, a.boxes, a.facing, a.offsets
    ea, aa, ba, wa = a.edges, a.alphas, a.betas, a.areas
    sizes_b, leaves_b, tiles_b, begins_b = b.sizes, b.leaves, b.tiles, b.begins
    trunks_b, features_b, boxes_b, facing_b, offsets_b = b.trunks, b.features, b.boxes, b.facing, b.offsets
    eb, ab, bb, wb = b.edges, b.alphas, b.betas, b.areas
    tops, bests, winners = found.tops, found.bests, found.winners
    sigma_area, allowance, last = scale.area, SAME_SCORE * scale.slack, tops.shape[1] - 1
    area, cells_b = np.float32(2.0 / sigma_area), len(sizes_b)
    for cell_a in range(len(sizes_a)):
        n = sizes_a[cell_a]
        inverse_edge, inverse_angle = 1.0 / (n * scale.edge), 1.0 / (2.0 * n * scale.angle)
        edge, angle = np.float32(inverse_edge), np.float32(inverse_angle)
        first, count = leaves_a[cell_a], leaves_a[cell_a + 1] - leaves_a[cell_a]
        farthest = _reaches(cell_a, a, owners_a, scale, most, tops, reaches)
        for cell_b in range(cells_b):
            if sizes_b[cell_b] != n:
                continue
            # The crown of a cell here against the crowns of 32 cells there, whenever a tile of them begins.
            if cell_b % TILE_LEAVES == 0 or sizes_b[cell_b - 1] != n:
                for f in range(2 * FEATURES):
                    box[f] = crowns_a[cell_a // TILE_LEAVES, f, cell_a % TILE_LEAVES]
                row_bounds(box, crowns_b, cell_b // TILE_LEAVES, TILE_LEAVES, edge, angle, area, bounds, 0, 0)
            if bounds[0, 0, cell_b % TILE_LEAVES] > farthest:
                continue
            # The crown there against the leaves here.
            for f in range(2 * FEATURES):
                box[f] = crowns_b[cell_b // TILE_LEAVES, f, cell_b % TILE_LEAVES]
            low = INFINITY_BITS
            for column in range(tiles_a[cell_a + 1] - tiles_a[cell_a]):
                wide = min(TILE_LEAVES, count - column * TILE_LEAVES)
                tile = tiles_a[cell_a] + column
                low = min(low, row_bounds(box, boxes_a, tile, wide, edge, angle, area, of_leaves, 0, column))
            if low > np.float32(farthest).view(np.int32):
                continue
            narrowed = False
            facing_leaves = leaves_b[cell_b + 1] - leaves_b[cell_b]
            for row in range(count):
                reach = reaches[row, QCRS_LEAF]
                if of_leaves[0, row // TILE_LEAVES, row % TILE_LEAVES] > reach:
                    continue
                x, tile = first + row, tiles_a[cell_a] + row // TILE_LEAVES
                for f in range(2 * FEATURES):
                    box[f] = boxes_a[tile, f, row % TILE_LEAVES]
                begin_a = begins_a[cell_a] + row * QCRS_LEAF * CORNER_VALUES * n
                for column in range(tiles_b[cell_b + 1] - tiles_b[cell_b]):
                    wide, tile = min(TILE_LEAVES, facing_leaves - column * TILE_LEAVES), tiles_b[cell_b] + column
                    low = row_bounds(box, boxes_b, tile, wide, edge, angle, area, bounds, 1, 0)
                    if low > np.float32(reach).view(np.int32):
                        continue
                    for lane in range(wide):
                        if bounds[1, 0, lane] > reach:
                            continue
                        y = leaves_b[cell_b] + column * TILE_LEAVES + lane
                        begin_b = begins_b[cell_b] + (column * TILE_LEAVES + lane) * QCRS_LEAF * CORNER_VALUES * n
                        lanes = lanes_beside_each(
                            features_a, x, boxes_b, tile, lane, edge, angle, area, reaches, row
                        )  # fmt: skip
                        k = -1
                        while lanes != 0:
                            k += 1
                            if lanes & LANE_BITS[k] == 0:
                                continue
                            lanes ^= LANE_BITS[k]
                            t = trunks_a[x, k]
                            if k > 0 and t == trunks_a[x, k - 1]:
                                break  # a short leaf repeats its last trunk
                            near, i = reaches[row, k], owners_a[t]
                            mask = lanes_within(features_a, x, k, features_b, y, edge, angle, area, near)
                            if mask != 0:
                                mask &= lanes_near(
                                    n, mask, facing_a, begin_a + k, facing_b, begin_b, edge, angle, near
                                )  # fmt: skip
                            m = -1
                            while mask != 0:
                                m += 1
                                if mask & LANE_BITS[m] == 0:
                                    continue
                                mask ^= LANE_BITS[m]
                                u = trunks_b[y, m]
                                j = owners_b[u]
                                if bests[i, j] < 0.0:
                                    continue
                                one, two = t, u
                                if j < earlier[i]:
                                    one, two = u, t
                                    far, s = exact_distance(
                                        n, offsets_b[u], offsets_a[t], eb, ab, bb, ea, aa, ba, inverse_edge,
                                        inverse_angle, 2.0 * abs(wb[u] + wa[t] - 1.0) / sigma_area,
                                    )  # fmt: skip
                                else:
                                    far, s = exact_distance(
                                        n, offsets_a[t], offsets_b[u], ea, aa, ba, eb, ab, bb, inverse_edge,
                                        inverse_angle, 2.0 * abs(wa[t] + wb[u] - 1.0) / sigma_area,
                                    )  # fmt: skip
                                if far > tops[i, last] + allowance or far > bests[i, j]:
                                    continue
                                if (
                                    far < bests[i, j]
                                    or one < winners[i, j, 0]
                                    or (one == winners[i, j, 0] and two < winners[i, j, 1])
                                ):
                                    if far < tops[i, last]:
                                        improve(tops[i], bests[i, j], far)
                                        narrowed = True
                                        reach_now = reach_of(tops[i, last], most[i], scale.epsilon)
                                        near = np.float32(reach_now + allowance)
                                        reaches[row, k] = near
                                    bests[i, j] = far
                                    winners[i, j, 0], winners[i, j, 1], winners[i, j, 2] = one, two, s
            if narrowed:
                farthest = _reaches(cell_a, a, owners_a, scale, most, tops, reaches)


def join(queries: Cells, index: Cells, scale: Scale, earlier: IntArray, found: Found) -> None:
    """Find the nearest owners of the index's trunks for every query, narrowing ``found``.

    A pair counts if its D is at most the worst of the query's ``tops``, or so little greater that its score may be the
    same; with `Scale.epsilon`, less far. Owners below ``earlier`` (q,) come before query i in a pair, and after it the
    others: the order decides how sums run, and which of equal trunks wins. The margin of ``scale`` is not used.
    """
    leaves = int(np.diff(queries.forest.leaves).max(initial=1))
    tiles = -(-leaves // TILE_LEAVES)
    _join(
        queries,
        index,
        scale,
        earlier,
        found.tops[:, -1].copy(),
        found,
        np.empty((leaves, QCRS_LEAF + 1), np.float32),
        np.empty((1, tiles, TILE_LEAVES), np.float32),
        np.empty((2, 1, TILE_LEAVES), np.float32),
        np.empty(2 * FEATURES, np.float32),
    )


def warm() -> None:
    """Compile on a triangle."""
    forest = one_triangle()
    cells = Cells(forest, np.ones((1, 2 * FEATURES, TILE_LEAVES), np.float32), np.zeros(1, np.int32))
    found = Found(np.ones((1, 1)), np.ones((1, 1)), np.full((1, 1, 3), -1, np.int32))
    join(cells, cells, Scale(0.1, 0.5, 0.1, 1e-4, 1.0, 0.0), np.zeros(1, np.int64), found)
