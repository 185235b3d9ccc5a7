"""The least change that an exact construction on given conjugate trunks makes to a shape, and its gradient (theory §8).

Each arc of P is carried rigidly from its edge of T onto the same edge of T̄ and closed by it to a region with winding
number w_i. With W = Σ w_i an exact construction loses overlaps, ∫_{T̄} max(W − 1, 0), and what lies outside, ∫_{outside
T̄} Σ max(w_i, 0), and adds gaps, ∫_{T̄} max(1 − W, 0), and what the trunk has but P lacks, ∫_{outside T̄} Σ max(−w_i,
0). The areas are summed by scanlines. A crossing that moves changes them by the difference of the integrands on its two
sides, so that the same sweep gives the gradient.
"""

from __future__ import annotations

import numpy as np

from riot.kernels.options import inner, kernel
from riot.types import FloatArray, IntArray

SAME_POINT = 1e-9
"""Consecutive points of a placed arc that are nearer than this, in the unit-area frame, become one point. Ours."""

LOST, ADDED = 0, 1
"""Indices of the two areas in arrays."""


@kernel
def placed_arcs(
    points: FloatArray, windows: IntArray, source: FloatArray, target: FloatArray, out: FloatArray, offsets: IntArray
) -> int:
    """Carry the arcs of a polygon (m, 2) rigidly from the edges of one n-gon to those of its conjugate.

    ``source`` (n, 2) lies on the polygon or near it, corners in the polygon's direction; ``target`` (n, 2) has the same
    edge lengths. Where a corner of ``source`` is off the boundary the two arcs that meet there begin with a straight
    connector from the corner to its `feet`. Fills ``out`` (≥ m + 5 n, 2) and ``offsets`` (n + 1,): arc i runs from
    ``target[i]`` to ``target[i + 1]``, these exactly. Returns the number of points.
    """
    m, n = points.shape[0], len(source)
    on, edges = feet(points, windows, source)
    total = 0
    for i in range(n):
        offsets[i] = total
        after = i + 1 if i + 1 < n else 0
        px, py = source[i, 0], source[i, 1]
        ux, uy = source[after, 0] - px, source[after, 1] - py
        tx, ty = target[i, 0], target[i, 1]
        wx, wy = target[after, 0] - tx, target[after, 1] - ty
        # The rotation is multiplication by the complex number w / u, of modulus 1.
        scale = 1.0 / np.sqrt((ux * ux + uy * uy) * (wx * wx + wy * wy))
        real, imaginary = (wx * ux + wy * uy) * scale, (wy * ux - wx * uy) * scale
        out[total, 0], out[total, 1] = tx, ty
        total += 1
        # The foot, the polygon's vertices from the next one to the last before the other foot, and that foot.
        k, ahead = edges[i], (edges[after] - edges[i]) % m
        for step in range(ahead + 2):
            if step == 0:
                x, y = on[i, 0], on[i, 1]
            elif step == ahead + 1:
                x, y = on[after, 0], on[after, 1]
            else:
                k = k + 1 if k + 1 < m else 0
                x, y = points[k, 0], points[k, 1]
            x, y = x - px, y - py
            x, y = tx + real * x - imaginary * y, ty + real * y + imaginary * x
            if abs(x - out[total - 1, 0]) + abs(y - out[total - 1, 1]) > SAME_POINT:
                out[total, 0], out[total, 1] = x, y
                total += 1
        x, y = target[after, 0], target[after, 1]
        if total - 1 > offsets[i] and abs(x - out[total - 1, 0]) + abs(y - out[total - 1, 1]) <= SAME_POINT:
            total -= 1
        out[total, 0], out[total, 1] = x, y
        total += 1
    offsets[n] = total
    return total


@kernel
def feet(points: FloatArray, windows: IntArray, corners: FloatArray) -> tuple[FloatArray, IntArray]:
    """The point (n, 2) of a polygon's boundary nearest to each corner (n, 2), and the edge (n,) that it is on.

    Only the boundary from vertex ``windows[i, 0]`` forwards to vertex ``windows[i, 1]`` counts for corner i.
    """
    m, n = len(points), len(corners)
    on, edges = np.empty((n, 2)), np.empty(n, dtype=np.int64)
    for i in range(n):
        x, y = corners[i, 0], corners[i, 1]
        k, best = windows[i, 0], np.inf
        edges[i], on[i, 0], on[i, 1] = k, points[k, 0], points[k, 1]
        while k != windows[i, 1]:
            after = k + 1 if k + 1 < m else 0
            ax, ay = points[k, 0], points[k, 1]
            ex, ey = points[after, 0] - ax, points[after, 1] - ay
            square = ex * ex + ey * ey
            u = ((x - ax) * ex + (y - ay) * ey) / square if square > 0.0 else 0.0
            u = min(1.0, max(0.0, u))
            qx, qy = ax + u * ex, ay + u * ey
            far = (x - qx) * (x - qx) + (y - qy) * (y - qy)
            if far < best:
                best, edges[i], on[i, 0], on[i, 1] = far, k, qx, qy
            k = after
    return on, edges


