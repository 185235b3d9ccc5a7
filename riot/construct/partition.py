"""Cells of a trunk: every point goes to the exterior piece of smallest signed distance (theory §8, ours).

Overlaps are split along their middle line, gaps are shared out along theirs. Cells must be connected and keep their
trunk edge: what is cut off from its edge is flooded by its neighbours, and too much of that is a rejected
construction.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from riot.construct.mesh import Mesh
from riot.errors import ConstructionError
from riot.parameters import ConstructParameters
from riot.shape import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Cells:
    """A labelled mesh: ``labels`` (k,) the cell of every mesh point, ``distances`` (k, n) to every piece."""

    mesh: Mesh
    labels: IntArray
    distances: FloatArray


def label_cells(mesh: Mesh, distances: FloatArray, parameters: ConstructParameters) -> Cells:
    """Label every mesh point; ConstructionError if a cell falls apart or loses its edge by more than is allowed."""
    labels = distances.argmin(axis=1)
    boundary = len(mesh.edge)
    _check_contact(mesh, labels[:boundary], distances[:boundary], parameters.max_lost_contact)
    labels[:boundary] = mesh.edge
    links = _links(mesh)
    rooted = _rooted(mesh, labels, links)
    share = 0.0 if rooted.all() else float(_weights(mesh)[~rooted].sum())
    if share > parameters.max_cut_off:
        raise ConstructionError(
            "disconnected",
            f"pieces fall apart: {share:.3f} of the area is cut off from its trunk edge "
            f"(allowed {parameters.max_cut_off:g})",
        )
    return Cells(mesh, _flood(labels, rooted, distances, links), distances)


def _check_contact(mesh: Mesh, labels: IntArray, distances: FloatArray, allowed: float) -> None:
    rows = np.arange(len(labels))
    # An empty piece's arc is its edge: what other pieces do not cover by more than the mesh can show is not lost.
    won = distances[rows, labels] < distances[rows, mesh.edge] - 0.25 * mesh.spacing
    for k in range(len(mesh.corners)):
        on_edge = mesh.edge == k
        share = float(won[on_edge].mean())
        if share > allowed:
            raise ConstructionError(
                "lost-contact",
                f"other pieces cover {share:.0%} of trunk edge {k}, whose own piece must stay on it "
                f"(allowed {allowed:.0%})",
            )


def _links(mesh: Mesh) -> IntArray:
    """(3 t, 2) sides of all triangles; those between two triangles come twice."""
    a, b, c = mesh.triangles.T
    return np.stack([np.concatenate([a, b, c]), np.concatenate([b, c, a])], axis=1)


def _rooted(mesh: Mesh, labels: IntArray, links: IntArray) -> BoolArray:
    """Which points are connected, within their cell, to the cell's trunk edge."""
    same = links[labels[links[:, 0]] == labels[links[:, 1]]]
    size = len(labels)
    graph = coo_array((np.ones(len(same)), (same[:, 0], same[:, 1])), shape=(size, size))
    _, component = connected_components(graph, directed=False)
    return np.isin(component, component[: len(mesh.edge)])


def _weights(mesh: Mesh) -> FloatArray:
    """(k,) a third of the area of the triangles around every point."""
    corners = mesh.points[mesh.triangles]
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = 0.5 * np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    thirds = np.repeat(areas / 3.0, 3)
    return np.bincount(mesh.triangles.ravel(), weights=thirds, minlength=len(mesh.points)).astype(np.float64)


def _flood(labels: IntArray, rooted: BoolArray, distances: FloatArray, links: IntArray) -> IntArray:
    """Give the points that are not rooted to neighbouring cells, nearest piece first."""
    labels = labels.copy()
    if rooted.all():
        return labels
    both = np.concatenate([links, links[:, ::-1]])
    both = both[~rooted[both[:, 1]]]
    neighbours: dict[int, list[int]] = {}
    for a, b in both.tolist():
        neighbours.setdefault(a, []).append(b)
    done = rooted.copy()
    heap = [
        (float(distances[b, labels[a]]), b, int(labels[a])) for a, row in neighbours.items() if rooted[a] for b in row
    ]
    heapq.heapify(heap)
    while heap:
        _, point, label = heapq.heappop(heap)
        if done[point]:
            continue
        done[point] = True
        labels[point] = label
        for after in neighbours.get(point, []):
            if not done[after]:
                heapq.heappush(heap, (float(distances[after, label]), after, label))
    return labels
