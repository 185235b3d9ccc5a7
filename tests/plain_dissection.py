"""The partition and its tree the plain way: every distance, and Python's containers. The reference of the kernels."""

from __future__ import annotations

import heapq
from collections import defaultdict

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from riot.construction.mesh import Mesh
from riot.construction.tuning import COINCIDENT_NODES, CORNER_SHARE, INWARD_SHARE
from riot.geometry.polyline import simplify_open
from riot.kernels.options import kernel
from riot.types import BoolArray, FloatArray, IntArray

Node = tuple[int, ...]
"""A mesh edge (two points, smaller first) that the boundary crosses, a triangle (three) where three cells meet, or a
corner of the trunk (one)."""

Links = dict[Node, list[tuple[Node, tuple[int, int]]]]
"""(neighbour, the two cells beside the link) of every node."""


@kernel
def signed_distances(x: FloatArray, arcs: FloatArray, offsets: IntArray) -> FloatArray:
    """(k, n) distance of points (k, 2) to arc i, negative inside the region between the arc and its chord.

    ``arcs`` (s, 2) are the concatenated polylines, ``offsets`` (n + 1,) where each starts. The chord belongs to the
    region's parity, but not to what the distance is taken to: a region does not end at its trunk edge.
    """
    n = len(offsets) - 1
    distances = np.empty((len(x), n))
    for k in range(len(x)):
        px, py = x[k, 0], x[k, 1]
        for i in range(n):
            nearest = np.inf
            inside = False
            first, last = offsets[i], offsets[i + 1] - 1
            ax, ay = arcs[last, 0] - px, arcs[last, 1] - py
            for s in range(first, last + 1):
                bx, by = arcs[s, 0] - px, arcs[s, 1] - py
                ex, ey = bx - ax, by - ay
                if (ay > 0.0) != (by > 0.0) and ax - ay / ey * ex > 0.0:
                    inside = not inside
                if s > first:
                    square = ex * ex + ey * ey
                    u = 0.0 if square == 0.0 else -(ax * ex + ay * ey) / square
                    u = min(1.0, max(0.0, u))
                    dx, dy = ax + u * ex, ay + u * ey
                    nearest = min(nearest, dx * dx + dy * dy)
                ax, ay = bx, by
            distances[k, i] = -np.sqrt(nearest) if inside else np.sqrt(nearest)
    return distances


def plain_mesh(polygon: FloatArray, rings: int) -> FloatArray:
    """(k, 2) points of the ring mesh."""
    middle = polygon.mean(axis=0)
    spokes = polygon - middle
    onward = np.roll(spokes, -1, axis=0)
    points = []
    for r in range(rings, 0, -1):
        share = np.arange(r)[None, :, None]
        points.append((((r - share) * spokes[:, None] + share * onward[:, None]) / rings).reshape(-1, 2))
    placed: FloatArray = middle + np.concatenate([*points, np.zeros((1, 2))])
    placed[np.arange(len(polygon)) * rings] = polygon
    return placed


def plain_distances(mesh: Mesh, arcs: FloatArray, offsets: IntArray) -> FloatArray:
    """(k, n) of every mesh point to every piece."""
    first = int(np.argmin(((arcs[offsets[:-1]] - mesh.points[0]) ** 2).sum(axis=1)))
    order = (first + np.arange(len(mesh.corners))) % len(mesh.corners)
    inside = mesh.points + INWARD_SHARE * (mesh.points[-1] - mesh.points)
    distances: FloatArray = signed_distances(inside, arcs, offsets)[:, order]
    return distances


def plain_labels(mesh: Mesh, distances: FloatArray) -> IntArray:
    """(k,) the cell of every mesh point, whatever is lost or cut off."""
    labels = distances.argmin(axis=1)
    labels[: len(mesh.edge)] = mesh.edge
    a, b, c = mesh.triangles.T
    links = np.stack([np.concatenate([a, b, c]), np.concatenate([b, c, a])], axis=1)
    same = links[labels[links[:, 0]] == labels[links[:, 1]]]
    graph = coo_array((np.ones(len(same)), (same[:, 0], same[:, 1])), shape=(len(labels), len(labels)))
    _, component = connected_components(graph, directed=False)
    return _flood(labels, np.isin(component, component[: len(mesh.edge)]), distances, links)


