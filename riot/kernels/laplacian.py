"""Laplacian editing of polylines, and the contacts between arcs of a trunk (paper §4.3).

Points are complex numbers x + iy. A similarity of the plane is then multiplication by a complex number and a shift, and
the rotation-aware Laplacian coordinates of Sorkine et al. (2004) are linear over them.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from riot.kernels.options import inner, kernel
from riot.types import BoolArray, FloatArray, IntArray

ComplexArray = npt.NDArray[np.complex128]

_NOTHING = 1e-13
"""A smaller pivot belongs to a vertex that no row determines, and which stays. Ours: rows are of order 1."""


@kernel
def factored(rest: ComplexArray, fixed: BoolArray) -> tuple[ComplexArray, ComplexArray]:
    """Factor the editing of a polyline (m,), the positions of its ``fixed`` (m,) vertices being given.

    With u = z_k − (z_{k−1} + z_{k+1})/2 and v = z_{k+1} − z_{k−1}, and c the factor of the similarity that fits the
    three vertices best, row k of the least squares is u' − c u = v̄ (v u' − u v') / (⅔|u|² + ½|v|²) / 2, for all k but
    the two ends.
    Returns the normal equations' bands and their factors L D Lᴴ, (m, 3) each: column 0 the diagonal, column j the entry
    j columns before it. In the factors, rows and columns of fixed vertices are those of the identity.
    """
    m = len(rest)
    bands = np.zeros((m, 3), dtype=np.complex128)
    for k in range(1, m - 1):
        u = rest[k] - 0.5 * (rest[k - 1] + rest[k + 1])
        v = rest[k + 1] - rest[k - 1]
        scale = (u.real * u.real + u.imag * u.imag) * 4.0 / 3.0 + v.real * v.real + v.imag * v.imag
        if scale == 0.0:
            continue
        g = v.conjugate() / scale
        before, here, after = g * (u - 0.5 * v), g * v, g * (-u - 0.5 * v)
        bands[k - 1, 0] += before.conjugate() * before
        bands[k, 0] += here.conjugate() * here
        bands[k + 1, 0] += after.conjugate() * after
        bands[k, 1] += here.conjugate() * before
        bands[k + 1, 1] += after.conjugate() * here
        bands[k + 1, 2] += after.conjugate() * before
    factors = np.zeros((m, 3), dtype=np.complex128)
    for k in range(m):
        if fixed[k]:
            factors[k, 0] = 1.0
            continue
        far = bands[k, 2] if k > 1 and not fixed[k - 2] else 0.0j
        near = bands[k, 1] if k > 0 and not fixed[k - 1] else 0.0j
        pivot = bands[k, 0].real
        if k > 1:
            pivot -= _square(far) / factors[k - 2, 0].real
            near -= far * factors[k - 1, 1].conjugate()
            far /= factors[k - 2, 0].real
        if k > 0:
            pivot -= _square(near) / factors[k - 1, 0].real
            near /= factors[k - 1, 0].real
        # An infinite pivot makes the vertex stay, and every row that refers to it forget it.
        factors[k, 0] = pivot if pivot > _NOTHING else np.inf
        factors[k, 1], factors[k, 2] = near, far
    return bands, factors


@inner
def _square(z: complex) -> float:
    return z.real * z.real + z.imag * z.imag


@kernel
def solved(bands: ComplexArray, factors: ComplexArray, fixed: BoolArray, moves: ComplexArray) -> ComplexArray:
    """Displacements (m,) of all vertices, those of the ``fixed`` ones being ``moves`` (m,) to the last bit."""
    m = len(moves)
    displacements = np.zeros(m, dtype=np.complex128)
    for k in range(m):
        if fixed[k]:
            displacements[k] = moves[k]
            continue
        right = 0.0j
        for j in range(1, 3):
            if k >= j and fixed[k - j]:
                right -= bands[k, j] * moves[k - j]
            if k + j < m and fixed[k + j]:
                right -= bands[k + j, j].conjugate() * moves[k + j]
        for j in range(1, 3):
            if k >= j and not fixed[k - j]:
                right -= factors[k, j] * displacements[k - j]
        displacements[k] = right
    for k in range(m):
        if not fixed[k]:
            displacements[k] = displacements[k] / factors[k, 0].real
    for k in range(m - 1, -1, -1):
        if not fixed[k]:
            for j in range(1, 3):
                if k + j < m and not fixed[k + j]:
                    displacements[k] -= factors[k + j, j].conjugate() * displacements[k + j]
    return displacements


@kernel
def meet(
    arcs: ComplexArray,
    offsets: IntArray,
    owner: IntArray,
    changed: int,
    distance: FloatArray,
    foot: ComplexArray,
    inside: BoolArray,
    ahead: FloatArray,
    ahead_foot: ComplexArray,
) -> None:
    """Update the distances between vertices and arcs after arc ``changed`` has changed, or all of them if it is −1.

    ``arcs`` with ``offsets`` (n + 1,); vertex k of the first s points belongs to arc ``owner[k]``, whose piece lies on
    its left. The arrays (s, n) are filled: ``distance`` to an arc and its nearest point ``foot``; whether the vertex is
    ``inside`` the arc's piece; and ``ahead``, ``ahead_foot``, the distance and point of what lies on the right of the
    vertex's own arc (inf if nothing does).
    """
    n = len(offsets) - 1
    for k in range(len(owner)):
        own = owner[k]
        first, last = (0, n) if changed < 0 or own == changed else (changed, changed + 1)
        end = k in (offsets[own], offsets[own + 1] - 1)
        for i in range(first, last):
            if i != own:
                measured = _measure(arcs, offsets[i], offsets[i + 1], k, end)
                distance[k, i], foot[k, i], inside[k, i], ahead[k, i], ahead_foot[k, i] = measured


@inner
def _measure(
    arcs: ComplexArray, start: int, stop: int, k: int, end: bool
) -> tuple[float, complex, bool, float, complex]:
    """A vertex and an arc: distance, foot, inside, distance ahead, foot ahead; ends of arcs have nothing ahead."""
    x, y = arcs[k].real, arcs[k].imag
    ux, uy, wx, wy, left = 0.0, 0.0, 0.0, 0.0, True
    if not end:
        ux, uy = arcs[k + 1].real - x, arcs[k + 1].imag - y
        wx, wy = arcs[k - 1].real - x, arcs[k - 1].imag - y
        left = ux * wy - uy * wx > 0.0
    least, ahead = np.inf, np.inf
    near, near_ahead = 0.0j, 0.0j
    inside = False
    bx, by = arcs[stop - 1].real, arcs[stop - 1].imag
    for s in range(start, stop):
        ax, ay = bx, by
        bx, by = arcs[s].real, arcs[s].imag
        if (ay > y) != (by > y) and x < ax + (y - ay) * (bx - ax) / (by - ay):
            inside = not inside
        if s == start:
            continue  # the trunk's edge, which does not belong to the arc
        far = least if end else max(least, ahead)
        gap = max(max(min(ax, bx) - x, x - max(ax, bx)), 0.0)
        if gap * gap >= far:
            continue
        rise = max(max(min(ay, by) - y, y - max(ay, by)), 0.0)
        if gap * gap + rise * rise >= far:
            continue
        ex, ey = bx - ax, by - ay
        length = ex * ex + ey * ey
        t = 0.0
        if length > 0.0:
            t = min(1.0, max(0.0, ((x - ax) * ex + (y - ay) * ey) / length))
        px, py = ax + t * ex, ay + t * ey
        dx, dy = px - x, py - y
        square = dx * dx + dy * dy
        if square < least:
            least, near = square, complex(px, py)
        if not end and square < ahead:
            # Is the nearest point in the sector of the vertex's own piece, from the next edge to the one before?
            after_u, before_w = ux * dy - uy * dx > 0.0, dx * wy - dy * wx > 0.0
            if not ((after_u and before_w) if left else (after_u or before_w)):
                ahead, near_ahead = square, complex(px, py)
    return np.sqrt(least), near, inside, np.sqrt(ahead), near_ahead


def warm() -> None:
    """Compile on two arcs of a square."""
    arcs = np.array([0.0, 0.5j, 1.0j, 1.0j, 1.0 + 0.5j, 0.0])
    offsets, owner = np.array([0, 3, 6], dtype=np.int64), np.array([0, 0, 0, 1, 1, 1], dtype=np.int64)
    fixed = np.array([True, False, True])
    solved(*factored(arcs[:3].copy(), fixed), fixed, np.zeros(3, dtype=np.complex128))
    tables = np.empty((6, 2)), np.empty((6, 2), np.complex128), np.empty((6, 2), np.bool_)
    meet(arcs, offsets, owner, -1, *tables, np.empty((6, 2)), np.empty((6, 2), np.complex128))
