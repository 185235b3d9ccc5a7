"""Which stretches of the swung arcs belong to which arc of the dissection tree, and how they correspond (theory §8).

A tree arc lies between two cells; each cell's swung arc has a stretch there, from the point that passes the junction
at one end to that at the other. The two stretches correspond monotonically, corners to corners and linearly between,
so that the average of two straight lines is a straight line. Ours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from riot.construction.tree import TreeArc, cell_walks, joined
from riot.geometry.polyline import simplify_open
from riot.kernels.matching import along, at, corresponding, merged, turnings
from riot.types import BoolArray, FloatArray, IntArray
from riot.units import L_C


@dataclass(frozen=True)
class DetailParameters:
    """The detail step (all ours); lengths in units of ``L_c``."""

    step: float = 1 / 300
    """Samples are at most this far apart."""
    feature: float = 0.002
    """Douglas–Peucker tolerance of the features of arcs, between which they correspond linearly."""
    snap: float = 0.02
    """A junction goes to corners of the arcs that pass it within this length."""
    reach: float = 0.1
    """Length over which a displacement dies out where the two arcs are far apart, so that it costs no area."""
    accuracy: tuple[float, ...] = (1.0, 0.1, 0.03, 0.015)
    """The same where they agree: the accuracy weight of positions is the inverse of its fourth power. The first that
    loses little enough is taken; the shorter, the more a junction's displacement bends straight lines."""
    agreement: float = 0.005
    """Arcs nearer to each other than this agree."""
    junction: float = 0.005
    """Junctions are moved at most this far from where the partition has them."""
    contract: float = 0.00375
    """Junctions with less tree than this between them are one: the partition cannot tell a cross from a short bar."""
    max_loss: float = 0.002
    """The area that changes hands against the middle lines, which lose least, may be this much more,"""
    max_share: float = 0.08
    """and by no more than this share of it."""
    clearance: float = 1e-6
    """Arcs that come closer than this cross."""
    lines: int = 256
    """Scanlines of the area that changes hands."""


LEAF = 0.02
"""Within this distance of a leaf, in units of ``L_c``, a tree arc neither turns back nor leaves the trunk."""

BAR = 4.0
"""So many times longer a bar is contracted where neither swung arc beside it has anything."""

COINCIDENT = 1e-7
"""Samples closer than this are one."""

OFF_EDGES = 0.003
"""The tree keeps this share of the distance from the nearest corner off the trunk's edges, and of ``L_c`` at most."""

CORNER = 0.35
"""A junction is at a corner of an arc that turns by more than this, radians."""

ALIKE = 1.0
"""And that turns as the tree does, but for this."""

OWN = 0.1
"""How much a corner's distance from the partition's junction counts against its distance from the arcs."""

AS_NEAR = 0.3
"""An arc's corner is as near as the arc if it is farther by less than this share of the snapping distance."""


@dataclass(frozen=True, eq=False)
class TreeMatch:
    """One tree with the arcs beside it, matched.

    ``tree`` are its arcs, close junctions made one; ``walks`` those around every cell; ``targets`` (k, 2) are the
    samples of all tree arcs, arc i from ``offsets[i]`` to ``offsets[i + 1]``, averages of
    the two ``sides`` (2, k, 2); ``positions`` (2, k) say where on the swung arcs of the smaller and the greater cell
    they are; ``which`` (k,) and ``known`` (k, 2) are the unknowns and the leaves as in `riot.kernels.detail.solved`;
    ``ends`` (c, 2) are the tree arcs' nodes, ``cornered`` the junctions where some swung arc has a corner.
    """

    tree: Sequence[TreeArc]
    walks: Sequence[Sequence[tuple[int, bool]]]
    targets: FloatArray
    sides: FloatArray
    positions: FloatArray
    offsets: IntArray
    which: IntArray
    known: FloatArray
    ends: IntArray
    cornered: frozenset[int]

    @property
    def fixed(self) -> BoolArray:
        """(k,) which samples are leaves."""
        return self.which < 0


