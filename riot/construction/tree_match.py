"""Match the sections of the two swung arcs beside each arc of the dissection tree (theory §8). Ours.

A tree arc lies between two cells; each cell's swung arc has a section there, from the point that passes the junction
at one end to that at the other. The two sections correspond monotonically, corners to corners and linearly between, so
that the average of two straight lines is a straight line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from riot.construction.junctions import SwungArc, cut_section, describe_arc, find_sections
from riot.construction.tree import TreeArc, Walk, cell_walks
from riot.construction.tuning import (
    COINCIDENT_SAMPLES,
    EDGE_CLEARANCE_SHARE,
    EMPTY_BAR_FACTOR,
    EMPTY_SHARE,
    LEAF_CLEARANCE_FACTOR,
    LEAF_RADIUS,
)
from riot.kernels.matching import along, at, merged
from riot.parameters import DetailParameters
from riot.types import BoolArray, FloatArray, IntArray
from riot.units import L_C


@dataclass(frozen=True, eq=False)
class TreeMatch:
    """The samples of a tree's arcs, with the points of the swung arcs beside them.

    Parameters
    ----------
    tree : sequence of TreeArc
        Close junctions are made one.
    walks : sequence of Walk
        The tree arcs around every cell.
    targets : (k, 2) float64
        Samples of all tree arcs, arc i from ``offsets[i]`` to ``offsets[i + 1]``: averages of the two ``sides``.
    sides : (2, k, 2) float64
        The corresponding points of the swung arcs of the smaller and of the greater cell.
    positions : (2, k) float64
        Where on those swung arcs they are.
    offsets : (a + 1,) int64
    which : (k,) int64
    known : (k, 2) float64
        The unknowns and the leaves, as `riot.kernels.detail.solved` reads them.
    ends : (a, 2) int64
        The nodes at the ends of the tree arcs.
    cornered : frozenset of int
        The junctions where some swung arc has a corner.
    """

    tree: Sequence[TreeArc]
    walks: Sequence[Walk]
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
    """Match the sections of both swung arcs beside each tree arc.

    ``arcs[k]`` (s, 2) runs from corner k of the trunk to corner k + 1.
    """
    step = parameters.step * L_C
    tree = _contracted(tree, len(arcs), parameters.contract * L_C, [True] * len(tree))
    walks = cell_walks(len(arcs), tree)
    swung = [describe_arc(arc, parameters) for arc in arcs]
    sections, cornered = find_sections(tree, walks, swung, parameters)
    empty = [
        max(abs(stop - start) for start, stop in (sections[cell, k] for cell in arc.sides)) < EMPTY_SHARE * step
        for k, arc in enumerate(tree)
    ]
    fewer = _contracted(tree, len(arcs), EMPTY_BAR_FACTOR * parameters.contract * L_C, empty)
    if len(fewer) < len(tree):
        tree, walks = fewer, cell_walks(len(arcs), fewer)
        sections, cornered = find_sections(tree, walks, swung, parameters)
    corners = np.array([arc[0] for arc in arcs])
    samples = [
        _matched(arc, [swung[cell] for cell in arc.sides], [sections[cell, k] for cell in arc.sides], corners, step)
        for k, arc in enumerate(tree)
    ]
    offsets = np.concatenate([[0], np.cumsum([sides.shape[1] for sides, _ in samples])]).astype(np.int64)
    sides = np.concatenate([sides for sides, _ in samples], axis=1)
    positions = np.concatenate([positions for _, positions in samples], axis=1)
    which, known, ends = _unknowns(tree, offsets, corners)
    return TreeMatch(tree, walks, 0.5 * (sides[0] + sides[1]), sides, positions, offsets, which, known, ends, cornered)


def _matched(
    arc: TreeArc,
    swung: Sequence[SwungArc],
    sections: Sequence[tuple[float, float]],
    corners: FloatArray,
    step: float,
) -> tuple[FloatArray, FloatArray]:
    """Corresponding points (2, k, 2) on the two swung arcs beside a tree arc, and their positions (2, k)."""
    (a, turns_a), (b, turns_b) = (
        cut_section(arc_beside, *section) for arc_beside, section in zip(swung, sections, strict=True)
    )
    u, v = merged(a, turns_a, b, turns_b, step)
    on_a, on_b = at(a, along(a), u), at(b, along(b), v)
    if np.hypot(*np.diff(0.5 * (on_a + on_b), axis=0).T).sum() < EMPTY_SHARE * step:
        # Neither arc has anything here: the tree's own line keeps its junctions apart.
        u, v = np.zeros(len(arc.points)), np.zeros(len(arc.points))
        on_a = on_b = arc.points
    mean = 0.5 * (on_a + on_b)
    keep = _distinct(mean)
    for leaf, order in ((arc.start, 1), (arc.end, -1)):
        if leaf < len(corners):
            keep[::order] &= _straight(mean[::order], corners, leaf)
    positions = [
        start + np.sign(stop - start) * distance[keep] for (start, stop), distance in zip(sections, (u, v), strict=True)
    ]
    return np.stack([on_a[keep], on_b[keep]]), np.stack(positions)


def _contracted(tree: Sequence[TreeArc], n: int, least: float, may: Sequence[bool]) -> list[TreeArc]:
    """The tree without arcs shorter than ``least`` between two junctions, which become one in their middle.

    Only arcs that ``may`` go are left out; ``n`` is the number of the trunk's corners.
    """
    name = {node: node for arc in tree for node in (arc.start, arc.end)}
    point = {node: arc.points[end] for arc in tree for node, end in ((arc.start, 0), (arc.end, -1))}
    gone = set()
    for k, arc in enumerate(tree):
        if may[k] and min(arc.start, arc.end) >= n and along(arc.points)[-1] < least:
            gone.add(k)
            kept, lost = name[arc.start], name[arc.end]
            name = {node: kept if now == lost else now for node, now in name.items()}
    middle = {
        now: np.mean([point[node] for node, other in name.items() if other == now], axis=0) for now in name.values()
    }
    contracted = []
    for k, arc in enumerate(tree):
        if k not in gone:
            points = arc.points.copy()
            points[0], points[-1] = middle[name[arc.start]], middle[name[arc.end]]
            contracted.append(TreeArc(name[arc.start], name[arc.end], arc.sides, points))
    return contracted


def _distinct(points: FloatArray) -> BoolArray:
    """(k,) which points to keep so that none coincides with the one before; both ends are kept."""
    keep = np.concatenate([[True], np.hypot(*np.diff(points, axis=0).T) > COINCIDENT_SAMPLES])
    if not keep[-1]:
        keep[np.flatnonzero(keep)[-1]] = False
    keep[[0, -1]] = True
    return keep


def _straight(points: FloatArray, corners: FloatArray, leaf: int) -> BoolArray:
    """(k,) which points to keep of an arc (k, 2) that starts at a leaf of the trunk.

    Near the leaf no point stays that the arc passes before it comes nearer again, and none that hardly keeps the
    leaf's clearance from the trunk's edges.
    """
    distance = np.hypot(*(points - points[0]).T)
    near = distance < LEAF_RADIUS * L_C
    nearest_ahead = np.minimum.accumulate(distance[::-1])[::-1]
    keep = ~near | (distance <= nearest_ahead)
    for k in (leaf, leaf - 1):
        edge = corners[(k + 1) % len(corners)] - corners[k]
        offset = points - points[0]
        height = (edge[0] * offset[:, 1] - edge[1] * offset[:, 0]) / np.hypot(*edge)
        keep &= ~near | (height > LEAF_CLEARANCE_FACTOR * EDGE_CLEARANCE_SHARE * distance)
    keep[[0, -1]] = True
    return np.asarray(keep)


def _unknowns(tree: Sequence[TreeArc], offsets: IntArray, corners: FloatArray) -> tuple[IntArray, FloatArray, IntArray]:
    """``which``, ``known`` and ``ends`` of `TreeMatch`: first the unknowns within the arcs, then the junctions."""
    which = np.full(offsets[-1], -1)
    known = np.zeros((offsets[-1], 2))
    size = 0
    for first, last in pairwise(offsets.tolist()):
        which[first + 1 : last - 1] = np.arange(size, size + last - first - 2)
        size += last - first - 2
    names: dict[int, int] = {}
    ends = np.array([[arc.start, arc.end] for arc in tree], dtype=np.int64)
    for k, arc in enumerate(tree):
        for node, row in ((arc.start, offsets[k]), (arc.end, offsets[k + 1] - 1)):
            if node < len(corners):
                known[row] = corners[node]
            else:
                which[row] = size + names.setdefault(node, len(names))
    return which, known, ends
