"""Candidates of CRS: the trunk pairs of two shapes in order of a cheap lower bound (theory §6; pruning ours).

The bound of trunk T of P and trunk T' of Q, both n-gons, at shift s, with vertex j of T on vertex (s − j) mod n of T'::

    max( Σ|e − e'| / (n σ_E),  (Σ|β − α'| + Σ|α − β'|) / (2 n σ_∠),  (|area deficit| − slack) / σ_A )

A piece that swings onto the other trunk is scaled by the ratio of the edges, and its area by the square of that. So the
area term is at least |trunk area − Σ pieces|, less a slack for the error of the scanlines.

At every shift the first two terms are at least the L1 distances of the sorted edges and angles, and two trunks are at
least as far apart as boxes around them. So the trunks of one n of a shape are divided into leaves of similar trunks,
and the pairs of leaves are searched in order of the distance of their boxes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riot.kernels.options import inner, kernel
from riot.types import FloatArray, IntArray

PRUNING_SLACK = 1e-12
"""A lower bound prunes only if it exceeds the limit by more than this: it is summed in another order than the distance.

Ours: distances are of order 1, and sums of some dozen terms round by about 1e-15."""

CRS_LEAF = 8
"""Least number of trunks in a leaf of the CRS search. Ours: any number gives the same result, this one a quick
search."""

CRS_LEAVES = 64
"""Greatest number of leaves of one n, about: shapes with more trunks get larger leaves. Ours: any number gives the same
result, and all pairs of leaves are bounded, so that their number is kept low."""

_STACK = 64
"""Ranges that wait to be halved: more than the binary logarithm of any number of trunks."""


class TrunkSide(NamedTuple):
    """The trunks of one shape, laid out for the CRS search: in order of n and, within one n, of the leaves.

    ``order`` (t,) the trunks' numbers; ``areas`` (t,) of the trunks; ``spreads`` (t,) |Σβ − (n − 2)π|, the least that
    Σ|β − α'| can be; ``begins`` (t + 1,) where the corners of each trunk begin. For a trunk whose corners begin at x,
    ``ranked`` (3 s,) has n edges, n alphas and n betas from 3 x on, each in ascending order, and ``corners`` (4 s,) has
    n edges, n alphas, n betas and n signed areas of the exterior pieces on the edges from 4 x on. ``leaves`` (l + 1,)
    where the trunks of each leaf begin; ``boxes`` (l + 1,) where the 3 n entries of each leaf begin in ``low`` and
    ``high``, which are the least and greatest of every entry of ``ranked`` in the leaf.
    """

    order: IntArray
    areas: FloatArray
    spreads: FloatArray
    begins: IntArray
    ranked: FloatArray
    corners: FloatArray
    leaves: IntArray
    boxes: IntArray
    low: FloatArray
    high: FloatArray


class Units(NamedTuple):
    """σ_E, σ_∠ and σ_A in absolute units, and the greatest error of the area term by scanlines."""

    edge: float
    angle: float
    area: float
    slack: float


@kernel
def piece_areas(points: FloatArray, running: FloatArray, offsets: IntArray, vertices: IntArray) -> FloatArray:
    """(s,) signed area of the exterior piece on every edge of every trunk; ``running`` is
    `riot.geometry.polyline.swept_area`'s of the shape's points (m, 2)."""
    areas = np.empty(len(vertices))
    for t in range(len(offsets) - 1):
        for k in range(offsets[t], offsets[t + 1]):
            start, stop = vertices[k], vertices[k + 1 if k + 1 < offsets[t + 1] else offsets[t]]
            swept = running[stop] - running[start] + (running[len(running) - 1] if stop < start else 0.0)
            chord = points[stop, 0] * points[start, 1] - points[stop, 1] * points[start, 0]
            areas[k] = swept + 0.5 * chord
    return areas


@kernel
def arrange(
    offsets: IntArray, edges: FloatArray, alphas: FloatArray, betas: FloatArray, pieces: FloatArray, areas: FloatArray
) -> TrunkSide:
    """Divide the trunks of one shape into leaves; ``pieces`` are `piece_areas`."""
    trunks, total = len(areas), len(edges)
    longest = 0
    values = np.empty(total)
    for t in range(trunks):
        longest = max(longest, offsets[t + 1] - offsets[t])
        _rank(edges, offsets[t], offsets[t + 1], values, offsets[t])
    order, keys = np.empty(trunks, dtype=np.int64), np.empty(trunks)
    leaves, ends, count, filled = np.zeros(trunks + 1, dtype=np.int64), np.empty(_STACK, dtype=np.int64), 0, 0
    for n in range(1, longest + 1):
        begin = filled
        for t in range(trunks):
            if offsets[t + 1] - offsets[t] == n:
                order[filled] = t
                filled += 1
        size = max(CRS_LEAF, (filled - begin + CRS_LEAVES - 1) // CRS_LEAVES)
        # Ends of the ranges that remain, the next one last; a range is halved until it is small enough for a leaf.
        ends[0], top = filled, 0
        while begin < filled:
            end = ends[top]
            if end - begin <= size:
                count += 1
                leaves[count] = begin = end
                top -= 1
                continue
            rank = _widest(values, offsets, order, begin, end, n)
            for k in range(begin, end):
                keys[k] = values[offsets[order[k]] + rank]
            middle = begin + ((end - begin) // 2 + size - 1) // size * size
            _select(keys, order, begin, end - 1, middle)
            top += 1
            ends[top] = middle
    begins, boxes, spreads = np.zeros(trunks + 1, dtype=np.int64), np.zeros(count + 1, dtype=np.int64), np.zeros(trunks)
    ranked, corners = np.empty(3 * total), np.empty(4 * total)
    low, high = np.full(3 * total, np.inf), np.full(3 * total, -np.inf)
    for leaf in range(count):
        box = boxes[leaf]
        for k in range(leaves[leaf], leaves[leaf + 1]):
            x, stop = offsets[order[k]], offsets[order[k] + 1]
            n = stop - x
            begins[k + 1] = begins[k] + n
            at = 3 * begins[k]
            _rank(edges, x, stop, ranked, at)
            _rank(alphas, x, stop, ranked, at + n)
            _rank(betas, x, stop, ranked, at + 2 * n)
            for j in range(3 * n):
                low[box + j], high[box + j] = min(low[box + j], ranked[at + j]), max(high[box + j], ranked[at + j])
            at = 4 * begins[k]
            for j in range(n):
                corners[at + j], corners[at + n + j] = edges[x + j], alphas[x + j]
                corners[at + 2 * n + j], corners[at + 3 * n + j] = betas[x + j], pieces[x + j]
                spreads[k] += betas[x + j]
            spreads[k] = abs(spreads[k] - (n - 2) * np.pi)
            boxes[leaf + 1] = box + 3 * n
    used = boxes[count]
    ordered_areas = np.empty(trunks)
    for k in range(trunks):
        ordered_areas[k] = areas[order[k]]
    return TrunkSide(
        order,
        ordered_areas,
        spreads,
        begins,
        ranked,
        corners,
        leaves[: count + 1].copy(),
        boxes,
        low[:used].copy(),
        high[:used].copy(),
    )


@inner
def _rank(values: FloatArray, start: int, stop: int, out: FloatArray, base: int) -> None:
    """Copy ``values[start:stop]`` in ascending order to ``out``, from ``base`` on."""
    for k in range(stop - start):
        value, slot = values[start + k], base + k
        while slot > base and out[slot - 1] > value:
            out[slot] = out[slot - 1]
            slot -= 1
        out[slot] = value


@inner
def _widest(ranked: FloatArray, offsets: IntArray, order: IntArray, begin: int, end: int, n: int) -> int:
    """The rank at which the trunks ``order[begin:end]``, of n vertices, differ most."""
    greatest, widest_rank = -1.0, 0
    for rank in range(n):
        low, high = np.inf, -np.inf
        for k in range(begin, end):
            value = ranked[offsets[order[k]] + rank]
            low, high = min(low, value), max(high, value)
        if high - low > greatest:
            greatest, widest_rank = high - low, rank
    return widest_rank


@inner
def _select(keys: FloatArray, items: IntArray, low: int, high: int, middle: int) -> None:
    """Reorder from ``low`` to ``high``, both included, until no key before ``middle`` is greater than one behind."""
    while low < high:
        pivot = keys[(low + high) // 2]
        i, j = low, high
        while i <= j:
            while keys[i] < pivot:
                i += 1
            while keys[j] > pivot:
                j -= 1
            if i <= j:
                keys[i], keys[j] = keys[j], keys[i]
                items[i], items[j] = items[j], items[i]
                i += 1
                j -= 1
        if middle <= j:
            high = j
        elif middle >= i:
            low = i
        else:
            break


@kernel
def leaf_pairs(a: TrunkSide, b: TrunkSide, units: Units) -> tuple[FloatArray, IntArray]:
    """All pairs of leaves of one n: (k,) lower bounds of their trunks' distances, and (k, 2) their numbers."""
    # To take an array out of a tuple costs more than most of what is done with it below.
    low_a, high_a, boxes_a = a.low, a.high, a.boxes
    low_b, high_b, boxes_b = b.low, b.high, b.boxes
    capacity = 0
    for i in range(len(boxes_a) - 1):
        for j in range(len(boxes_b) - 1):
            capacity += 1 if boxes_a[i + 1] - boxes_a[i] == boxes_b[j + 1] - boxes_b[j] else 0
    bounds, pairs = np.empty(capacity), np.empty((capacity, 2), dtype=np.int64)
    count = 0
    for i in range(len(boxes_a) - 1):
        x, n = boxes_a[i], (boxes_a[i + 1] - boxes_a[i]) // 3
        edge_unit, angle_unit = 1.0 / (n * units.edge), 1.0 / (2.0 * n * units.angle)
        for j in range(len(boxes_b) - 1):
            y = boxes_b[j]
            if boxes_b[j + 1] - y != 3 * n:
                continue
            edge, angle = 0.0, 0.0
            for k in range(n):
                edge += max(max(low_a[x + k] - high_b[y + k], low_b[y + k] - high_a[x + k]), 0.0)
                # P's alphas face Q's betas and the other way round.
                p, q = x + n + k, y + 2 * n + k
                angle += max(max(low_a[p] - high_b[q], low_b[q] - high_a[p]), 0.0)
                p, q = x + 2 * n + k, y + n + k
                angle += max(max(low_a[p] - high_b[q], low_b[q] - high_a[p]), 0.0)
            bounds[count] = max(edge * edge_unit, angle * angle_unit)
            pairs[count, 0], pairs[count, 1] = i, j
            count += 1
    return bounds, pairs