@kernel
def least_changes(
    points_p: FloatArray, windows_p: IntArray, points_q: FloatArray, windows_q: IntArray, trunks: FloatArray, lines: int
) -> tuple[FloatArray, FloatArray]:
    """The highest IoU with P and with Q, (2,), that an exact construction on conjugate trunks can have (theory §8).

    And its gradient by the trunks' corners, (2, 2, n, 2). ``trunks`` (2, n, 2): T in P's frame, counter-clockwise, and
    T̄ in Q's, in corresponding order. ``windows_p`` (n, 2) in T's order, ``windows_q`` (n, 2) in that of T̄ read
    backwards, as `feet` reads them: arcs are divided at the boundary points nearest to the corners.
    """
    n = trunks.shape[1]
    capacity = max(len(points_p), len(points_q)) + 5 * n
    arcs, offsets = np.empty((capacity, 2)), np.empty(n + 1, dtype=np.int64)
    source, target = np.empty((n, 2)), np.empty((n, 2))
    ious, gradient = np.empty(2), np.empty((2, 2, n, 2))
    for side in range(2):
        for j in range(n):
            at = j if side == 0 else n - 1 - j
            for axis in range(2):
                source[j, axis], target[j, axis] = trunks[side, at, axis], trunks[1 - side, at, axis]
        points, windows = (points_p, windows_p) if side == 0 else (points_q, windows_q)
        placed_arcs(points, windows, source, target, arcs, offsets)
        areas, by_source, by_target, step = _areas(source, target, arcs, offsets, lines)
        area = 0.0
        m = len(points)
        for k in range(m):
            after = k + 1 if k + 1 < m else 0
            area += 0.5 * (points[k, 0] * points[after, 1] - points[after, 0] * points[k, 1])
        whole = area + areas[ADDED] * step
        iou = (area - areas[LOST] * step) / whole
        ious[side] = iou
        for j in range(n):
            at = j if side == 0 else n - 1 - j
            for axis in range(2):
                change = by_source[LOST, j, axis] * step + iou * (by_source[ADDED, j, axis] * step)
                gradient[side, side, at, axis] = -change / whole
                change = by_target[LOST, j, axis] * step + iou * (by_target[ADDED, j, axis] * step)
                gradient[side, 1 - side, at, axis] = -change / whole
    return ious, gradient


