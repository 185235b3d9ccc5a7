"""The arcs of an outline whose points move, swung into a trunk, with the derivatives by every point (theory §12; ours).

What `riot.kernels.change` does for an outline that stands still: the arcs part at the boundary points nearest to the
corners, are carried rigidly from the edges of one trunk to those of the other, and leave gaps and overlaps there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from riot.geometry.polyline import shifted
from riot.kernels.change import feet
from riot.kernels.pulls import ADDED, LOST, pulls
from riot.types import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class SwungArcs:
    """The arcs of one outline, swung.

    Parameters
    ----------
    points : (s, 2) float64
        Arc i from ``offsets[i]`` on: corner, foot, the outline's points to the next foot, that foot, next corner.
    offsets : (n + 1,) int64
    arc : (s,) int64
        The arc of each point.
    turns : (n, 2) float64
        Cosine and sine of the angle by which each arc is turned.
    feet : (n, 2) float64
        The outline's points nearest to the corners, before the arcs are swung.
    edges : (n,) int64
        The outline's edge with each foot.
    vertices : (s,) int64
        The outline's vertex of each point; −1 for a foot or corner.
    """

    points: FloatArray
    offsets: IntArray
    arc: IntArray
    turns: FloatArray
    feet: FloatArray
    edges: IntArray
    vertices: IntArray


def swing_arcs(outline: FloatArray, windows: IntArray, source: FloatArray, target: FloatArray) -> SwungArcs:
    """Swing the arcs of an outline (m, 2) from the edges of ``source`` (n, 2) onto those of ``target`` (n, 2).

    ``windows`` as `riot.kernels.change.feet` reads them.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> windows = np.array([[3, 1], [0, 2], [1, 3], [2, 0]])
    >>> arcs = swing_arcs(square, windows, square, square)
    >>> arcs.points[arcs.offsets[0] : arcs.offsets[1]][[0, 1, -2, -1]].tolist()  # corner, foot, foot, corner
    [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [1.0, 0.0]]
    """
    m, n = len(outline), len(source)
    on, edges = feet(outline, windows, source)
    counts = (np.concatenate([edges[1:], edges[:1]]) - edges) % m
    offsets = np.zeros(n + 1, dtype=np.int64)
    np.cumsum(counts + 4, out=offsets[1:])
    arc = np.repeat(np.arange(n), counts + 4)
    number = np.arange(offsets[-1]) - offsets[arc]
    vertices = (edges[arc] + number - 1) % m
    first, last = offsets[:-1], offsets[1:] - 1
    vertices[first] = vertices[first + 1] = vertices[last - 1] = vertices[last] = -1
    local = outline[vertices]
    local[first], local[first + 1] = source, on
    local[last - 1], local[last] = shifted(on, 1), shifted(source, 1)
    turns = _turns(source, target)
    local -= source[arc]
    points = target[arc] + _turned(turns[arc], local)
    points[first], points[last] = target, shifted(target, 1)
    return SwungArcs(points, offsets, arc, turns, on, edges, vertices)


def areas_of(arcs: SwungArcs, lines: int) -> tuple[FloatArray, FloatArray]:
    """Areas lost and added, (2,), and their gradients by the arcs' points, (2, s, 2), by so many scanlines.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> windows = np.array([[3, 1], [0, 2], [1, 3], [2, 0]])
    >>> areas, _ = areas_of(swing_arcs(square, windows, square, square), 8)
    >>> areas.tolist()  # all that the trunk has is added
    [0.0, 1.0]
    """
    y = arcs.points[:, 1]
    low = float(y.min())
    return pulls(arcs.points, arcs.offsets, low, (float(y.max()) - low) / lines, lines)


def iou_gradient(areas: FloatArray, gradients: FloatArray, area: float) -> tuple[float, FloatArray, float]:
    """IoU of what is constructed with an outline of ``area``; its gradient by the arcs' points (s, 2) and by the area.

    >>> iou, _, _ = iou_gradient(np.array([0.1, 0.2]), np.zeros((2, 1, 2)), 1.0)
    >>> iou
    0.75
    """
    whole = area + float(areas[ADDED])
    iou = (area - float(areas[LOST])) / whole
    return iou, -(gradients[LOST] + iou * gradients[ADDED]) / whole, (1.0 - iou) / whole


def swung_back(
    arcs: SwungArcs, gradient: FloatArray, outline: FloatArray, source: FloatArray, target: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A gradient by the arcs' points (s, 2) as gradients by outline (m, 2), ``source`` (n, 2) and ``target`` (n, 2).

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> windows = np.array([[3, 1], [0, 2], [1, 3], [2, 0]])
    >>> arcs = swing_arcs(square, windows, square, square)
    >>> by_outline, _, by_target = swung_back(arcs, np.ones_like(arcs.points), square, square, square)
    >>> by_outline.shape, by_target.shape
    ((4, 2), (4, 2))
    """
    n, first, last = len(source), arcs.offsets[:-1], arcs.offsets[1:] - 1
    by_target = gradient[first] + shifted(gradient[last], -1)
    carried = gradient.copy()
    carried[first] = carried[last] = 0.0
    total = np.add.reduceat(carried, first)
    arm = arcs.points - target[arcs.arc]
    turning = np.add.reduceat(arm[:, 0] * carried[:, 1] - arm[:, 1] * carried[:, 0], first)
    local = _turned(arcs.turns[arcs.arc] * [1.0, -1.0], carried)
    by_source = -np.add.reduceat(local, first)
    by_target += total
    for corners, sums, sign in ((target, by_target, 1.0), (source, by_source, -1.0)):
        edge = shifted(corners, 1) - corners
        by_angle = sign * turning[:, None] * np.stack([-edge[:, 1], edge[:, 0]], axis=1)
        by_angle /= (edge * edge).sum(axis=1)[:, None]
        sums -= by_angle
        sums += shifted(by_angle, -1)
    by_outline = np.zeros_like(outline)
    own = arcs.vertices >= 0
    for axis in range(2):
        by_outline[:, axis] = np.bincount(arcs.vertices[own], local[own, axis], len(outline))
    by_foot = local[first + 1] + shifted(local[last - 1], -1)
    for i in range(n):
        _add_foot(i, arcs, by_foot[i], outline, source, by_outline, by_source)
    return by_outline, by_source, by_target


