"""Distances between rigid bodies of a hinged chain, and proofs that a motion is free of collision (theory §9). Ours.

A body is a set of simple rings without holes, in the frame of its piece: ``points`` (p, 2) of all rings of all bodies,
ring r being ``points[rings[r]:rings[r + 1]]``, body k the rings ``bodies[k]`` to ``bodies[k + 1]``.
"""

from __future__ import annotations

import numpy as np

from riot.kernels.options import inner, kernel
from riot.types import FloatArray, IntArray

PROBED_SHARES = (0.5, 0.25, 0.75, 0.125, 0.875, 0.375, 0.625)
"""Shares of a motion that are tried before the proof. Ours: most motions that are not free collide at one of them."""

_SHORT_OF_END = 1e-9
"""If only the end of a motion is not free, the motion is free up to this share before its end. Ours."""


@inner
def _point_gap(px: float, py: float, ax: float, ay: float, bx: float, by: float) -> float:
    """Squared distance of a point from a segment."""
    ex, ey = bx - ax, by - ay
    squared = ex * ex + ey * ey
    t = 0.0
    if squared > 0.0:
        t = min(1.0, max(0.0, ((px - ax) * ex + (py - ay) * ey) / squared))
    dx, dy = px - ax - t * ex, py - ay - t * ey
    return float(dx * dx + dy * dy)


@inner
def _segment_gap(a: FloatArray, b: FloatArray) -> float:
    """Squared distance of two segments (x0, y0, x1, y1); 0 if they cross."""
    ux, uy, vx, vy = a[2] - a[0], a[3] - a[1], b[2] - b[0], b[3] - b[1]
    b0 = ux * (b[1] - a[1]) - uy * (b[0] - a[0])
    b1 = ux * (b[3] - a[1]) - uy * (b[2] - a[0])
    a0 = vx * (a[1] - b[1]) - vy * (a[0] - b[0])
    a1 = vx * (a[3] - b[1]) - vy * (a[2] - b[0])
    if (b0 > 0.0) != (b1 > 0.0) and (a0 > 0.0) != (a1 > 0.0):
        return 0.0
    return min(
        min(_point_gap(a[0], a[1], b[0], b[1], b[2], b[3]), _point_gap(a[2], a[3], b[0], b[1], b[2], b[3])),
        min(_point_gap(b[0], b[1], a[0], a[1], a[2], a[3]), _point_gap(b[2], b[3], a[0], a[1], a[2], a[3])),
    )


@inner
def _inside(points: FloatArray, rings: IntArray, x: float, y: float) -> bool:
    """Whether (x, y) lies in a body (even–odd)."""
    inside = False
    for ring in range(len(rings) - 1):
        before = rings[ring + 1] - 1
        for i in range(rings[ring], rings[ring + 1]):
            ay, by = points[before, 1], points[i, 1]
            if (ay > y) != (by > y):
                ax, bx = points[before, 0], points[i, 0]
                if x < ax + (y - ay) * (bx - ax) / (by - ay):
                    inside = not inside
            before = i
    return inside


@inner
def _near(points: FloatArray, rings: IntArray, box: FloatArray, reach: float, out: FloatArray) -> int:
    """Fill ``out`` with a body's edges whose boxes are within ``reach`` of ``box``."""
    count = 0
    left, low, right, high = box[0] - reach, box[1] - reach, box[2] + reach, box[3] + reach
    for ring in range(len(rings) - 1):
        before = rings[ring + 1] - 1
        for i in range(rings[ring], rings[ring + 1]):
            ax, ay, bx, by = points[before, 0], points[before, 1], points[i, 0], points[i, 1]
            if max(ax, bx) > left and min(ax, bx) < right and max(ay, by) > low and min(ay, by) < high:
                out[count, 0], out[count, 1], out[count, 2], out[count, 3] = ax, ay, bx, by
                count += 1
            before = i
    return count


