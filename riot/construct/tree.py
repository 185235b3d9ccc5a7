"""The dissection tree: boundaries between the cells of a trunk, and the path around each cell (theory §1.2, §8)."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from riot.construct.partition import Cells
from riot.errors import ConstructionError
from riot.polyline import simplify_open
from riot.shape import FloatArray

Node = tuple[int, ...]
"""A mesh edge (two points, smaller first) that the boundary crosses, a triangle (three) where three cells meet, or a
corner of the trunk (one)."""

CORNER_SHARE = 0.1
"""Where a third piece covers a corner of the trunk, the cells of the two edges that meet there keep this share of the
mesh edges around it."""


COINCIDENT = 1e-9
"""Nodes closer than this are one point."""


@dataclass(frozen=True, eq=False)
class TreeArc:
    """A stretch of the tree between two junctions or leaves, with one cell on either side.

    ``points`` (k, 2) from node ``start`` to node ``end``; ``sides`` are the two cells, smaller first.
    """

    start: Node
    end: Node
    sides: tuple[int, int]
    points: FloatArray


def dissection_tree(cells: Cells, tolerance: float) -> list[TreeArc]:
    """The arcs between the cells, simplified by Douglas–Peucker with ``tolerance``, each once."""
    places, links = _boundary_graph(cells)
    return [
        TreeArc(chain[0], chain[-1], sides, _simplified(places, chain, tolerance)) for chain, sides in _chains(links)
    ]


def cell_paths(cells: Cells, arcs: list[TreeArc]) -> list[FloatArray]:
    """For every trunk edge k, the tree's path from corner k to corner k + 1, (l, 2): the boundary of cell k."""
    corners = cells.mesh.corners
    n = len(corners)
    at_cell: dict[int, dict[Node, list[TreeArc]]] = defaultdict(lambda: defaultdict(list))
    for arc in arcs:
        for cell in arc.sides:
            at_cell[cell][arc.start].append(arc)
            at_cell[cell][arc.end].append(arc)
    paths = []
    for k in range(n):
        first, last = (int(corners[k]),), (int(corners[(k + 1) % n]),)
        paths.append(_walk(at_cell[k], first, last, k))
    return paths


def _walk(around: dict[Node, list[TreeArc]], first: Node, last: Node, cell: int) -> FloatArray:
    parts: list[FloatArray] = []
    node, used = first, set[int]()
    while node != last:
        onward = [arc for arc in around.get(node, []) if id(arc) not in used]
        if len(onward) != 1:
            raise ConstructionError("not-a-tree", f"the boundary of cell {cell} is not one path between its corners")
        arc = onward[0]
        used.add(id(arc))
        forwards = arc.start == node
        parts.append(arc.points if forwards else arc.points[::-1])
        node = arc.end if forwards else arc.start
    joined = [part if k == 0 else part[1:] for k, part in enumerate(parts)]
    return np.concatenate(joined)


def _boundary_graph(cells: Cells) -> tuple[dict[Node, FloatArray], dict[Node, list[tuple[Node, tuple[int, int]]]]]:
    """Where the nodes are, and how they are linked: (neighbour, the two cells beside the link)."""
    mesh, labels = cells.mesh, cells.labels
    n = len(mesh.corners)
    meeting = {int(corner): _pair((k - 1) % n, k) for k, corner in enumerate(mesh.corners)}
    corners = meeting.keys()
    places: dict[Node, FloatArray] = {}
    links: dict[Node, list[tuple[Node, tuple[int, int]]]] = defaultdict(list)

    def crossing(u: int, v: int) -> Node:
        u, v = min(u, v), max(u, v)
        corner = u if u in corners else v if v in corners else None
        if corner is not None and _pair(int(labels[u]), int(labels[v])) == meeting[corner]:
            # The boundary between the cells of the two edges that meet at a corner ends in the corner.
            places[(corner,)] = mesh.points[corner]
            return (corner,)
        if (u, v) not in places:
            places[(u, v)] = _equidistant(cells, u, v, 0.0 if corner is None else CORNER_SHARE)
        return (u, v)

    def link(a: Node, b: Node, sides: tuple[int, int]) -> None:
        if a != b:
            links[a].append((b, sides))
            links[b].append((a, sides))

    marks = labels[mesh.triangles]
    mixed = (marks != marks[:, :1]).any(axis=1)
    for triangle, mark in zip(mesh.triangles[mixed].tolist(), marks[mixed].tolist(), strict=True):
        cuts = [(k, (k + 1) % 3) for k in range(3) if mark[k] != mark[(k + 1) % 3]]
        nodes = [crossing(triangle[k], triangle[m]) for k, m in cuts]
        if len(cuts) == 2:
            link(nodes[0], nodes[1], _pair(*{mark[0], mark[1], mark[2]}))
            continue
        middle = tuple(sorted(triangle))
        places[middle] = np.mean([places[node] for node in nodes], axis=0)
        for (k, m), node in zip(cuts, nodes, strict=True):
            link(middle, node, _pair(mark[k], mark[m]))
    return places, links


def _pair(a: int, b: int) -> tuple[int, int]:
    return (a, b) if a < b else (b, a)


def _equidistant(cells: Cells, u: int, v: int, least: float) -> FloatArray:
    """Where on the mesh edge u–v the two cells' signed distances are equal, interpolated linearly.

    At least the share ``least`` of the edge from both ends.
    """
    a, b = cells.labels[u], cells.labels[v]
    at_u = cells.distances[u, b] - cells.distances[u, a]
    at_v = cells.distances[v, a] - cells.distances[v, b]
    # A point flooded or forced into a cell may lie nearer to the other piece: then the boundary keeps next to it.
    at_u, at_v = max(float(at_u), 0.0), max(float(at_v), 0.0)
    share = 0.5 if at_u + at_v == 0.0 else at_u / (at_u + at_v)
    share = min(max(share, least), 1.0 - least)
    place: FloatArray = cells.mesh.points[u] + share * (cells.mesh.points[v] - cells.mesh.points[u])
    return place


def _chains(
    links: dict[Node, list[tuple[Node, tuple[int, int]]]],
) -> list[tuple[list[Node], tuple[int, int]]]:
    """Runs of nodes between those where the boundary branches or ends, each once, with the cells beside."""
    ends = {node for node, around in links.items() if len(node) != 2}
    chains = []
    for node in sorted(ends):
        for after, sides in links[node]:
            chain = [node, after]
            while chain[-1] not in ends:
                onward = [other for other, _ in links[chain[-1]] if other != chain[-2]]
                if len(onward) != 1:
                    raise ConstructionError("not-a-tree", "a boundary between two cells breaks off")
                chain.append(onward[0])
            if chain[0] < chain[-1] or (chain[0] == chain[-1]):
                chains.append((chain, sides))
    return chains


def _simplified(places: dict[Node, FloatArray], chain: list[Node], tolerance: float) -> FloatArray:
    points = np.array([places[node] for node in chain])
    kept = [points[0]]
    for point in points[1:-1]:
        if min(np.hypot(*(point - kept[-1])), np.hypot(*(point - points[-1]))) > COINCIDENT:
            kept.append(point)
    kept.append(points[-1])
    chosen = np.array(kept)
    return chosen[simplify_open(chosen, tolerance)]