def _add_foot(
    i: int,
    arcs: SwungArcs,
    pull: FloatArray,
    outline: FloatArray,
    source: FloatArray,
    by_outline: FloatArray,
    by_source: FloatArray,
) -> None:
    """Add the gradient by a foot to those by the two ends of its edge and by the corner that it is nearest to."""
    start, stop = int(arcs.edges[i]), (int(arcs.edges[i]) + 1) % len(outline)
    edge = outline[stop] - outline[start]
    square = float(edge @ edge)
    share = float((arcs.feet[i] - outline[start]) @ edge) / square if square > 0.0 else 0.0
    slides = 0.0 < share < 1.0
    along = float(pull @ edge) / square if slides else 0.0
    off = source[i] - arcs.feet[i]
    by_outline[start] += (1.0 - share) * pull - along * ((1.0 - share) * edge + off)
    by_outline[stop] += share * pull + along * (off - share * edge)
    by_source[i] += along * edge


def _turns(source: FloatArray, target: FloatArray) -> FloatArray:
    u, w = shifted(source, 1) - source, shifted(target, 1) - target
    turns = np.stack([(w * u).sum(axis=1), w[:, 1] * u[:, 0] - w[:, 0] * u[:, 1]], axis=1)
    return np.asarray(turns / np.hypot(turns[:, 0], turns[:, 1])[:, None])


def _turned(turns: FloatArray, vectors: FloatArray) -> FloatArray:
    """Vectors (k, 2) turned by angles of which cosine and sine are given."""
    cos, sin, x, y = turns[:, 0], turns[:, 1], vectors[:, 0], vectors[:, 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=1)
