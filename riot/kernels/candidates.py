"""Trunk pairs of two shapes whose cheap bound is small: the candidates of best-first CRS (theory §6)."""

from __future__ import annotations

import numpy as np

from riot.kernels.options import kernel
from riot.kernels.qcrs import angle_sum, edge_sum
from riot.shape import FloatArray, IntArray


@kernel
def cheap_bounds(
    na: IntArray, oa: IntArray, ea: FloatArray, aa: FloatArray, ba: FloatArray, xa: FloatArray, sa: FloatArray,
    nb: IntArray, ob: IntArray, eb: FloatArray, ab: FloatArray, bb: FloatArray, xb: FloatArray, sb: FloatArray,
    sigma_e: float, sigma_angle: float, sigma_area: float, slack: float, limit: float,
    found: FloatArray, which: IntArray,
) -> int:  # fmt: skip
    """Count, and list as far as there is room, the (T, T', shift) whose bound is at most ``limit``.

    Side a lists its corners in order, side b backwards and twice (`riot.kernels.qcrs.mirrored`). ``x`` (s,) are the signed
    areas of the exterior pieces, ``s`` those of the trunks. Swung onto the other trunk a piece's area grows by the square of the
    edges' ratio; the area term is at least |trunk area − Σ pieces|, less ``slack`` for the scanlines. Fills ``found`` (r, 2)
    with the bound and max(d_E/σ_E, d_∠/σ_∠), ``which`` (r, 3) with (T, T', shift).
    """
    count = 0
    for t in range(len(na)):
        n = na[t]
        edge_unit, angle_unit = 1.0 / (n * sigma_e), 1.0 / (2.0 * n * sigma_angle)
        x = oa[t]
        for u in range(len(nb)):
            if nb[u] != n:
                continue
            for s in range(n):
                y = 2 * ob[u] + (n - s) % n
                edge = edge_sum(ea, x, eb, y, n) * edge_unit
                if edge > limit:
                    continue
                angle = angle_sum(aa, ba, x, ab, bb, y, n) * angle_unit
                if angle > limit:
                    continue
                pieces_a, pieces_b = 0.0, 0.0
                for j in range(n):
                    ratio = eb[y + j] / ea[x + j]
                    pieces_a += xa[x + j] * ratio * ratio
                    pieces_b += xb[y + j] / (ratio * ratio)
                deficit = max(abs(sb[u] - pieces_a), abs(sa[t] - pieces_b)) - slack
                bound = max(max(edge, angle), deficit / sigma_area)
                if bound > limit:
                    continue
                if count < found.shape[0]:
                    found[count, 0], found[count, 1] = bound, max(edge, angle)
                    which[count, 0], which[count, 1], which[count, 2] = t, u, s
                count += 1
    return count


def warm() -> None:
    """Compile on two triangles."""
    one, offsets = 3 * np.ones(1, dtype=np.int64), np.array([0, 3], dtype=np.int64)
    three, six, single = np.ones(3), np.ones(6), np.ones(1)
    cheap_bounds(
        one, offsets, three, three, three, three, single, one, offsets, six, six, six, six, single,
        0.1, 0.5, 0.3, 0.0, 1.0, np.empty((3, 2)), np.empty((3, 3), dtype=np.int64),
    )  # fmt: skip