@kernel
def _areas(
    source: FloatArray, target: FloatArray, arcs: FloatArray, offsets: IntArray, lines: int
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Areas lost and added, (2,), and their gradients by the corners of ``source`` and of ``target``, (2, n, 2).

    All in units of the distance of two scanlines, which is returned last.
    """
    n = len(target)
    starts, x, edge, most, low, step = _crossings(arcs, offsets, n, lines)
    owner = np.empty(offsets[n], dtype=np.int64)
    for i in range(n):
        for k in range(offsets[i], offsets[i + 1]):
            owner[k] = i
    areas = np.zeros(2)
    push = np.zeros((2, n, 3))  # by a move of arc i along x, along y, and by its turn about target[i]
    by_source, by_target = np.zeros((2, n, 2)), np.zeros((2, n, 2))
    winding = np.empty(n, dtype=np.int64)
    row, order = np.empty(most), np.empty(most, dtype=np.int64)
    before = 0
    for line in range(lines):
        start, m = starts[line], starts[line + 1] - starts[line]
        y = low + (line + 0.5) * step
        # Insertion sort from the order on the line before, which is nearly that on this line.
        if m != before:
            for k in range(m):
                order[k] = k
            before = m
        for k in range(m):
            which = order[k]
            at = x[start + which]
            slot = k
            while slot > 0 and row[slot - 1] > at:
                row[slot], order[slot] = row[slot - 1], order[slot - 1]
                slot -= 1
            row[slot], order[slot] = at, which
        inside, whole, apart, lacking = False, 0, 0, 0
        lost, added = 0, 0
        for i in range(n):
            winding[i] = 0
        for k in range(m):
            if k > 0:
                areas[LOST] += lost * (row[k] - row[k - 1])
                areas[ADDED] += added * (row[k] - row[k - 1])
            e = edge[start + order[k]]
            i = owner[e]
            chord = e + 1 == offsets[i + 1]
            after = offsets[i] if chord else e + 1
            # Crossing an upward edge from left to right leaves its left side: the winding number falls.
            turn = -1 if arcs[after, 1] > arcs[e, 1] else 1
            apart += max(winding[i] + turn, 0) - max(winding[i], 0)
            lacking += max(-winding[i] - turn, 0) - max(-winding[i], 0)
            winding[i] += turn
            whole += turn
            if chord:
                inside = not inside
            here, there = lost, added
            lost = max(whole - 1, 0) if inside else apart
            added = max(1 - whole, 0) if inside else lacking
            here, there = here - lost, there - added
            if here == 0 and there == 0:
                continue
            slope = (arcs[after, 0] - arcs[e, 0]) / (arcs[after, 1] - arcs[e, 1])
            if chord:
                share = (y - arcs[e, 1]) / (arcs[after, 1] - arcs[e, 1])  # from target[i + 1] back to target[i]
                j = i + 1 if i + 1 < n else 0
                for kind in range(2):
                    pull = here if kind == LOST else there
                    by_target[kind, i, 0] += share * pull
                    by_target[kind, i, 1] -= share * pull * slope
                    by_target[kind, j, 0] += (1.0 - share) * pull
                    by_target[kind, j, 1] -= (1.0 - share) * pull * slope
            else:
                arm = -(y - target[i, 1]) - slope * (row[k] - target[i, 0])
                for kind in range(2):
                    pull = here if kind == LOST else there
                    push[kind, i, 0] += pull
                    push[kind, i, 1] -= pull * slope
                    push[kind, i, 2] += pull * arm
    for kind in range(2):
        for i in range(n):
            _spread(source, target, push, kind, i, by_source, by_target)
    return areas, by_source, by_target, step


@inner
def _spread(
    source: FloatArray,
    target: FloatArray,
    push: FloatArray,
    kind: int,
    i: int,
    by_source: FloatArray,
    by_target: FloatArray,
) -> None:
    """Turn the derivatives by shift and turn of arc i into derivatives by the four corners that place the arc.

    A point X goes to target[i] + R(φ) (X − source[i]), and φ is the angle between the two edges.
    """
    j = i + 1 if i + 1 < len(source) else 0
    ux, uy = source[j, 0] - source[i, 0], source[j, 1] - source[i, 1]
    wx, wy = target[j, 0] - target[i, 0], target[j, 1] - target[i, 1]
    square_u, square_w = ux * ux + uy * uy, wx * wx + wy * wy
    scale = 1.0 / np.sqrt(square_u * square_w)
    real, imaginary = (wx * ux + wy * uy) * scale, (wy * ux - wx * uy) * scale
    x, y, turn = push[kind, i, 0], push[kind, i, 1], push[kind, i, 2]
    by_target[kind, i, 0] += x + turn * wy / square_w
    by_target[kind, i, 1] += y - turn * wx / square_w
    by_target[kind, j, 0] -= turn * wy / square_w
    by_target[kind, j, 1] += turn * wx / square_w
    by_source[kind, i, 0] -= real * x + imaginary * y + turn * uy / square_u
    by_source[kind, i, 1] -= real * y - imaginary * x - turn * ux / square_u
    by_source[kind, j, 0] += turn * uy / square_u
    by_source[kind, j, 1] -= turn * ux / square_u


@kernel
def _crossings(
    arcs: FloatArray, offsets: IntArray, n: int, lines: int
) -> tuple[IntArray, FloatArray, IntArray, int, float, float]:
    """Find where the regions' edges cross scanlines.

    Returns for each line the index of its first crossing, the x and the edge of all crossings, the greatest number of
    crossings on a line, y₀ and step.

    Line k lies at y₀ + (k + ½) step; edge e goes from point e to the next, the last of an arc back to its first. An
    edge crosses lines from its lower end (included) to its upper (excluded).
    """
    total = offsets[n]
    low, high = np.inf, -np.inf
    for k in range(total):
        low, high = min(low, arcs[k, 1]), max(high, arcs[k, 1])
    step = (high - low) / lines
    above = np.empty(total, dtype=np.int64)
    for k in range(total):
        above[k] = min(max(int(np.ceil((arcs[k, 1] - low) / step - 0.5)), 0), lines)
    starts = np.zeros(lines + 2, dtype=np.int64)
    for i in range(n):
        for k in range(offsets[i], offsets[i + 1]):
            after = k + 1 if k + 1 < offsets[i + 1] else offsets[i]
            starts[min(above[k], above[after]) + 1] += 1
            starts[max(above[k], above[after]) + 1] -= 1
    # The number of edges that begin less those that end at a line gives the number that cross it, and these sum to
    # the index of the first crossing of each line.
    most, crossing = 0, 0
    for line in range(lines):
        crossing += starts[line + 1]
        most = max(most, crossing)
        starts[line + 1] = starts[line] + crossing
    x, edge = np.empty(starts[lines]), np.empty(starts[lines], dtype=np.int64)
    cursor = starts.copy()
    for i in range(n):
        for k in range(offsets[i], offsets[i + 1]):
            after = k + 1 if k + 1 < offsets[i + 1] else offsets[i]
            first, last = min(above[k], above[after]), max(above[k], above[after])
            if first == last:
                continue
            x0, y0 = arcs[k, 0], arcs[k, 1]
            slope = (arcs[after, 0] - x0) / (arcs[after, 1] - y0)
            for line in range(first, last):
                slot = cursor[line]
                cursor[line] = slot + 1
                x[slot], edge[slot] = x0 + slope * (low + (line + 0.5) * step - y0), k
    return starts, x, edge, most, low, step


def warm() -> None:
    """Compile on two squares."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    windows = np.array([[3, 1], [0, 2], [1, 3], [2, 0]], dtype=np.int64)
    least_changes(square, windows, square, windows, np.stack((square, square[::-1])), 8)
    feet(square, windows, square)
    placed_arcs(square, windows, square, square, np.empty((24, 2)), np.empty(5, dtype=np.int64))
