"""The area term of CRS by scanlines: how much swung arcs fail to tile a trunk (paper eq. 5; method ours, theory §6).

Each arc of P is carried onto the corresponding edge of Q's trunk T' by the similarity that maps its end points, and
closed by that edge to a region with winding number w_i(x). With W = Σ w_i::

    d_A = ∫_{T'} |W − 1|  +  ∫_{outside T'} Σ|w_i|

which is gaps + overlaps + outside. Where a trunk edge leaves P, w = −1 beyond it: what P lacks there counts once.
"""

from __future__ import annotations

import numpy as np

from riot.kernels.options import inner, kernel
from riot.types import FloatArray, IntArray

_LIMIT_SLACK = 1e-9
"""Share by which an area term may exceed the limit before its sweep ends early. Ours: far above the rounding of
sums."""


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
        after = i + 1 if i + 1 < n else 0
        start, stop = trunk[i], trunk[after]
        px, py = points[start, 0], points[start, 1]
        ux, uy = points[stop, 0] - px, points[stop, 1] - py
        tx, ty = target[i, 0], target[i, 1]
        wx, wy = target[after, 0] - tx, target[after, 1] - ty
        square = ux * ux + uy * uy
        # The similarity is multiplication by the complex number w / u.
        real, imaginary = (wx * ux + wy * uy) / square, (wy * ux - wx * uy) / square
        k = start
        while True:
            x, y = points[k, 0] - px, points[k, 1] - py
            out[total, 0] = tx + real * x - imaginary * y
            out[total, 1] = ty + real * y + imaginary * x
            total += 1
            if k == stop:
                break
            k += 1
            if k == m:
                k = 0
    offsets[n] = total
    return total


@kernel
def uncovered(target: FloatArray, arcs: FloatArray, offsets: IntArray, lines: int) -> FloatArray:
    """(3,) areas of gaps, overlaps and outside of swung arcs in the convex polygon ``target`` (n, 2) of either
    orientation."""
    gaps, overlaps, outside = _uncovered(target.shape[0], arcs, offsets, lines, np.inf)
    return np.array([gaps, overlaps, outside])


@kernel
def _uncovered(n: int, arcs: FloatArray, offsets: IntArray, lines: int, limit: float) -> tuple[float, float, float]:
    """Areas of gaps, overlaps and outside in a trunk of n corners.

    The sum stops at the first scanline after which it is greater than ``limit``.
    """
    total = offsets[n]
    low, high = np.inf, -np.inf
    for k in range(total):
        low, high = min(low, arcs[k, 1]), max(high, arcs[k, 1])
    step = (high - low) / lines
    # An edge crosses the scanlines, at low + (line + ½) step, from its lower end (included) to its upper (excluded).
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
    most, crossing = starts[0], starts[0]  # 0; a literal would have `_sweep` compiled once more
    for line in range(lines):
        crossing += starts[line + 1]
        most = max(most, crossing)
        starts[line + 1] = starts[line] + crossing
    x, code = np.empty(starts[lines]), np.empty(starts[lines], dtype=np.int64)
    left, right, cursor = np.empty(lines), np.empty(lines), np.empty(lines, dtype=np.int64)
    for line in range(lines):
        left[line], right[line], cursor[line] = np.inf, -np.inf, starts[line]
    for i in range(n):
        for k in range(offsets[i], offsets[i + 1]):
            chord = k + 1 == offsets[i + 1]
            after = offsets[i] if chord else k + 1
            first, last = min(above[k], above[after]), max(above[k], above[after])
            if first == last:
                continue
            x0, y0, x1, y1 = arcs[k, 0], arcs[k, 1], arcs[after, 0], arcs[after, 1]
            slope = (x1 - x0) / (y1 - y0)
            who = 2 * i + (1 if y1 > y0 else 0)
            for line in range(first, last):
                at = x0 + slope * (low + (line + 0.5) * step - y0)
                slot = cursor[line]
                cursor[line] = slot + 1
                x[slot], code[slot] = at, who
                if chord:
                    left[line], right[line] = min(left[line], at), max(right[line], at)
    return _sweep(n, starts, most, x, code, left, right, step, limit)