def match_tree(tree: Sequence[TreeArc], arcs: Sequence[FloatArray], parameters: DetailParameters) -> TreeMatch:
    """Match the stretches of both arcs beside each tree arc; ``arcs[k]`` (s, 2) runs from corner k to corner k + 1."""
    step = parameters.step * L_C
    tree = _contracted(tree, len(arcs), parameters.contract * L_C, [True] * len(tree))
    walks = cell_walks(len(arcs), tree)
    lengths = [along(arc) for arc in arcs]
    marks = [_features(arc, parameters) for arc in arcs]
    stretches, cornered = _stretches(tree, walks, arcs, lengths, marks, parameters)
    empty = [
        max(abs(stop - start) for start, stop in (stretches[cell, k] for cell in arc.sides)) < 0.5 * step
        for k, arc in enumerate(tree)
    ]
    fewer = _contracted(tree, len(arcs), BAR * parameters.contract * L_C, empty)
    if len(fewer) < len(tree):
        tree, walks = fewer, cell_walks(len(arcs), fewer)
        stretches, cornered = _stretches(tree, walks, arcs, lengths, marks, parameters)
    n, corners = len(arcs), np.array([arc[0] for arc in arcs])
    parts: list[tuple[FloatArray, FloatArray, FloatArray, FloatArray]] = []
    for k, arc in enumerate(tree):
        cut = []
        for cell in arc.sides:
            start, stop = stretches[cell, k]
            cut.append(_cut(arcs[cell], lengths[cell], marks[cell], start, stop))
        (a, marks_a), (b, marks_b) = cut
        u, v = merged(a, marks_a, b, marks_b, step)
        on_a, on_b = at(a, along(a), u), at(b, along(b), v)
        if np.hypot(*np.diff(0.5 * (on_a + on_b), axis=0).T).sum() < 0.5 * step:
            # Neither arc has anything here: the tree's own line keeps its junctions apart.
            u, v = np.zeros(len(arc.points)), np.zeros(len(arc.points))
            on_a = on_b = arc.points
        mean = 0.5 * (on_a + on_b)
        once = _distinct(mean)
        for leaf, order in ((arc.start, 1), (arc.end, -1)):
            if leaf < n:
                once[::order] &= _straight(mean[::order], corners, leaf)
        from_a, from_b = stretches[arc.sides[0], k], stretches[arc.sides[1], k]
        parts.append(
            (
                on_a[once],
                on_b[once],
                from_a[0] + np.sign(from_a[1] - from_a[0]) * u[once],
                from_b[0] + np.sign(from_b[1] - from_b[0]) * v[once],
            )
        )
    offsets = np.concatenate([[0], np.cumsum([len(part[0]) for part in parts])]).astype(np.int64)
    sides = np.stack([np.concatenate([part[s] for part in parts]) for s in (0, 1)])
    positions = np.stack([np.concatenate([part[s] for part in parts]) for s in (2, 3)])
    which, known, ends = _unknowns(tree, offsets, corners)
    return TreeMatch(tree, walks, 0.5 * (sides[0] + sides[1]), sides, positions, offsets, which, known, ends, cornered)


def _contracted(tree: Sequence[TreeArc], n: int, least: float, may: Sequence[bool]) -> list[TreeArc]:
    """The tree without arcs shorter than ``least`` between junctions, where it ``may``: these become one, in their
    middle."""
    name = {node: node for arc in tree for node in (arc.start, arc.end)}
    place = {node: arc.points[end] for arc in tree for node, end in ((arc.start, 0), (arc.end, -1))}
    gone = set()
    for k, arc in enumerate(tree):
        if may[k] and min(arc.start, arc.end) >= n and along(arc.points)[-1] < least:
            gone.add(k)
            kept, lost = name[arc.start], name[arc.end]
            name = {node: kept if now == lost else now for node, now in name.items()}
    middle = {
        now: np.mean([place[node] for node, other in name.items() if other == now], axis=0) for now in name.values()
    }
    found = []
    for k, arc in enumerate(tree):
        if k not in gone:
            points = arc.points.copy()
            points[0], points[-1] = middle[name[arc.start]], middle[name[arc.end]]
            found.append(TreeArc(name[arc.start], name[arc.end], arc.sides, points))
    return found


