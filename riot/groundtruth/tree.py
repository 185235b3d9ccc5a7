"""Planar trees whose leaves are a convex polygon's vertices: the dissections of a trunk (theory §1.2).

Each arc of such a tree borders two regions. Ours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from riot.types import FloatArray
from riot.units import L_C

_CURVE_SPACING = L_C / 120
"""Spacing of the points on curved arcs, unit-area frame."""

_LEAST_CURVE_POINTS = 5
"""Points of a curved arc, however short."""


@dataclass(frozen=True)
class PlanarTree:
    """A tree with its leaves in cyclic order.

    Nodes 0…leaves−1 are the leaves, in the order of the polygon's vertices; the others are inner nodes, of degree
    three or more. ``parent[k]`` is the node above node k, −1 for the root. Arc k joins node k to its parent.
    """

    leaves: int
    parent: tuple[int, ...]

    @property
    def root(self) -> int:
        """The node without a parent; it has no arc."""
        return self.parent.index(-1)

    @property
    def arcs(self) -> tuple[int, ...]:
        """The arcs, each named by its lower node."""
        return tuple(k for k, above in enumerate(self.parent) if above >= 0)


def star(leaves: int) -> PlanarTree:
    """The tree with a single inner node.

    >>> star(3).arcs
    (0, 1, 2)
    """
    return PlanarTree(leaves, (leaves,) * leaves + (-1,))


def random_tree(rng: np.random.Generator, leaves: int, *, binary: bool) -> PlanarTree:
    """A tree by random splits of the cyclic order: every inner node of degree three if ``binary``, else any.

    >>> random_tree(np.random.default_rng(0), 4, binary=True).leaves
    4
    """
    parent = [-1] * (leaves + 1)

    def split(run: list[int], node: int, least: int) -> None:
        branches = least if binary else least + int(rng.random() * (len(run) - least + 1))
        # `branches − 1` different cuts among the len(run) − 1 gaps between neighbours.
        cuts = np.sort(np.argsort(rng.random(len(run) - 1))[: branches - 1]) + 1
        bounds = [0, *cuts.tolist(), len(run)]
        for start, stop in pairwise(bounds):
            if stop - start == 1:
                parent[run[start]] = node
            else:
                parent.append(node)
                split(run[start:stop], len(parent) - 1, 2)

    first = int(rng.random() * leaves)
    split([(first + k) % leaves for k in range(leaves)], leaves, 3)
    return PlanarTree(leaves, tuple(parent))


def path(tree: PlanarTree, leaf: int) -> list[tuple[int, bool]]:
    """Arcs from a leaf to the next one, each with True if it runs upwards (from node to parent).

    >>> path(star(3), 0)
    [(0, True), (1, False)]
    """

    def climb(node: int) -> list[int]:
        nodes = [node]
        while tree.parent[nodes[-1]] >= 0:
            nodes.append(tree.parent[nodes[-1]])
        return nodes

    up, down = climb(leaf), climb((leaf + 1) % tree.leaves)
    while len(up) > 1 and len(down) > 1 and up[-2] == down[-2]:
        up.pop()
        down.pop()
    return [(node, True) for node in up[:-1]] + [(node, False) for node in reversed(down[:-1])]


def embed(tree: PlanarTree, corners: FloatArray, weights: FloatArray) -> FloatArray:
    """Positions, (nodes, 2): leaves at the convex polygon's ``corners``, (leaves, 2), inner nodes in equilibrium.

    Every arc k is a spring of stiffness ``weights[k]`` > 0. Tree and polygon together are a 3-connected planar
    graph, so by Tutte's theorem the straight arcs do not cross and every region between them is convex.

    >>> embed(star(3), np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]]), np.ones(4))[3].round(6)
    array([1., 1.])
    """
    n, nodes = tree.leaves, len(tree.parent)
    matrix, right = np.zeros((nodes, nodes)), np.zeros((nodes, 2))
    for child in tree.arcs:
        above = tree.parent[child]
        matrix[child, child] += weights[child]
        matrix[above, above] += weights[child]
        matrix[child, above] -= weights[child]
        matrix[above, child] -= weights[child]
    right[n:] = -matrix[n:, :n] @ corners
    return np.concatenate([corners, np.linalg.solve(matrix[n:, n:], right[n:])])


def walk(tree: PlanarTree, curves: dict[int, FloatArray], leaf: int) -> FloatArray:
    """Points, (k, 2), of the path from a leaf to the next along the tree, both leaves included.

    ``curves[k]`` is arc k as a polyline from node k to its parent.

    >>> corners, middle = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), np.array([0.3, 0.3])
    >>> walk(star(3), {k: np.array([corners[k], middle]) for k in range(3)}, 0).tolist()
    [[0.0, 0.0], [0.3, 0.3], [1.0, 0.0]]
    """
    pieces = [curves[arc] if upwards else curves[arc][::-1] for arc, upwards in path(tree, leaf)]
    return np.concatenate([pieces[0], *(piece[1:] for piece in pieces[1:])])


def curve(rng: np.random.Generator, start: FloatArray, end: FloatArray, bend: float) -> FloatArray:
    """A polyline, (k, 2), from start to end: straight if ``bend`` is 0, else with three waves of about bend × length.

    >>> len(curve(np.random.default_rng(0), np.zeros(2), np.ones(2), bend=0.3))
    49
    """
    if bend == 0.0:
        return np.array([start, end])
    along = end - start
    t = np.linspace(0.0, 1.0, max(_LEAST_CURVE_POINTS, math.ceil(float(np.hypot(*along)) / _CURVE_SPACING) + 1))
    waves = 2.0 * (rng.random(3) - 0.5) / [1.0, 2.0, 4.0]
    height = bend * sum(a * np.sin((k + 1) * math.pi * t) for k, a in enumerate(waves))
    points = start + t[:, None] * along + height[:, None] * np.array([-along[1], along[0]])
    points[0], points[-1] = start, end
    return np.asarray(points)
