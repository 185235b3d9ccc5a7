"""Labelling a trunk's mesh with its nearest exterior pieces, by signed distance (theory §8; methods ours).

The signed distance of a point to arc i is negative inside the region between the arc and its chord, which is the trunk
edge. Inside the trunk it changes at most as fast as the point moves: its sign changes only on the arc, where it is 0,
or on the chord, which is the trunk's border. So the distances from the middle of a block of mesh points tell which
pieces can be nearest anywhere in the block, and most blocks are labelled at once. A distance has the same bits wherever
it is computed: boxes around runs of segments only leave out segments that cannot contain the nearest point.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riot.kernels.options import inlined, inner, kernel
from riot.types import BoolArray, FloatArray, IntArray

BOUND_SLACK = 1e-12
"""Every bound on a distance is loosened by this, in the unit-area frame. Ours: a thousand times the rounding there."""

BOX_SEGMENTS = 4
"""Number of segments of an arc that share a box. Ours: any number gives the same labels, this one a quick search."""


class Arcs(NamedTuple):
    """The arcs of n exterior pieces in a trunk, in the order of its edges.

    ``points`` (s, 2) are the concatenated polylines, ``offsets`` (n + 1,) where each starts; ``boxes`` (b, 4) are the
    least x, least y, greatest x and greatest y of `BOX_SEGMENTS` segments each, loosened by `BOUND_SLACK`; ``runs`` (n
    + 1,) is where each arc's boxes start.
    """

    points: FloatArray
    offsets: IntArray
    boxes: FloatArray
    runs: IntArray


@kernel
def boxed(points: FloatArray, offsets: IntArray, first: int) -> Arcs:
    """Arcs, (s, 2) with (n + 1,) offsets, listed from arc ``first`` on, with their boxes."""
    n = len(offsets) - 1
    out = np.empty((len(points), 2))
    starts, runs = np.zeros(n + 1, dtype=np.int64), np.zeros(n + 1, dtype=np.int64)
    for i in range(n):
        k = (first + i) % n
        size = offsets[k + 1] - offsets[k]
        starts[i + 1] = starts[i] + size
        runs[i + 1] = runs[i] + (size - 1 + BOX_SEGMENTS - 1) // BOX_SEGMENTS
        for s in range(size):
            out[starts[i] + s, 0], out[starts[i] + s, 1] = points[offsets[k] + s, 0], points[offsets[k] + s, 1]
    boxes = np.empty((runs[n], 4))
    for i in range(n):
        last = starts[i + 1] - 1
        for b in range(runs[i], runs[i + 1]):
            start = starts[i] + (b - runs[i]) * BOX_SEGMENTS
            stop = min(start + BOX_SEGMENTS, last)
            left, low, right, high = np.inf, np.inf, -np.inf, -np.inf
            for s in range(start, stop + 1):
                left, right = min(left, out[s, 0] - BOUND_SLACK), max(right, out[s, 0] + BOUND_SLACK)
                low, high = min(low, out[s, 1] - BOUND_SLACK), max(high, out[s, 1] + BOUND_SLACK)
            boxes[b, 0], boxes[b, 1], boxes[b, 2], boxes[b, 3] = left, low, right, high
    return Arcs(out, starts, boxes, runs)


@inner
def _nearest(px: float, py: float, arcs: Arcs, i: int, within: float) -> float:
    """Distance of a point to arc i, which is known to be at most ``within``."""
    points, boxes = arcs.points, arcs.boxes
    last = arcs.offsets[i + 1] - 1
    nearest, least = np.inf, within * within
    for b in range(arcs.runs[i], arcs.runs[i + 1]):
        apart_x = max(boxes[b, 0] - px, px - boxes[b, 2], 0.0)
        apart_y = max(boxes[b, 1] - py, py - boxes[b, 3], 0.0)
        if apart_x * apart_x + apart_y * apart_y > least:
            continue
        start = arcs.offsets[i] + (b - arcs.runs[i]) * BOX_SEGMENTS
        ax, ay = points[start, 0] - px, points[start, 1] - py
        for s in range(start + 1, min(start + BOX_SEGMENTS, last) + 1):
            bx, by = points[s, 0] - px, points[s, 1] - py
            ex, ey = bx - ax, by - ay
            square = ex * ex + ey * ey
            u = 0.0 if square == 0.0 else -(ax * ex + ay * ey) / square
            u = min(1.0, max(0.0, u))
            dx, dy = ax + u * ex, ay + u * ey
            nearest = min(nearest, dx * dx + dy * dy)
            ax, ay = bx, by
        least = min(least, nearest)
    return float(np.sqrt(nearest))


@inner
def _is_inside(px: float, py: float, arcs: Arcs, i: int) -> bool:
    """Whether a point lies in the region between arc i and its chord, by parity of the crossings to its right."""
    points, boxes = arcs.points, arcs.boxes
    first, last = arcs.offsets[i], arcs.offsets[i + 1] - 1
    ax, ay = points[last, 0] - px, points[last, 1] - py
    bx, by = points[first, 0] - px, points[first, 1] - py
    inside: bool = (ay > 0.0) != (by > 0.0) and ax - ay / (by - ay) * (bx - ax) > 0.0
    for b in range(arcs.runs[i], arcs.runs[i + 1]):
        if py < boxes[b, 1] or py > boxes[b, 3] or px > boxes[b, 2]:
            continue
        start = first + (b - arcs.runs[i]) * BOX_SEGMENTS
        ax, ay = points[start, 0] - px, points[start, 1] - py
        for s in range(start + 1, min(start + BOX_SEGMENTS, last) + 1):
            bx, by = points[s, 0] - px, points[s, 1] - py
            ex, ey = bx - ax, by - ay
            if (ay > 0.0) != (by > 0.0) and ax - ay / ey * ex > 0.0:
                inside = not inside
            ax, ay = bx, by
    return inside


@inlined
def _signed(px: float, py: float, arcs: Arcs, i: int, known: float, apart: float) -> float:
    """Signed distance of a point to arc i; ``known`` is that of a point which is at most ``apart`` away."""
    far = _nearest(px, py, arcs, i, abs(known) + apart)
    negative = known < 0.0 if abs(known) > apart else _is_inside(px, py, arcs, i)
    return -far if negative else far


@inner
def _known(distances: FloatArray, inside: FloatArray, arcs: Arcs, k: int, i: int, other: int) -> float:
    """``distances[k, i]``, computed now if nothing has asked for it before, from that of point ``other`` if known."""
    if np.isnan(distances[k, i]):
        x, y, known, apart = inside[k, 0], inside[k, 1], 0.0, np.inf
        if not np.isnan(distances[other, i]):
            dx, dy = x - inside[other, 0], y - inside[other, 1]
            known, apart = distances[other, i], np.sqrt(dx * dx + dy * dy) + BOUND_SLACK
        distances[k, i] = _signed(x, y, arcs, i, known, apart)
    return float(distances[k, i])


@kernel
def nearest_pieces(inside: FloatArray, rings: int, arcs: Arcs, distances: FloatArray) -> IntArray:
    """(k,) the piece of smallest signed distance at every point of a ring mesh; of equals the first.

    ``inside`` (k, 2) are the mesh points, moved off the trunk's edges into it; of ``distances`` (k, n), NaN at first,
    those are filled in that were needed.
    """
    n = len(arcs.offsets) - 1
    labels = np.zeros(len(inside), dtype=np.int64)
    # Blocks of points u·a + s·b between spokes a and b, u + s ≤ rings, are quartered until one piece is left. Every
    # block has the distances from the middle of the block that it is a quarter of, and a bound of the change since.
    whole = 1
    while whole < rings:
        whole *= 2
    capacity = 4 * (int(np.log2(whole)) + 2)
    blocks, seen, slack = np.empty((capacity, 3), dtype=np.int64), np.empty((capacity, n)), np.empty(capacity)
    here = np.empty(n)
    centre = len(inside) - 1
    for side in range(n):
        blocks[0, 0], blocks[0, 1], blocks[0, 2] = 1, 0, whole
        for i in range(n):
            seen[0, i] = 0.0
        slack[0] = np.inf
        top = 1
        while top > 0:
            top -= 1
            u0, s0, size = blocks[top, 0], blocks[top, 1], blocks[top, 2]
            u1, s1 = min(u0 + size - 1, rings - s0), min(s0 + size - 1, rings - u0)
            corner_a, corner_b = _mesh_index(n, rings, side, u1, s0), _mesh_index(n, rings, side, u0, s1)
            # A point halfway between two of the block's points lies inside the trunk.
            x, y = 0.5 * (inside[corner_a, 0] + inside[corner_b, 0]), 0.5 * (inside[corner_a, 1] + inside[corner_b, 1])
            radius = 0.0
            if size > 1:
                radius = _reach(inside, n, rings, side, u0, u1, s0, s1, x, y)
            best, label = np.inf, -1
            for i in range(n):
                before, here[i] = seen[top, i], np.inf
                if before == np.inf:
                    continue
                here[i] = _signed(x, y, arcs, i, before, slack[top])
                if here[i] < best:
                    best, label = here[i], i
            if size == 1:
                labels[corner_a] = label
                for i in range(n):
                    if here[i] < np.inf:
                        distances[corner_a, i] = here[i]
                continue
            left = 0
            for i in range(n):
                if here[i] > best + 2.0 * (radius + BOUND_SLACK):
                    here[i] = np.inf
                else:
                    left += 1
            if left == 1:
                for u in range(u0, u1 + 1):
                    for s in range(s0, min(s1, rings - u) + 1):
                        labels[_mesh_index(n, rings, side, u, s)] = label
                continue
            half = size // 2
            for quarter in range(4):
                u, s = u0 + half * (quarter // 2), s0 + half * (quarter % 2)
                if u + s <= rings:
                    blocks[top, 0], blocks[top, 1], blocks[top, 2] = u, s, half
                    for i in range(n):
                        seen[top, i] = here[i]
                    slack[top] = radius + BOUND_SLACK
                    top += 1
    for i in range(n):
        if _known(distances, inside, arcs, centre, i, centre) < distances[centre, labels[centre]]:
            labels[centre] = i
    return labels


@inner
def _mesh_index(n: int, rings: int, side: int, u: int, s: int) -> int:
    """Index of mesh point u·a + s·b between the spokes of ``side``: rings are listed from the outermost inwards."""
    r = u + s
    return (n * (rings * (rings + 1) - r * (r + 1))) // 2 + side * r + s


@inner
def _reach(
    inside: FloatArray, n: int, rings: int, side: int, u0: int, u1: int, s0: int, s1: int, x: float, y: float
) -> float:
    """Greatest distance from (x, y) to the points of the block u0…u1, s0…s1, u + s ≤ rings: a corner has it."""
    worst = 0.0
    for corner in range(5):
        u, s = u0, s0
        if corner == 1:
            u = u1
        elif corner == 2:
            s = s1
        elif corner == 3:
            u, s = u1, min(s1, rings - u1)
        elif corner == 4:
            u, s = min(u1, rings - s1), s1
        k = _mesh_index(n, rings, side, u, s)
        worst = max(worst, (inside[k, 0] - x) ** 2 + (inside[k, 1] - y) ** 2)
    return float(np.sqrt(worst))


@kernel
def lost_contact(inside: FloatArray, rings: int, arcs: Arcs, distances: FloatArray, least: float) -> FloatArray:
    """(n,) share of every trunk edge's mesh points to which another piece is nearer by more than ``least``.

    Fills in the boundary points' ``distances``.
    """
    n = len(arcs.offsets) - 1
    shares = np.zeros(n)
    for edge in range(n):
        lost = 0
        for k in range(edge * rings, (edge + 1) * rings):
            best = np.inf
            for i in range(n):
                best = min(best, _known(distances, inside, arcs, k, i, max(k - 1, 0)))
            if best < distances[k, edge] - least:
                lost += 1
        shares[edge] = lost / rings
    return shares


@kernel
def rooted(labels: IntArray, triangles: IntArray, boundary: int) -> BoolArray:
    """(k,) which mesh points are connected, within their cell, to one of the first ``boundary`` points."""
    is_rooted = np.empty(len(labels), dtype=np.bool_)
    for k in range(len(labels)):
        is_rooted[k] = k < boundary
    left, before, inwards = len(labels) - boundary, -1, True
    # Cells mostly widen from the boundary inwards, and triangles are listed outwards: few passes reach all.
    while left > 0 and left != before:
        before = left
        for step in range(len(triangles)):
            t = len(triangles) - 1 - step if inwards else step
            for k in range(3):
                a, b = triangles[t, k], triangles[t, k - 1]
                if is_rooted[a] != is_rooted[b] and labels[a] == labels[b]:
                    is_rooted[a] = is_rooted[b] = True
                    left -= 1
        inwards = not inwards
    return is_rooted


@kernel
def weights(points: FloatArray, triangles: IntArray) -> FloatArray:
    """(k,) a third of the area of the triangles around every mesh point."""
    areas = np.zeros(len(points))
    for t in range(len(triangles)):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        ux, uy = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
        vx, vy = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1]
        third = 0.5 * abs(ux * vy - uy * vx) / 3.0
        areas[a] += third
        areas[b] += third
        areas[c] += third
    return areas


@kernel
def flood(
    inside: FloatArray, triangles: IntArray, arcs: Arcs, is_rooted: BoolArray, labels: IntArray, distances: FloatArray
) -> None:
    """Give the points that are not rooted to neighbouring cells, nearest piece first: ``labels`` is changed."""
    done, loose, size = is_rooted.copy(), np.empty(len(triangles), dtype=np.int64), 0
    for t in range(len(triangles)):
        if not (done[triangles[t, 0]] and done[triangles[t, 1]] and done[triangles[t, 2]]):
            loose[size] = t
            size += 1
    # So few points are cut off from their edge that every turn can look at all of their triangles.
    while True:
        nearest, point, label = np.inf, -1, -1
        for slot in range(size):
            for k in range(3):
                a = triangles[loose[slot], k]
                for j in range(1, 3):
                    other = triangles[loose[slot], (k + j) % 3]
                    if done[other] and not done[a]:
                        i = labels[other]
                        far = _known(distances, inside, arcs, a, i, a)
                        if far < nearest or (far == nearest and (a < point or (a == point and i < label))):
                            nearest, point, label = far, a, i
        if point < 0:
            break
        done[point] = True
        labels[point] = label


@kernel
def distances_beside(
    inside: FloatArray, triangles: IntArray, arcs: Arcs, labels: IntArray, distances: FloatArray
) -> IntArray:
    """(m,) the triangles in which cells meet; fills in ``distances`` of their corners to those cells' pieces."""
    mixed = np.empty(len(triangles), dtype=np.int64)
    m = 0
    for t in range(len(triangles)):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        if labels[a] == labels[b] and labels[b] == labels[c]:
            continue
        mixed[m] = t
        m += 1
        for k in range(3):
            following, last = triangles[t, (k + 1) % 3], triangles[t, (k + 2) % 3]
            for j in range(3):
                i = labels[triangles[t, j]]
                if np.isnan(distances[triangles[t, k], i]):
                    other = last if np.isnan(distances[following, i]) else following
                    _known(distances, inside, arcs, triangles[t, k], i, other)
    return mixed[:m]


def warm() -> None:
    """Compile on one triangle with an arc on every edge."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 1.0], [0.5, 0.5]])
    arcs = boxed(corners[[0, 1, 1, 2, 2, 0]], np.array([0, 2, 4, 6], dtype=np.int64), 0)
    distances = np.full((4, 3), np.nan)
    labels = nearest_pieces(corners, 1, arcs, distances)
    triangles = np.array([[3, 0, 1], [3, 1, 2], [3, 2, 0]], dtype=np.int64)
    lost_contact(corners, 1, arcs, distances, 0.0)
    is_rooted = rooted(labels, triangles, 3)
    weights(corners, triangles)
    flood(corners, triangles, arcs, is_rooted, labels, distances)
    distances_beside(corners, triangles, arcs, labels, distances)