def _flood(labels: IntArray, rooted: BoolArray, distances: FloatArray, links: IntArray) -> IntArray:
    both = np.concatenate([links, links[:, ::-1]])
    neighbours: dict[int, list[int]] = defaultdict(list)
    for a, b in both[~rooted[both[:, 1]]].tolist():
        neighbours[a].append(b)
    heap = [(distances[b, labels[a]], b, labels[a]) for a, row in neighbours.items() if rooted[a] for b in row]
    heapq.heapify(heap)
    done = rooted.copy()
    while heap:
        _, point, label = heapq.heappop(heap)
        if done[point]:
            continue
        done[point] = True
        labels[point] = label
        for after in neighbours.get(point, []):
            if not done[after]:
                heapq.heappush(heap, (distances[after, label], after, label))
    return labels


def plain_tree(
    mesh: Mesh, labels: IntArray, distances: FloatArray, tolerance: float
) -> list[tuple[tuple[int, int], FloatArray]]:
    """(the cells beside it, its points) of every arc of the dissection tree."""
    places, links = _boundary_graph(mesh, labels, distances)
    arcs = []
    for chain, sides in _chains(links):
        points = [places[chain[0]]]
        for node in chain[1:-1]:
            if min(np.hypot(*(places[node] - at)) for at in (points[-1], places[chain[-1]])) > COINCIDENT_NODES:
                points.append(places[node])
        kept = np.array([*points, places[chain[-1]]])
        arcs.append((sides, kept[simplify_open(kept, tolerance)]))
    return arcs


def _boundary_graph(mesh: Mesh, labels: IntArray, distances: FloatArray) -> tuple[dict[Node, FloatArray], Links]:
    n = len(mesh.corners)
    meeting = {int(corner): {(k - 1) % n, k} for k, corner in enumerate(mesh.corners)}
    places: dict[Node, FloatArray] = {}
    links: Links = defaultdict(list)

    def crossing(u: int, v: int) -> Node:
        u, v = min(u, v), max(u, v)
        corner = next((w for w in (u, v) if w in meeting), None)
        if corner is not None and {int(labels[u]), int(labels[v])} == meeting[corner]:
            places[(corner,)] = mesh.points[corner]
            return (corner,)
        a, b = labels[u], labels[v]
        at_u, at_v = max(distances[u, b] - distances[u, a], 0.0), max(distances[v, a] - distances[v, b], 0.0)
        share = 0.5 if at_u + at_v == 0.0 else at_u / (at_u + at_v)
        least = 0.0 if corner is None else CORNER_SHARE
        share = min(max(share, least), 1.0 - least)
        places[u, v] = mesh.points[u] + share * (mesh.points[v] - mesh.points[u])
        return (u, v)

    def link(first_node: Node, second_node: Node, marks: list[int]) -> None:
        if first_node != second_node:
            sides = (min(marks), max(marks))
            links[first_node].append((second_node, sides))
            links[second_node].append((first_node, sides))

    for triangle in mesh.triangles.tolist():
        marks = [int(labels[k]) for k in triangle]
        cuts = [(k, (k + 1) % 3) for k in range(3) if marks[k] != marks[(k + 1) % 3]]
        nodes = [crossing(triangle[k], triangle[m]) for k, m in cuts]
        if len(cuts) == 2:
            link(nodes[0], nodes[1], marks)
        elif len(cuts) == 3:
            middle = tuple(sorted(triangle))
            places[middle] = np.mean([places[node] for node in nodes], axis=0)
            for (k, m), node in zip(cuts, nodes, strict=True):
                link(middle, node, [marks[k], marks[m]])
    return places, links


def _chains(links: Links) -> list[tuple[list[Node], tuple[int, int]]]:
    """Runs of nodes between those where the boundary branches or ends, each from its smaller end."""
    chains = []
    for node in (node for node in links if len(node) != 2):
        for after, sides in links[node]:
            chain = [node, after]
            while len(chain[-1]) == 2:
                chain.append(next(other for other, _ in links[chain[-1]] if other != chain[-2]))
            if chain[0] <= chain[-1]:
                chains.append((chain, sides))
    return chains