@inner
def _box(points: FloatArray, rings: IntArray, box: FloatArray) -> None:
    """Set ``box`` to the least x and y and the greatest x and y of a body."""
    left, low, right, high = np.inf, np.inf, -np.inf, -np.inf
    for i in range(rings[0], rings[-1]):
        left, right = min(left, points[i, 0]), max(right, points[i, 0])
        low, high = min(low, points[i, 1]), max(high, points[i, 1])
    box[0], box[1], box[2], box[3] = left, low, right, high


@inner
def _box_gap(a: FloatArray, b: FloatArray) -> float:
    """Squared distance of two boxes."""
    dx = max(0.0, max(a[0] - b[2], b[0] - a[2]))
    dy = max(0.0, max(a[1] - b[3], b[1] - a[3]))
    return float(dx * dx + dy * dy)


@kernel
def separation(
    points: FloatArray,
    rings: IntArray,
    bodies: IntArray,
    a: int,
    b: int,
    placement: FloatArray,
    cap: float,
) -> float:
    """Distance of body b from body a, 0 if they overlap or touch; at least ``cap`` if they are farther apart.

    ``placement`` (3,) is where b's frame lies in a's: x, y, heading in radians. A body inside the other overlaps it. An
    empty body is infinitely far.
    """
    rings_a, rings_b = rings[bodies[a] : bodies[a + 1] + 1], rings[bodies[b] : bodies[b + 1] + 1]
    if len(rings_a) == 1 or len(rings_b) == 1:
        return np.inf
    c, s = np.cos(placement[2]), np.sin(placement[2])
    start = rings_b[0]
    placed = np.empty((rings_b[-1] - start, 2))
    for i in range(len(placed)):
        px, py = points[start + i, 0], points[start + i, 1]
        placed[i, 0], placed[i, 1] = c * px - s * py + placement[0], s * px + c * py + placement[1]
    offsets = np.empty(len(rings_b), dtype=np.int64)
    for ring in range(len(rings_b)):
        offsets[ring] = rings_b[ring] - start
    box_a, box_b = np.empty(4), np.empty(4)
    _box(points, rings_a, box_a)
    _box(placed, offsets, box_b)
    apart = _box_gap(box_a, box_b)
    if apart >= cap * cap:
        return float(np.sqrt(apart))

    near_a, near_b = np.empty((rings_a[-1] - rings_a[0], 4)), np.empty((len(placed), 4))
    count_a = _near(points, rings_a, box_b, cap, near_a)
    count_b = _near(placed, offsets, box_a, cap, near_b)
    best = cap * cap
    for i in range(count_a):
        edge_a = near_a[i]
        left, right = min(edge_a[0], edge_a[2]), max(edge_a[0], edge_a[2])
        low, high = min(edge_a[1], edge_a[3]), max(edge_a[1], edge_a[3])
        for k in range(count_b):
            edge_b = near_b[k]
            dx = max(0.0, max(left - max(edge_b[0], edge_b[2]), min(edge_b[0], edge_b[2]) - right))
            dy = max(0.0, max(low - max(edge_b[1], edge_b[3]), min(edge_b[1], edge_b[3]) - high))
            if dx * dx + dy * dy < best:
                best = min(best, _segment_gap(edge_a, edge_b))
        if best == 0.0:
            return 0.0
    if apart == 0.0:
        for ring in range(len(offsets) - 1):
            if _inside(points, rings_a, placed[offsets[ring], 0], placed[offsets[ring], 1]):
                return 0.0
        for ring in range(len(rings_a) - 1):
            if _inside(placed, offsets, points[rings_a[ring], 0], points[rings_a[ring], 1]):
                return 0.0
    return float(np.sqrt(best))