def _distinct(points: FloatArray) -> BoolArray:
    """(k,) which points to keep so that none coincides with the one before; both ends are kept."""
    keep = np.concatenate([[True], np.hypot(*np.diff(points, axis=0).T) > COINCIDENT])
    if not keep[-1]:
        keep[np.flatnonzero(keep)[-1]] = False
    keep[[0, -1]] = True
    return keep


def _straight(points: FloatArray, corners: FloatArray, leaf: int) -> BoolArray:
    """(k,) which points of an arc (k, 2) from a leaf of the trunk to keep: near it none that the arc passes before
    something nearer, and none from which the trunk's edges are hardly farther than the leaf's own share."""
    far = np.hypot(*(points - points[0]).T)
    near = far < LEAF * L_C
    ahead = np.minimum.accumulate(far[::-1])[::-1]
    keep = ~near | (far <= ahead)
    for k in (leaf, leaf - 1):
        edge = corners[(k + 1) % len(corners)] - corners[k]
        offset = points - points[0]
        height = (edge[0] * offset[:, 1] - edge[1] * offset[:, 0]) / np.hypot(*edge)
        keep &= ~near | (height > 1.5 * OFF_EDGES * far)
    keep[[0, -1]] = True
    return np.asarray(keep)


def _features(arc: FloatArray, parameters: DetailParameters) -> FloatArray:
    """(s,) turning at the features of an arc, 0 at its other vertices."""
    marks = np.zeros(len(arc))
    kept = simplify_open(arc, parameters.feature * L_C)
    # A feature that turns little is one all the same.
    found = turnings(arc, 2.0 * parameters.step * L_C)[kept]
    marks[kept] = np.where(found == 0.0, 1e-9, found)
    marks[[0, -1]] = 0.0
    return marks


def _stretches(
    tree: Sequence[TreeArc],
    walks: Sequence[Sequence[tuple[int, bool]]],
    arcs: Sequence[FloatArray],
    lengths: Sequence[FloatArray],
    marks: Sequence[FloatArray],
    parameters: DetailParameters,
) -> tuple[dict[tuple[int, int], tuple[float, float]], frozenset[int]]:
    """(cell, tree arc) → where on the cell's swung arc the tree arc starts and where it ends; junctions at corners."""
    step, snap = parameters.step * L_C, parameters.snap * L_C
    points = [arc.points for arc in tree]
    passing: dict[int, dict[int, float]] = {}
    corners_of: dict[tuple[int, int], list[tuple[float, FloatArray]]] = {}
    for cell, walk in enumerate(walks):
        path = joined(points, walk)
        stops = np.cumsum([along(points[k])[-1] for k, _ in walk])[:-1]
        nodes = [tree[k].end if forwards else tree[k].start for k, forwards in walk][:-1]
        places = corresponding(path, stops, arcs[cell], step)
        turns = turnings(path, 4.0 * step)[np.cumsum([len(points[k]) - 1 for k, _ in walk])[:-1]]
        corners = np.abs(marks[cell]) > CORNER
        for node, place, turn in zip(nodes, places.tolist(), turns.tolist(), strict=True):
            passing.setdefault(node, {})[cell] = place
            near = np.abs(lengths[cell] - place) < snap
            fitting = np.flatnonzero(corners & near & (np.abs(marks[cell] - turn) < ALIKE))
            if len(fitting):
                corners_of[node, cell] = [(float(lengths[cell][k]), arcs[cell][k]) for k in fitting]
    own = {node: arc.points[end] for arc in tree for node, end in ((arc.start, 0), (arc.end, -1))}
    for node, where in passing.items():
        corners_here = {cell: corners_of.get((node, cell), []) for cell in where}
        if any(corners_here.values()):
            _agree(own[node], where, corners_here, arcs, lengths, snap)
    found: dict[tuple[int, int], tuple[float, float]] = {}
    for cell, walk in enumerate(walks):
        nodes = [tree[k].end if forwards else tree[k].start for k, forwards in walk][:-1]
        stops_on = np.array([0.0, *(passing[node][cell] for node in nodes), lengths[cell][-1]])
        stops_on = np.maximum.accumulate(stops_on)
        for (k, forwards), (start, stop) in zip(walk, pairwise(stops_on.tolist()), strict=True):
            found[cell, k] = (start, stop) if forwards else (stop, start)
    return found, frozenset(node for node, _ in corners_of)