@kernel
def nearest_candidates(
    a: TrunkSide,
    b: TrunkSide,
    units: Units,
    bounds: FloatArray,
    pairs: IntArray,
    above: float,
    limit: float,
    candidates: FloatArray,
    which: IntArray,
) -> tuple[int, float]:
    """List the (T, T', shift) of two shapes whose bound is greater than ``above`` and at most ``limit``.

    ``bounds`` and ``pairs`` are those of `leaf_pairs` in ascending order. Fills ``candidates`` (r, 2) with the bound
    and max(d_E/σ_E, d_∠/σ_∠), and ``which`` (r, 3). Returns the number of candidates and the limit: whenever the arrays
    are full, the limit is lowered and candidates of greater bound are dropped. The number is −1 if that cannot help,
    because all bounds are equal.
    """
    # To take an array out of a tuple costs more than most of what is done with it below.
    order_a, areas_a, spreads_a, begins_a, leaves_a = a.order, a.areas, a.spreads, a.begins, a.leaves
    order_b, areas_b, spreads_b, begins_b, leaves_b = b.order, b.areas, b.spreads, b.begins, b.leaves
    ranked_a, ranked_b, corners_a, corners_b = a.ranked, b.ranked, a.corners, b.corners
    boxes, low, high = b.boxes, b.low, b.high
    count, longest = int(np.int64(0)), 0  # a literal would have `_lower` compiled once more
    for j in range(len(leaves_b) - 1):
        longest = max(longest, boxes[j + 1] - boxes[j])
    edges, alphas, betas, pieces = np.empty(longest), np.empty(longest), np.empty(longest), np.empty(longest)
    for k in range(len(bounds)):
        if bounds[k] > limit + PRUNING_SLACK:
            break
        i, j = pairs[k, 0], pairs[k, 1]
        box, n = boxes[j], (boxes[j + 1] - boxes[j]) // 3
        edge_unit, angle_unit = 1.0 / (n * units.edge), 1.0 / (2.0 * n * units.angle)
        for p in range(leaves_a[i], leaves_a[i + 1]):
            x = 3 * begins_a[p]
            edge, angle = 0.0, 0.0
            for m in range(n):
                edge += max(max(ranked_a[x + m] - high[box + m], low[box + m] - ranked_a[x + m]), 0.0)
                alpha, beta = ranked_a[x + n + m], ranked_a[x + 2 * n + m]
                angle += max(max(alpha - high[box + 2 * n + m], low[box + 2 * n + m] - alpha), 0.0)
                angle += max(max(beta - high[box + n + m], low[box + n + m] - beta), 0.0)
            if max(edge * edge_unit, angle * angle_unit) > limit + PRUNING_SLACK:
                continue
            for q in range(leaves_b[j], leaves_b[j + 1]):
                x, y = 3 * begins_a[p], 3 * begins_b[q]
                edge, angle = 0.0, spreads_a[p] + spreads_b[q]
                for m in range(n):
                    edge += abs(ranked_a[x + m] - ranked_b[y + m])
                if max(edge * edge_unit, angle * angle_unit) > limit + PRUNING_SLACK:
                    continue
                angle, other = 0.0, 0.0
                for m in range(n):
                    angle += abs(ranked_a[x + n + m] - ranked_b[y + 2 * n + m])
                    other += abs(ranked_a[x + 2 * n + m] - ranked_b[y + n + m])
                if (angle + other) * angle_unit > limit + PRUNING_SLACK:
                    continue
                # T' listed backwards, twice: entry −s mod n + m faces corner m of T; pieces belong to edges.
                x, y = 4 * begins_a[p], 4 * begins_b[q]
                for m in range(n):
                    corner, behind = y + (n - m if m > 0 else 0), y + n - 1 - m
                    edges[m] = edges[n + m] = corners_b[behind]
                    alphas[m] = alphas[n + m] = corners_b[n + corner]
                    betas[m] = betas[n + m] = corners_b[2 * n + corner]
                    pieces[m] = pieces[n + m] = corners_b[3 * n + behind]
                t, u = order_a[p], order_b[q]
                for s in range(n):
                    z = n - s if s > 0 else 0
                    total = 0.0
                    for m in range(n):
                        total += abs(corners_a[x + m] - edges[z + m])
                    terms = total * edge_unit
                    if terms > limit:
                        continue
                    total = 0.0
                    for m in range(n):
                        alpha, beta = corners_a[x + n + m], corners_a[x + 2 * n + m]
                        total += abs(beta - alphas[z + m]) + abs(alpha - betas[z + m])
                    terms = max(terms, total * angle_unit)
                    if terms > limit:
                        continue
                    sum_a, sum_b = 0.0, 0.0
                    for m in range(n):
                        ratio = edges[z + m] / corners_a[x + m]
                        sum_a += corners_a[x + 3 * n + m] * ratio * ratio
                        sum_b += pieces[z + m] / (ratio * ratio)
                    deficit = max(abs(areas_b[q] - sum_a), abs(areas_a[p] - sum_b)) - units.slack
                    bound = max(terms, deficit / units.area)
                    if bound > limit or bound <= above:
                        continue
                    if count == candidates.shape[0]:
                        count, limit = _lower(candidates, which, count, limit)
                        if count < 0:
                            return -1, limit
                        if bound > limit:
                            continue
                    candidates[count, 0], candidates[count, 1] = bound, terms
                    which[count, 0], which[count, 1], which[count, 2] = t, u, s
                    count += 1
    return count, limit


