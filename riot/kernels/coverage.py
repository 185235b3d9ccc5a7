"""How badly swung arcs tile a trunk: the area term of CRS by scanlines (paper eq. 5; method ours, theory §6).

Each arc of P is carried onto the corresponding edge of Q's trunk T' by the similarity that maps its end points, and
closed by that edge to a region with winding number w_i(x). With W = Σ w_i::

    d_A = ∫_{T'} |W − 1|  +  ∫_{outside T'} Σ|w_i|

that is gaps + overlaps + outside. Where a trunk edge leaves P, w = −1 on the far side: what P lacks there counts once.
"""

from __future__ import annotations

import numpy as np

from riot.kernels.options import kernel
from riot.shape import FloatArray, IntArray


@kernel
def swung_arcs(points: FloatArray, trunk: IntArray, target: FloatArray, out: FloatArray, offsets: IntArray) -> int:
    """Carry the arcs of a polygon (m, 2) between ``trunk`` vertices (n,) onto ``target`` (n, 2) corners, in that order.

    Arc i runs from ``trunk[i]`` forwards to ``trunk[i + 1]``, both included, and is carried onto the segment from
    ``target[i]`` to ``target[i + 1]``. Fills ``out`` (≥ m + n, 2) and ``offsets`` (n + 1,); returns the number of
    points.
    """
    m, n = points.shape[0], len(trunk)
    total = 0
    for i in range(n):
        offsets[i] = total
        start, stop = trunk[i], trunk[(i + 1) % n]
        px, py = points[start, 0], points[start, 1]
        ux, uy = points[stop, 0] - px, points[stop, 1] - py
        wx, wy = target[(i + 1) % n, 0] - target[i, 0], target[(i + 1) % n, 1] - target[i, 1]
        square = ux * ux + uy * uy
        # The similarity is multiplication by the complex number w / u.
        real, imaginary = (wx * ux + wy * uy) / square, (wy * ux - wx * uy) / square
        k = start
        while True:
            x, y = points[k, 0] - px, points[k, 1] - py
            out[total, 0] = target[i, 0] + real * x - imaginary * y
            out[total, 1] = target[i, 1] + real * y + imaginary * x
            total += 1
            if k == stop:
                break
            k = (k + 1) % m
    offsets[n] = total
    return total


@kernel
def uncovered(target: FloatArray, arcs: FloatArray, offsets: IntArray, lines: int) -> FloatArray:
    """(3,) areas of gaps, overlaps and outside of swung arcs in the convex polygon ``target`` (n, 2), either way
    round."""
    n = target.shape[0]
    total = offsets[n]
    low, high = np.inf, -np.inf
    for k in range(total):
        low, high = min(low, arcs[k, 1]), max(high, arcs[k, 1])
    step = (high - low) / lines
    counts = np.zeros(lines + 1, dtype=np.int64)
    for i in range(n):
        for k in range(offsets[i], offsets[i + 1]):
            after = k + 1 if k + 1 < offsets[i + 1] else offsets[i]
            first, last = _lines_between(arcs[k, 1], arcs[after, 1], low, step, lines)
            for line in range(first, last):
                counts[line + 1] += 1
    for line in range(lines):
        counts[line + 1] += counts[line]
    x = np.empty(counts[lines])
    owner = np.empty(counts[lines], dtype=np.int64)
    sign = np.empty(counts[lines], dtype=np.int64)
    left, right = np.full(lines, np.inf), np.full(lines, -np.inf)
    cursor = counts[:lines].copy()
    for i in range(n):
        for k in range(offsets[i], offsets[i + 1]):
            chord = k + 1 == offsets[i + 1]
            after = offsets[i] if chord else k + 1
            x0, y0, x1, y1 = arcs[k, 0], arcs[k, 1], arcs[after, 0], arcs[after, 1]
            first, last = _lines_between(y0, y1, low, step, lines)
            slope = (x1 - x0) / (y1 - y0) if y1 != y0 else 0.0
            for line in range(first, last):
                at = x0 + slope * (low + (line + 0.5) * step - y0)
                slot = cursor[line]
                cursor[line] += 1
                x[slot], owner[slot], sign[slot] = at, i, (1 if y1 > y0 else -1)
                if chord:
                    left[line], right[line] = min(left[line], at), max(right[line], at)
    return _sweep(n, counts, x, owner, sign, left, right) * step