def _agree(
    own: FloatArray,
    where: dict[int, float],
    corners: dict[int, list[tuple[float, FloatArray]]],
    arcs: Sequence[FloatArray],
    lengths: Sequence[FloatArray],
    snap: float,
) -> None:
    """Change ``where`` the arcs of several cells pass a junction, partitioned at ``own``: all at the same corner.

    That corner is meant which all arcs pass most nearly; an arc that has a corner there as near goes to it by that
    corner, others by their nearest point.
    """
    best, nearest = np.inf, dict[int, tuple[float, float]]()
    meant = own
    for corner in (corner for some in corners.values() for _, corner in some):
        found = {cell: _nearest(arcs[cell], lengths[cell], corner, place, snap) for cell, place in where.items()}
        score = sum(far for _, far in found.values()) + OWN * float(np.hypot(*(corner - own)))
        if score < best:
            best, nearest, meant = score, found, corner
    for cell, (place, far) in nearest.items():
        reach = far + AS_NEAR * snap
        distances = [float(np.hypot(*(corner - meant))) for _, corner in corners[cell]]
        where[cell] = place
        if distances and min(distances) <= reach:
            where[cell] = corners[cell][int(np.argmin(distances))][0]


def _nearest(
    arc: FloatArray, lengths: FloatArray, point: FloatArray, place: float, reach: float
) -> tuple[float, float]:
    """Position of the arc's point nearest to ``point``, within ``reach`` of ``place`` along it, and their distance."""
    low, high = max(place - reach, 0.0), min(place + reach, float(lengths[-1]))
    inside = lengths[(lengths > low) & (lengths < high)]
    stops = np.concatenate([[low], inside, [high]])
    at_stops = at(arc, lengths, stops)
    ahead = np.diff(at_stops, axis=0)
    square = (ahead**2).sum(axis=1)
    share = np.divide(((point - at_stops[:-1]) * ahead).sum(axis=1), square, out=np.zeros(len(ahead)), where=square > 0)
    share = share.clip(0.0, 1.0)
    far = ((at_stops[:-1] + share[:, None] * ahead - point) ** 2).sum(axis=1)
    best = int(far.argmin())
    return float(stops[best] + share[best] * (stops[best + 1] - stops[best])), float(np.sqrt(far[best]))


def _cut(
    arc: FloatArray, lengths: FloatArray, marks: FloatArray, start: float, stop: float
) -> tuple[FloatArray, FloatArray]:
    """The stretch of an arc from one position to another, backwards if need be, and its features."""
    low, high = min(start, stop), max(start, stop)
    inside = (lengths > low + 1e-12) & (lengths < high - 1e-12)
    ends = at(arc, lengths, np.array([low, high]))
    points = np.concatenate([ends[:1], arc[inside], ends[1:]])
    turned = np.concatenate([[0.0], marks[inside], [0.0]])
    return (points, turned) if start <= stop else (points[::-1].copy(), -turned[::-1])


def _unknowns(tree: Sequence[TreeArc], offsets: IntArray, corners: FloatArray) -> tuple[IntArray, FloatArray, IntArray]:
    which = np.full(offsets[-1], -1)
    known = np.zeros((offsets[-1], 2))
    size = 0
    for first, last in pairwise(offsets.tolist()):
        which[first + 1 : last - 1] = np.arange(size, size + last - first - 2)
        size += last - first - 2
    names: dict[int, int] = {}
    ends = np.array([[arc.start, arc.end] for arc in tree], dtype=np.int64)
    for k, arc in enumerate(tree):
        for node, place in ((arc.start, offsets[k]), (arc.end, offsets[k + 1] - 1)):
            if node < len(corners):
                known[place] = corners[node]
            else:
                which[place] = size + names.setdefault(node, len(names))
    return which, known, ends
