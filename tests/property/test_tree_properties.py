"""Planar trees in a convex polygon: what makes them dissections."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from riot.geometry.polyline import interior_angles, signed_area
from riot.groundtruth.tree import PlanarTree, embed, path, random_tree, star, walk


def draw(seed: int, leaves: int, binary: bool) -> PlanarTree:
    return random_tree(np.random.default_rng(seed), leaves, binary=binary)


def degrees(tree: PlanarTree) -> list[int]:
    count = Counter(tree.parent)
    return [count[node] + (node != tree.root) for node in range(len(tree.parent))]


@given(st.integers(0, 1000), st.integers(3, 9), st.booleans())
@settings(max_examples=50)
def test_inner_nodes_branch_and_leaves_do_not(seed: int, leaves: int, binary: bool) -> None:
    tree = draw(seed, leaves, binary)
    node_degrees = degrees(tree)
    assert node_degrees[:leaves] == [1] * leaves
    assert min(node_degrees[leaves:]) >= 3
    if binary:
        assert set(node_degrees[leaves:]) == {3}
        assert len(tree.parent) == 2 * leaves - 2


@given(st.integers(0, 1000), st.integers(3, 9), st.booleans())
@settings(max_examples=50)
def test_every_arc_is_walked_once_on_each_side(seed: int, leaves: int, binary: bool) -> None:
    tree = draw(seed, leaves, binary)
    steps = Counter(step for leaf in range(leaves) for step in path(tree, leaf))
    assert set(steps.values()) == {1}
    assert set(steps) == {(arc, upwards) for arc in tree.arcs for upwards in (True, False)}


def test_all_shapes_of_trees_are_drawn() -> None:
    # Five leaves: one star, five contractions to two inner nodes, five binary trees.
    def splits(tree: PlanarTree) -> frozenset[frozenset[int]]:
        below: dict[int, set[int]] = {node: {node} if node < 5 else set() for node in range(len(tree.parent))}
        for leaf in range(5):
            node = tree.parent[leaf]
            while node >= 0:
                below[node].add(leaf)
                node = tree.parent[node]
        inner = [below[node] for node in tree.arcs if node >= 5]
        return frozenset(frozenset(s if len(s) == 2 else set(range(5)) - s) for s in inner)

    assert len({splits(draw(seed, 5, True)) for seed in range(200)}) == 5
    assert len({splits(draw(seed, 5, False)) for seed in range(400)}) == 11
    assert splits(star(5)) == frozenset()


@given(st.integers(0, 1000), st.integers(3, 9), st.booleans())
@settings(max_examples=40)
def test_embedded_regions_are_convex_and_tile_the_polygon(seed: int, leaves: int, binary: bool) -> None:
    rng = np.random.default_rng(seed)
    tree = random_tree(rng, leaves, binary=binary)
    angle = 2 * math.pi * (np.arange(leaves) + 0.6 * rng.random(leaves)) / leaves
    corners = np.stack([np.cos(angle), 0.7 * np.sin(angle)], axis=1)
    nodes = embed(tree, corners, 0.2 + rng.random(len(tree.parent)))
    curves = {k: nodes[[k, tree.parent[k]]] for k in tree.arcs}
    cells = [walk(tree, curves, leaf)[::-1] for leaf in range(leaves)]
    assert np.isclose(sum(map(signed_area, cells)), signed_area(corners), rtol=1e-12)
    for j, cell in enumerate(cells):
        assert np.array_equal(cell[[-1, 0]], corners[[j, (j + 1) % leaves]])
        assert signed_area(cell) > 0
        assert interior_angles(cell).max() <= math.pi + 1e-9