@kernel
def _sweep(
    n: int,
    starts: IntArray,
    most: int,
    x: FloatArray,
    code: IntArray,
    left: FloatArray,
    right: FloatArray,
    step: float,
    limit: float,
) -> tuple[float, float, float]:
    """Gaps, overlaps and outside, scanline by scanline, until their sum is greater than ``limit``.

    Scanline k has ``starts[k + 1] - starts[k]`` crossings, ``most`` at most, at ``x``, of the edge regions
    ``code // 2``, upwards where ``code`` is odd; the trunk goes from ``left[k]`` to ``right[k]``.
    """
    gaps, overlaps, outside = 0.0, 0.0, 0.0
    winding = np.zeros(n, dtype=np.int64)
    row, order = np.empty(most), np.empty(most, dtype=np.int64)
    before = 0
    for line in range(len(left)):
        start, m = starts[line], starts[line + 1] - starts[line]
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
        whole, apart = 0, 0
        for i in range(n):
            winding[i] = 0
        for k in range(m - 1):
            which = code[start + order[k]]
            # Crossing an upward edge from left to right leaves its left side: the winding number falls.
            who, turn = which >> 1, 1 - 2 * (which & 1)
            apart += abs(winding[who] + turn) - abs(winding[who])
            winding[who] += turn
            whole += turn
            x0, x1 = row[k], row[k + 1]
            inside = max(min(x1, right[line]) - max(x0, left[line]), 0.0)
            gaps += max(1 - whole, 0) * inside
            overlaps += max(whole - 1, 0) * inside
            outside += apart * (x1 - x0 - inside)
        if (gaps + overlaps + outside) * step > limit:
            break
    return gaps * step, overlaps * step, outside * step


@kernel
def _one_way(
    points: FloatArray,
    other: FloatArray,
    trunk: IntArray,
    other_trunk: IntArray,
    way: int,
    lines: int,
    limit: float,
    arcs: FloatArray,
    offsets: IntArray,
) -> float:
    """d_A one way, exact unless it is greater than ``limit``: the arcs of ``points`` in the trunk of ``other``.

    With ``way`` 1 both trunks, (n,) vertices, are read from the last to the first, with 0 from the first to the last.
    ``arcs`` and ``offsets`` are scratch for `swung_arcs`.
    """
    n = len(trunk)
    vertices, target = np.empty(n, dtype=np.int64), np.empty((n, 2))
    for j in range(n):
        i = n - 1 - j if way == 1 else j
        vertices[j] = trunk[i]
        target[j, 0], target[j, 1] = other[other_trunk[i], 0], other[other_trunk[i], 1]
    swung_arcs(points, vertices, target, arcs, offsets)
    gaps, overlaps, outside = _uncovered(n, arcs, offsets, lines, limit)
    return gaps + overlaps + outside


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
    n = trunks_a.shape[1]
    arcs = np.empty((max(points_a.shape[0], points_b.shape[0]) + n, 2))
    offsets = np.empty(n + 1, dtype=np.int64)
    # Read backwards, Q's trunk is counter-clockwise, and P's corners in that order are clockwise.
    return np.array(
        [
            (
                _one_way(points_a, points_b, a, b, 0, lines, np.inf, arcs, offsets),
                _one_way(points_b, points_a, b, a, 1, lines, np.inf, arcs, offsets),
            )
            for a, b in zip(trunks_a, trunks_b, strict=True)
        ]
    ).reshape(-1, 2)


