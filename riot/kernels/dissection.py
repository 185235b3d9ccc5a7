"""The ring mesh of a trunk, and the boundaries between its cells (theory §1.2, §8; methods ours)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riot.kernels.options import inner, kernel
from riot.types import BoolArray, FloatArray, IntArray


class Chains(NamedTuple):
    """Borders between two cells, from a junction or corner of the trunk to the next.

    ``points`` (p, 2) with ``offsets`` (c + 1,); ``ends`` (c, 2) the nodes at both ends: corner k of the n of the trunk
    is node k, triangle t is node n + t; ``sides`` (c, 2) the cells on either side, smaller first. ``whole`` is False
    if a border breaks off.
    """

    points: FloatArray
    offsets: IntArray
    ends: IntArray
    sides: IntArray
    whole: bool


@kernel
def ring_mesh(polygon: FloatArray, middle: FloatArray, rings: int) -> tuple[FloatArray, IntArray]:
    """(k, 2) points and (t, 3) triangles over a convex polygon (n, 2), in rings around its middle.

    Ring r has r points on each side, from spoke to spoke; rings are listed from the outermost inwards, the middle
    last, triangles from the innermost outwards. A polygon's corners are among the points to the last bit.
    """
    n = len(polygon)
    points = np.empty((n * rings * (rings + 1) // 2 + 1, 2))
    triangles = np.empty((n * rings * rings, 3), dtype=np.int64)
    k = 0
    for r in range(rings, 0, -1):
        for side in range(n):
            for s in range(r):
                for axis in range(2):
                    spoke, onward = polygon[side, axis] - middle[axis], polygon[(side + 1) % n, axis] - middle[axis]
                    points[k, axis] = middle[axis] + ((r - s) * spoke + s * onward) / rings
                k += 1
    for axis in range(2):
        points[k, axis] = middle[axis]
        for side in range(n):
            points[side * rings, axis] = polygon[side, axis]
    t = 0
    for r in range(rings):
        inner = n * (rings * (rings + 1) - r * (r + 1)) // 2
        outer = n * (rings * (rings + 1) - (r + 1) * (r + 2)) // 2
        size, wide = max(n * r, 1), n * (r + 1)
        for side in range(n):
            for s in range(r + 1):
                triangles[t, 0] = inner + (side * r + s) % size
                triangles[t, 1] = outer + side * (r + 1) + s
                triangles[t, 2] = outer + (side * (r + 1) + s + 1) % wide
                t += 1
        for side in range(n):
            for s in range(r):
                triangles[t, 0] = inner + (side * r + s) % size
                triangles[t, 1] = outer + (side * (r + 1) + s + 1) % wide
                triangles[t, 2] = inner + (side * r + s + 1) % size
                t += 1
    return points, triangles


@kernel
def chains(
    points: FloatArray,
    mixed: IntArray,
    labels: IntArray,
    distances: FloatArray,
    corners: IntArray,
    corner_share: float,
    coincident: float,
) -> Chains:
    """Follow the borders through the triangles in which cells meet, ``mixed`` (m, 3).

    A border crosses a mesh edge where the signed distances to the two cells' pieces are equal, or runs into a corner of
    the trunk; where three cells meet, it ends in the middle of the triangle. Points closer than ``coincident`` to the
    one before or to the last are left out. Every border is listed once, from the end that comes first in `_order`.
    """
    m, n = len(mixed), len(corners)
    across, at_corner, positions = _crossings(points, mixed, labels, distances, corners, corner_share)
    nodes = np.empty((n + m, 2))
    for axis in range(2):
        for corner in range(n):
            nodes[corner, axis] = points[corners[corner], axis]
        for t in range(m):
            at = positions[3 * t, axis] + positions[3 * t + 1, axis]
            nodes[n + t, axis] = (at + positions[3 * t + 2, axis]) / 3.0
    # Half k of triangle t is its side from point k to the next; the boundary crosses it if its ends' cells differ.
    cut, three = np.zeros(3 * m, dtype=np.bool_), np.zeros(m, dtype=np.bool_)
    for t in range(m):
        for k in range(3):
            cut[3 * t + k] = labels[mixed[t, k]] != labels[mixed[t, (k + 1) % 3]]
        three[t] = cut[3 * t] and cut[3 * t + 1] and cut[3 * t + 2]
    out, offsets = np.empty((9 * m + 2 * n, 2)), np.zeros(3 * m + n + 1, dtype=np.int64)
    ends, sides = np.empty((3 * m + n, 2), dtype=np.int64), np.empty((3 * m + n, 2), dtype=np.int64)
    chain = np.empty((m + 3, 2))
    count, whole = 0, True
    for half in range(3 * m):
        if not cut[half]:
            continue
        t, corner = half // 3, at_corner[half]
        # A chain leaves a triangle of three cells by every side, and a corner by the side that the corner stands for,
        # unless the triangle's other crossing is that corner too.
        for node in (n + t if three[t] else -1, corner):
            if node < 0 or (node < n and not three[t] and at_corner[_other(cut, half)] == corner):
                continue
            _copy(nodes, node, chain, 0)
            size, last = 1, n + t
            if node >= n or not three[t]:
                start = half if node >= n else _other(cut, half)
                size, last = _follow(start, n, across, at_corner, positions, cut, three, chain)
            if last < 0:
                whole = False
                continue
            _copy(nodes, last, chain, size)
            if _order(node, mixed, corners, len(points)) > _order(last, mixed, corners, len(points)):
                continue  # it comes from its other end
            offsets[count + 1] = _thinned(chain, size + 1, out, offsets[count], coincident)
            ends[count, 0], ends[count, 1] = node, last
            a, b = labels[mixed[t, half % 3]], labels[mixed[t, (half % 3 + 1) % 3]]
            sides[count, 0], sides[count, 1] = min(a, b), max(a, b)
            count += 1
    if not whole:
        count = 0
    return Chains(out[: offsets[count]], offsets[: count + 1], ends[:count], sides[:count], whole)


@inner
def _copy(source: FloatArray, k: int, target: FloatArray, slot: int) -> None:
    """Copy point k of ``source`` (k, 2) to a slot of ``target`` (l, 2)."""
    target[slot, 0], target[slot, 1] = source[k, 0], source[k, 1]


@inner
def _follow(
    half: int,
    n: int,
    across: IntArray,
    at_corner: IntArray,
    positions: FloatArray,
    cut: BoolArray,
    three: BoolArray,
    chain: FloatArray,
) -> tuple[int, int]:
    """Fill ``chain`` from its second point on with the crossings from ``half`` on.

    Returns the number of points, and the node at the end: −1 if the border breaks off.
    """
    size = 1
    while at_corner[half] < 0:
        _copy(positions, half, chain, size)
        size += 1
        after = across[half]
        if after < 0:
            return size, -1
        if three[after // 3]:
            return size, n + after // 3
        half = _other(cut, after)
    return size, at_corner[half]


@inner
def _other(cut: BoolArray, half: int) -> int:
    """The other side of a triangle of two cells that the boundary crosses."""
    base = half - half % 3
    for k in range(base, base + 3):
        if cut[k] and k != half:
            return k
    return -1


@kernel
def _crossings(
    points: FloatArray,
    mixed: IntArray,
    labels: IntArray,
    distances: FloatArray,
    corners: IntArray,
    corner_share: float,
) -> tuple[IntArray, IntArray, FloatArray]:
    """For every half: the half on the other side or −1, the corner it runs into or −1, and the position of the
    crossing."""
    m, n = len(mixed), len(corners)
    rings = corners[1] - corners[0]
    across, at_corner = np.empty(3 * m, dtype=np.int64), np.empty(3 * m, dtype=np.int64)
    positions = np.empty((3 * m, 2))
    # The halves whose side begins at mesh point u, the lesser of its two: the newest, and for each the one before it.
    newest, earlier = np.empty(len(points), dtype=np.int64), np.empty(3 * m, dtype=np.int64)
    for u in range(len(points)):
        newest[u] = -1
    for half in range(3 * m):
        across[half], at_corner[half] = -1, -1
        t, k = half // 3, half % 3
        u, v = mixed[t, k], mixed[t, (k + 1) % 3]
        u, v = min(u, v), max(u, v)
        a, b = labels[u], labels[v]
        other = newest[u]
        while other >= 0 and mixed[other // 3, other % 3] != v and mixed[other // 3, (other % 3 + 1) % 3] != v:
            other = earlier[other]
        if other >= 0:
            across[half], across[other] = other, half
        earlier[half], newest[u] = newest[u], half
        if a == b:
            continue
        corner = -1
        if u < n * rings and u % rings == 0:
            corner = u // rings
        elif v < n * rings and v % rings == 0:
            corner = v // rings
        if corner >= 0:
            before = (corner - 1) % n
            if (a == corner and b == before) or (a == before and b == corner):
                # The boundary between the cells of the two edges that meet at a corner ends in the corner.
                at_corner[half] = corner
                _copy(points, corners[corner], positions, half)
                continue
        # A point flooded or forced into a cell may lie nearer to the other piece: then the boundary keeps next to it.
        at_u = max(distances[u, b] - distances[u, a], 0.0)
        at_v = max(distances[v, a] - distances[v, b], 0.0)
        share = 0.5 if at_u + at_v == 0.0 else at_u / (at_u + at_v)
        least = corner_share if corner >= 0 else 0.0
        share = min(max(share, least), 1.0 - least)
        for axis in range(2):
            positions[half, axis] = points[u, axis] + share * (points[v, axis] - points[u, axis])
    return across, at_corner, positions


@inner
def _order(node: int, mixed: IntArray, corners: IntArray, count: int) -> int:
    """The key that orders nodes, by the ascending mesh points of a triangle, of ``count``, or that of a corner."""
    n = len(corners)
    if node < n:
        return int(corners[node] * count * count)
    a, b, c = mixed[node - n, 0], mixed[node - n, 1], mixed[node - n, 2]
    least, most = min(a, min(b, c)), max(a, max(b, c))
    return int((least * count + (a + b + c - least - most)) * count + most)


@inner
def _thinned(chain: FloatArray, size: int, out: FloatArray, start: int, coincident: float) -> int:
    """Append a chain to ``out`` without coincident points; returns where it ends there."""
    _copy(chain, 0, out, start)
    stop, last = start + 1, size - 1
    for k in range(1, last):
        x, y = chain[k, 0], chain[k, 1]
        near = np.hypot(x - out[stop - 1, 0], y - out[stop - 1, 1])
        if min(near, np.hypot(x - chain[last, 0], y - chain[last, 1])) > coincident:
            _copy(chain, k, out, stop)
            stop += 1
    _copy(chain, last, out, stop)
    return stop + 1


def warm() -> None:
    """Compile on a triangle of three cells."""
    points, triangles = ring_mesh(np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]]), np.array([0.5, 0.3]), 4)
    labels = np.zeros(len(points), dtype=np.int64)
    labels[4:12] = np.repeat(np.arange(1, 3), 4)
    chains(points, triangles, labels, np.zeros((len(points), 3)), np.array([0, 4, 8]), 0.1, 1e-9)