@kernel
def _lower(candidates: FloatArray, which: IntArray, count: int, limit: float) -> tuple[int, float]:
    """Lower the limit to about the middle bound and drop what exceeds it; (−1, limit) if all bounds are equal."""
    bounds, items = np.empty(count), np.empty(count, dtype=np.int64)
    greatest, less = -np.inf, -np.inf
    for k in range(count):
        bounds[k] = candidates[k, 0]
        greatest = max(greatest, bounds[k])
    middle = (count - 1) // 2
    _select(bounds, items, middle - middle, count - 1, middle)
    lowered = greatest
    for k in range(count):
        lowered = min(lowered, bounds[k]) if k >= middle else lowered
        less = max(less, bounds[k]) if bounds[k] < greatest else less
    if lowered == greatest:  # half of the bounds are the greatest one
        if less == -np.inf:
            return -1, limit
        lowered = less
    kept = 0
    for k in range(count):
        if candidates[k, 0] <= lowered:
            candidates[kept, 0], candidates[kept, 1] = candidates[k, 0], candidates[k, 1]
            which[kept, 0], which[kept, 1], which[kept, 2] = which[k, 0], which[k, 1], which[k, 2]
            kept += 1
    return kept, lowered


def warm() -> None:
    """Compile on a triangle."""
    points, three = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), np.ones(3)
    offsets = np.array([0, 3], dtype=np.int64)
    pieces = piece_areas(points, np.zeros(4), offsets, np.arange(3))
    side = arrange(offsets, three, three, three, pieces, np.ones(1))
    units = Units(0.1, 0.5, 0.1, 0.0)
    buffers = np.empty((3, 2)), np.empty((3, 3), dtype=np.int64)
    nearest_candidates(side, side, units, *leaf_pairs(side, side, units), -1.0, 1.0, *buffers)