@kernel
def clear_share(
    points: FloatArray,
    rings: IntArray,
    bodies: IntArray,
    lengths: FloatArray,
    reaches: FloatArray,
    before: FloatArray,
    after: FloatArray,
    floor: float,
    cap: float,
    whole: bool,
) -> tuple[float, int]:
    """How far a chain can turn from one pose towards another without a collision, all hinges evenly.

    Returns the share of the motion that is free, in [0, 1], and how many poses of pairs of pieces were checked.

    The chain has m pieces of ``lengths`` (m,), hinged end to start; ``before`` and ``after`` (m − 1,) are its turns,
    radians. Piece k has three bodies: 3k as it is, 3k + 1 relieved at its start and 3k + 2 at its end; of two pieces
    that share a hinge the relieved ones count. ``reaches`` (m, 2) is the greatest distance of a body's point from the
    piece's start and end.

    Conservative advancement: two bodies at distance d cannot meet before one has moved by d against the other, and they
    approach each other at a speed of at most Σ |turn| · (distance from that hinge to the farthest point of the body
    beyond it). So the motion is proven free, not sampled. It ends where two bodies are nearer than ``floor``; distances
    beyond ``cap`` are not computed exactly. If ``whole``, only a share of 1 matters, and `PROBED_SHARES` are tried
    first.
    """
    m = len(lengths)
    pairs = m * (m - 1) // 2
    first, second = np.empty(pairs, dtype=np.int64), np.empty(pairs, dtype=np.int64)
    rate, until = np.zeros(pairs), np.zeros(pairs)
    p = 0
    for k in range(m):
        for j in range(k + 1, m):
            first[p], second[p] = k, j
            from_k = reaches[k, 1]
            for h in range(k + 1, j + 1):  # hinge h joins piece h − 1 to piece h
                from_j = reaches[j, 0]
                for q in range(h, j):
                    from_j += lengths[q]
                rate[p] += abs(after[h - 1] - before[h - 1]) * min(from_j, from_k)
                from_k += lengths[h]
            p += 1
    checks = 0
    placement = np.empty(3)
    if whole:
        for probe in PROBED_SHARES:
            for p in range(pairs):
                _locate(lengths, before, after, probe, first[p], second[p], placement)
                checks += 1
                if _pair_gap(points, rings, bodies, first[p], second[p], placement, floor) < floor:
                    return 0.0, checks
    while True:
        p = 0
        for q in range(1, pairs):
            if until[q] < until[p]:
                p = q
        share = until[p]
        if share >= 1.0:
            # The end is checked too: the proof covers the motion up to its end, but not the end itself.
            for q in range(pairs):
                _locate(lengths, before, after, 1.0, first[q], second[q], placement)
                checks += 1
                if _pair_gap(points, rings, bodies, first[q], second[q], placement, floor) < floor:
                    return 1.0 - _SHORT_OF_END, checks
            return 1.0, checks
        _locate(lengths, before, after, share, first[p], second[p], placement)
        gap = _pair_gap(points, rings, bodies, first[p], second[p], placement, cap)
        checks += 1
        if gap < floor:
            return share, checks
        until[p] = 2.0 if rate[p] == 0.0 else share + gap / rate[p]


@inner
def _locate(
    lengths: FloatArray, before: FloatArray, after: FloatArray, share: float, k: int, j: int, placement: FloatArray
) -> None:
    """Where piece j's frame lies in piece k's, k < j, when all hinges have turned by ``share``."""
    x, y, heading = lengths[k], 0.0, 0.0
    for h in range(k + 1, j + 1):
        heading += before[h - 1] + share * (after[h - 1] - before[h - 1])
        if h < j:
            x += lengths[h] * np.cos(heading)
            y += lengths[h] * np.sin(heading)
    placement[0], placement[1], placement[2] = x, y, heading


@kernel
def _pair_gap(
    points: FloatArray, rings: IntArray, bodies: IntArray, k: int, j: int, placement: FloatArray, cap: float
) -> float:
    """Distance of two pieces of a chain, relieved if they share a hinge."""
    hinged = j == k + 1
    return float(
        separation(points, rings, bodies, 3 * k + (2 if hinged else 0), 3 * j + (1 if hinged else 0), placement, cap)
    )


def warm() -> None:
    """Compile on two triangles."""
    points = np.tile(np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]]), (6, 1))
    rings, bodies = np.arange(0, 21, 3), np.arange(7)
    separation(points, rings, bodies, 0, 1, np.array([3.0, 0.0, 0.0]), 1.0)
    turns = np.zeros(1)
    clear_share(points, rings, bodies, np.ones(2), np.ones((2, 2)), turns, turns, 1e-3, 0.1, False)