@kernel
def best_area_terms(
    points_a: FloatArray,
    points_b: FloatArray,
    trunks_a: tuple[IntArray, IntArray],
    trunks_b: tuple[IntArray, IntArray],
    order: IntArray,
    candidates: FloatArray,
    which: IntArray,
    sigma: float,
    lines: int,
    count: int,
    kept: FloatArray,
    kept_which: IntArray,
) -> tuple[int, int]:
    """Evaluate area terms of candidates, and keep the candidates of least distance max(terms, d_A/σ_A), the least
    first.

    Trunks are (offsets, vertices). Candidates are taken in ``order``, by ascending bound, until a bound is greater than
    the last distance of a full list; ``candidates`` and ``which`` are those of
    `riot.kernels.candidates.nearest_candidates`. ``kept`` (r, 2), distance and d_A, and ``kept_which`` (r, 3) begin
    with ``count`` entries of earlier calls. Among equals the first by (T, T', shift) is kept. Returns the number of
    entries now, and how many area terms were begun.
    """
    capacity = max(points_a.shape[0], points_b.shape[0]) + points_a.shape[0]
    arcs, offsets = np.empty((capacity, 2)), np.empty(points_a.shape[0] + 1, dtype=np.int64)
    begun = 0
    for number in range(len(order)):
        k = order[number]
        full = count == kept.shape[0]
        if full and candidates[k, 0] > kept[count - 1, 0]:
            break
        begun += 1
        t, u, s = which[k, 0], which[k, 1], which[k, 2]
        x, n = trunks_a[0][t], trunks_a[0][t + 1] - trunks_a[0][t]
        y = trunks_b[0][u]
        a, b = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
        for j in range(n):
            a[j], b[j] = trunks_a[1][x + j], trunks_b[1][y + (s - j if j <= s else s - j + n)]
        # The slack is for rounding: a term that stops early is certainly too great.
        limit = kept[count - 1, 0] * sigma * (1.0 + _LIMIT_SLACK) if full else np.inf
        area = 0.0
        for way in range(2):  # a literal would have `_one_way` compiled once more
            if way == 0:
                area = _one_way(points_a, points_b, a, b, way, lines, limit, arcs, offsets)
            elif area <= limit:
                area = max(area, _one_way(points_b, points_a, b, a, way, lines, limit, arcs, offsets))
        if area > limit:
            continue
        distance = max(candidates[k, 1], area / sigma)
        slot = count
        while slot > 0 and _before(distance, which, k, kept[slot - 1, 0], kept_which, slot - 1):
            slot -= 1
        if slot == kept.shape[0]:
            continue
        count = min(count + 1, kept.shape[0])
        for row in range(count - 1, slot, -1):
            kept[row, 0], kept[row, 1] = kept[row - 1, 0], kept[row - 1, 1]
            for j in range(3):
                kept_which[row, j] = kept_which[row - 1, j]
        kept[slot, 0], kept[slot, 1] = distance, area
        for j in range(3):
            kept_which[slot, j] = which[k, j]
    return count, begun


@inner
def _before(distance: float, which: IntArray, k: int, other: float, other_which: IntArray, m: int) -> bool:
    """Whether candidate ``which[k]`` comes before ``other_which[m]``."""
    if distance != other:
        return distance < other
    for j in range(3):
        if which[k, j] != other_which[m, j]:
            return bool(which[k, j] < other_which[m, j])
    return False


def warm() -> None:
    """Compile on two squares."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    trunk = np.arange(4, dtype=np.int64)[None]
    area_terms(square, square, trunk, np.ascontiguousarray(trunk[:, ::-1]), 8)
    arcs, offsets = np.empty((8, 2)), np.empty(5, dtype=np.int64)
    swung_arcs(square, trunk[0], square, arcs, offsets)
    uncovered(square, arcs, offsets, 8)
    trunks, values = (np.array([0, 4], dtype=np.int64), trunk[0]), np.ones((1, 2))
    which = np.zeros((1, 3), dtype=np.int64)
    best_area_terms(
        square, square, trunks, trunks, np.zeros(1, dtype=np.int64), values, which, 0.3, 8, 0, values, which
    )
