"""What an exact construction loses and adds in one trunk, and how points of swung arcs pull at it (theory §12; ours).

The areas are those of `riot.kernels.change`, by scanlines. There an arc moves as a whole; here every point moves by
itself: a crossing that moves changes the areas by the difference of the integrands on its two sides, and it moves with
the two end points of its edge. The scanlines themselves stand still.
"""

from __future__ import annotations

import numpy as np

from riot.kernels.options import kernel
from riot.types import FloatArray, IntArray

LOST, ADDED = 0, 1
"""Indices of the two areas in arrays."""


@kernel
def pulls(arcs: FloatArray, offsets: IntArray, low: float, step: float, lines: int) -> tuple[FloatArray, FloatArray]:
    """Areas lost and added, (2,), and their gradients by the points of the arcs, (2, s, 2).

    ``arcs`` (s, 2) with ``offsets`` (n + 1,) run round a convex trunk, arc i from its corner i to corner i + 1, so that
    their end points are the trunk. Scanline k lies at ``low`` + (k + ½) ``step``.
    """
    n, total = len(offsets) - 1, offsets[-1]
    following = np.arange(1, total + 1)
    owner = np.empty(total, dtype=np.int64)
    for i in range(n):
        following[offsets[i + 1] - 1] = offsets[i]
        owner[offsets[i] : offsets[i + 1]] = i
    # An edge crosses lines from its lower end (included) to its upper (excluded). The number of edges that begin less
    # those that end at a line gives the number that cross it; these sum to the index of the first crossing of a line.
    above = np.empty(total, dtype=np.int64)
    for k in range(total):
        above[k] = min(max(int(np.ceil((arcs[k, 1] - low) / step - 0.5)), 0), lines)
    starts = np.zeros(lines + 2, dtype=np.int64)
    for k in range(total):
        starts[min(above[k], above[following[k]]) + 1] += 1
        starts[max(above[k], above[following[k]]) + 1] -= 1
    most, crossing = 0, 0
    for line in range(lines):
        crossing += starts[line + 1]
        most = max(most, crossing)
        starts[line + 1] = starts[line] + crossing
    x, edge = np.empty(starts[lines]), np.empty(starts[lines], dtype=np.int64)
    cursor = starts[:lines].copy()
    for k in range(total):
        after = following[k]
        first, last = min(above[k], above[after]), max(above[k], above[after])
        if first == last:
            continue
        slope = (arcs[after, 0] - arcs[k, 0]) / (arcs[after, 1] - arcs[k, 1])
        for line in range(first, last):
            slot = cursor[line]
            cursor[line] = slot + 1
            x[slot], edge[slot] = arcs[k, 0] + slope * (low + (line + 0.5) * step - arcs[k, 1]), k
    areas, gradient = np.zeros(2), np.zeros((2, total, 2))
    winding = np.zeros(n, dtype=np.int64)
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
        inside, whole, apart, lacking, lost, added = False, 0, 0, 0, 0, 0
        winding[:] = 0
        for k in range(m):
            if k > 0:
                areas[LOST] += lost * (row[k] - row[k - 1])
                areas[ADDED] += added * (row[k] - row[k - 1])
            e = edge[start + order[k]]
            i, after = owner[e], following[e]
            # Crossing an upward edge from left to right leaves its left side: the winding number falls.
            turn = -1 if arcs[after, 1] > arcs[e, 1] else 1
            apart += max(winding[i] + turn, 0) - max(winding[i], 0)
            lacking += max(-winding[i] - turn, 0) - max(-winding[i], 0)
            winding[i] += turn
            whole += turn
            if after < e:  # the trunk's edge, back from the arc's last point to its first
                inside = not inside
            here, there = lost, added
            lost = max(whole - 1, 0) if inside else apart
            added = max(1 - whole, 0) if inside else lacking
            here, there = here - lost, there - added
            if here == 0 and there == 0:
                continue
            height = arcs[after, 1] - arcs[e, 1]
            slope, share = (arcs[after, 0] - arcs[e, 0]) / height, (y - arcs[e, 1]) / height
            for kind in range(2):
                pull = float(here if kind == LOST else there)
                gradient[kind, e, 0] += (1.0 - share) * pull
                gradient[kind, e, 1] -= (1.0 - share) * pull * slope
                gradient[kind, after, 0] += share * pull
                gradient[kind, after, 1] -= share * pull * slope
    return areas * step, gradient * step


@kernel
def nearest_arcs(
    points: FloatArray, own: IntArray, arcs: FloatArray, offsets: IntArray
) -> tuple[FloatArray, IntArray, FloatArray]:
    """Signed distances (k, 2) of points (k, 2) to their ``own`` arcs (k,) and to the nearest other, negative in the
    region between an arc and its chord; infinite for the other where none is nearer than the own one.

    And where the nearest point of both arcs is: on which edge (k, 2), by its first point, at what share of it (k, 2).
    """
    n, count = len(offsets) - 1, len(points)
    distances = np.full((count, 2), np.inf)
    edges, shares = np.zeros((count, 2), np.int64), np.zeros((count, 2))
    boxes = np.empty((n, 4))
    for i in range(n):
        boxes[i, 0] = boxes[i, 1] = np.inf
        boxes[i, 2] = boxes[i, 3] = -np.inf
        for k in range(offsets[i], offsets[i + 1]):
            boxes[i, 0], boxes[i, 1] = min(boxes[i, 0], arcs[k, 0]), min(boxes[i, 1], arcs[k, 1])
            boxes[i, 2], boxes[i, 3] = max(boxes[i, 2], arcs[k, 0]), max(boxes[i, 3], arcs[k, 1])
    for p in range(count):
        x, y = points[p, 0], points[p, 1]
        for turn in range(n):
            i = (own[p] + turn) % n
            column = min(turn, 1)
            if turn > 0:
                across = max(boxes[i, 0] - x, x - boxes[i, 2], 0.0)
                up = max(boxes[i, 1] - y, y - boxes[i, 3], 0.0)
                apart = np.sqrt(across * across + up * up)
                if apart > 0.0 and apart >= distances[p, 0]:
                    continue  # outside its box an arc is no nearer than the box
            last = offsets[i + 1] - 1
            ax, ay = arcs[last, 0] - x, arcs[last, 1] - y
            inside, least, edge, share = False, np.inf, 0, 0.0
            for k in range(offsets[i] - 1, last):
                bx, by = arcs[k + 1, 0] - x, arcs[k + 1, 1] - y
                ex, ey = bx - ax, by - ay
                if (ay > 0.0) != (by > 0.0) and ax - ay / ey * ex > 0.0:
                    inside = not inside
                if k >= offsets[i]:  # before is the chord, which only tells inside from outside
                    square = ex * ex + ey * ey
                    u = 0.0 if square == 0.0 else min(1.0, max(0.0, -(ax * ex + ay * ey) / square))
                    far = (ax + u * ex) ** 2 + (ay + u * ey) ** 2
                    if far < least:
                        least, edge, share = far, k, u
                ax, ay = bx, by
            distance = -np.sqrt(least) if inside else np.sqrt(least)
            if turn == 0 or (distance < distances[p, 0] and distance < distances[p, 1]):
                distances[p, column], edges[p, column], shares[p, column] = distance, edge, share
    return distances, edges, shares


def warm() -> None:
    """Compile on a square and arcs that are its edges."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    arcs = np.stack([square, np.roll(square, -1, axis=0)], axis=1).reshape(8, 2)
    pulls(arcs, np.arange(0, 9, 2), 0.0, 0.125, 8)
    nearest_arcs(square, np.arange(4), arcs, np.arange(0, 9, 2))