@kernel
def _lines_between(y0: float, y1: float, low: float, step: float, lines: int) -> tuple[int, int]:
    """Scanlines, at low + (k + ½) step, from the lower end (included) to the upper (excluded)."""
    first = int(np.ceil((min(y0, y1) - low) / step - 0.5))
    last = int(np.ceil((max(y0, y1) - low) / step - 0.5))
    return max(first, 0), min(last, lines)


@kernel
def _sweep(
    n: int, counts: IntArray, x: FloatArray, owner: IntArray, sign: IntArray, left: FloatArray, right: FloatArray
) -> FloatArray:
    """(3,) lengths of gaps, overlaps and outside, summed over scanlines."""
    found = np.zeros(3)
    winding = np.zeros(n, dtype=np.int64)
    for line in range(len(left)):
        start, stop = counts[line], counts[line + 1]
        for k in range(start + 1, stop):  # insertion sort: a dozen crossings
            at, who, which = x[k], owner[k], sign[k]
            slot = k
            while slot > start and x[slot - 1] > at:
                x[slot], owner[slot], sign[slot] = x[slot - 1], owner[slot - 1], sign[slot - 1]
                slot -= 1
            x[slot], owner[slot], sign[slot] = at, who, which
        whole, apart = 0, 0
        winding[:] = 0
        if right[line] > left[line] and (start == stop or left[line] < x[start]):
            found[0] += (x[start] if stop > start else right[line]) - left[line]
        for k in range(start, stop):
            who = owner[k]
            # Crossing an upward edge from left to right leaves its left side: the winding number falls.
            apart -= abs(winding[who])
            winding[who] -= sign[k]
            apart += abs(winding[who])
            whole -= sign[k]
            if k + 1 == stop:
                break
            x0, x1 = x[k], x[k + 1]
            inside = min(x1, right[line]) - max(x0, left[line])
            if inside > 0.0:
                if whole < 1:
                    found[0] += (1 - whole) * inside
                else:
                    found[1] += (whole - 1) * inside
                found[2] += apart * (x1 - x0 - inside)
            else:
                found[2] += apart * (x1 - x0)
    return found


@kernel
def area_terms(
    points_a: FloatArray,
    points_b: FloatArray,
    trunks_a: IntArray,
    trunks_b: IntArray,
    lines: int,
) -> FloatArray:
    """(k, 2) d_A of k pairs of corresponding trunks (k, n): P's arcs in Q's trunk, and Q's arcs in P's.

    ``trunks_a`` are counter-clockwise vertices of P, ``trunks_b`` the corresponding ones of Q, clockwise.
    """
    k, n = trunks_a.shape
    room = max(points_a.shape[0], points_b.shape[0]) + n
    arcs, offsets = np.empty((room, 2)), np.empty(n + 1, dtype=np.int64)
    found = np.empty((k, 2))
    for row in range(k):
        a, b = trunks_a[row], trunks_b[row]
        corners_a, corners_b = points_a[a], points_b[b]
        swung_arcs(points_a, a, corners_b, arcs, offsets)
        found[row, 0] = uncovered(corners_b, arcs, offsets, lines).sum()
        # Read backwards, Q's trunk is counter-clockwise, and P's corners in that order are clockwise.
        swung_arcs(points_b, b[::-1].copy(), corners_a[::-1].copy(), arcs, offsets)
        found[row, 1] = uncovered(corners_a[::-1].copy(), arcs, offsets, lines).sum()
    return found


def warm() -> None:
    """Compile on two squares."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    trunk = np.arange(4, dtype=np.int64)[None]
    area_terms(square, square, trunk, np.ascontiguousarray(trunk[:, ::-1]), 8)
    arcs, offsets = np.empty((8, 2)), np.empty(5, dtype=np.int64)
    swung_arcs(square, trunk[0], square, arcs, offsets)
    uncovered(square, arcs, offsets, 8)
