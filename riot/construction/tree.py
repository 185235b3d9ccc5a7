"""The dissection tree: boundaries between the cells of a trunk, and the path around each cell (theory §1.2, §8)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from riot.construction.partition import Cells
from riot.construction.tuning import COINCIDENT_NODES, CORNER_SHARE
from riot.errors import ConstructionError
from riot.geometry.polyline import simplify_open
from riot.kernels.dissection import chains
from riot.types import FloatArray

Walk = list[tuple[int, bool]]
"""Tree arcs one after another: which, and whether from start to end."""


@dataclass(frozen=True, eq=False)
class TreeArc:
    """A line of the tree between two junctions or leaves, with one cell on either side.

    ``points`` (k, 2) from node ``start`` to node ``end``: node k < n is corner k of the trunk, a leaf, the others are
    junctions. ``sides`` are the two cells, smaller first.
    """

    start: int
    end: int
    sides: tuple[int, int]
    points: FloatArray


def dissection_tree(cells: Cells, tolerance: float) -> list[TreeArc]:
    """The arcs between the cells, each once, simplified by Douglas–Peucker with ``tolerance`` (theory §8, ours).

    Raises ConstructionError ``not-a-tree`` if a boundary between two cells breaks off.
    """
    mesh = cells.mesh
    lines = chains(
        mesh.points, cells.mixed, cells.labels, cells.distances, mesh.corners, CORNER_SHARE, COINCIDENT_NODES
    )
    if not lines.whole:
        raise ConstructionError("not-a-tree", "a boundary between two cells breaks off")
    arcs = []
    for (start, end), (a, b), (first, last) in zip(
        lines.ends.tolist(), lines.sides.tolist(), pairwise(lines.offsets.tolist()), strict=True
    ):
        points = lines.points[first:last]
        arcs.append(TreeArc(start, end, (a, b), points[simplify_open(points, tolerance)]))
    return arcs


def cell_walks(n: int, arcs: Sequence[TreeArc]) -> list[Walk]:
    """For every edge k of a trunk of n, the tree arcs from corner k to corner k + 1.

    Raises ConstructionError ``not-a-tree`` if they are not one path.
    """
    return [_walk(arcs, k, (k + 1) % n) for k in range(n)]


def cell_paths(cells: Cells, arcs: Sequence[TreeArc]) -> list[FloatArray]:
    """For every trunk edge k, the tree's path from corner k to corner k + 1, (l, 2): the boundary of cell k."""
    points = [arc.points for arc in arcs]
    return [joined(points, walk) for walk in cell_walks(len(cells.mesh.corners), arcs)]


def joined(points: Sequence[FloatArray], walk: Walk) -> FloatArray:
    """(l, 2) the arcs with these ``points`` one after another, what they share once."""
    lines = [points[k] if forwards else points[k][::-1] for k, forwards in walk]
    return np.concatenate([line if k == 0 else line[1:] for k, line in enumerate(lines)])


def _walk(arcs: Sequence[TreeArc], cell: int, last: int) -> Walk:
    """The tree arcs around one cell, from its corner ``cell`` to corner ``last``."""
    walk: Walk = []
    node, left = cell, [k for k, arc in enumerate(arcs) if cell in arc.sides]
    while node != last:
        onward = [k for k in left if node in (arcs[k].start, arcs[k].end)]
        if len(onward) != 1:
            raise ConstructionError("not-a-tree", f"the boundary of cell {cell} is not one path between its corners")
        arc = arcs[onward[0]]
        left.remove(onward[0])
        forwards = arc.start == node
        walk.append((onward[0], forwards))
        node = arc.end if forwards else arc.start
    return walk
