"""The partition's kernels against the plain way of doing it."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_dissection import plain_distances, plain_labels, plain_mesh, plain_tree

from riot.construction.mesh import mesh_convex
from riot.construction.partition import label_cells
from riot.construction.tree import dissection_tree
from riot.kernels.cells import rooted, weights
from riot.parameters import ConstructParameters
from riot.types import FloatArray, IntArray

ANYTHING = dataclasses.replace(ConstructParameters(), max_cut_off=1.0, max_lost_contact=1.0)
"""Parameters with which nothing is rejected."""


def polygon_and_arcs(seed: int, n: int, depth: float) -> tuple[FloatArray, FloatArray, IntArray]:
    """A convex polygon (n, 2) and a wavy arc on every edge, into it and out of it, as deep as ``depth``; concatenated,
    the first on any edge."""
    rng = np.random.default_rng(seed)
    angle = 2.0 * math.pi * (np.arange(n) + rng.uniform(-0.25, 0.25, n)) / n
    polygon = np.stack([np.cos(angle), np.sin(angle)], axis=1) * rng.uniform(0.45, 0.6)
    arcs = []
    for k in range(n):
        k = (k + seed) % n
        start, stop = polygon[k], polygon[(k + 1) % n]
        share = np.linspace(0.0, 1.0, int(rng.integers(2, 60)))
        wave = np.sum([rng.normal() / m * np.sin(math.pi * m * share) for m in range(1, 6)], axis=0)
        normal = np.array([start[1] - stop[1], stop[0] - start[0]])
        arc = start + share[:, None] * (stop - start) + depth * wave[:, None] * normal
        arc[-1] = stop
        arcs.append(arc)
    offsets = np.cumsum([0, *(len(arc) for arc in arcs)]).astype(np.int64)
    return polygon, np.concatenate(arcs), offsets


CASES = given(st.integers(0, 10_000), st.integers(3, 8), st.sampled_from([0.0, 0.1, 0.3, 1.0]))


@given(st.integers(0, 10_000), st.integers(3, 8), st.sampled_from([0.2, 0.05, 0.02]))
@settings(max_examples=15)
def test_mesh_is_the_plain_one(seed: int, n: int, spacing: float) -> None:
    polygon = polygon_and_arcs(seed, n, 0.0)[0]
    mesh = mesh_convex(polygon, spacing)
    assert np.array_equal(mesh.points, plain_mesh(polygon, mesh.rings))
    triangles = shapely.polygons(mesh.points[mesh.triangles])
    assert shapely.is_ccw(shapely.get_exterior_ring(triangles)).all()
    areas = np.repeat(shapely.area(triangles), 3) / 3.0
    assert weights(mesh.points, mesh.triangles) == pytest.approx(
        np.bincount(mesh.triangles.ravel(), weights=areas), abs=1e-12
    )


@CASES
@settings(max_examples=40)
def test_labels_and_distances_are_those_of_all_distances(seed: int, n: int, depth: float) -> None:
    polygon, arcs, offsets = polygon_and_arcs(seed, n, depth)
    mesh = mesh_convex(polygon, 0.02)
    cells = label_cells(mesh, arcs, offsets, ANYTHING)
    distances = plain_distances(mesh, arcs, offsets)
    known = ~np.isnan(cells.distances)
    assert np.array_equal(cells.distances[known], distances[known])
    assert np.array_equal(cells.labels, plain_labels(mesh, distances))
    marks = cells.labels[mesh.triangles]
    mixed = (marks != marks[:, :1]).any(axis=1)
    assert np.array_equal(cells.mixed, mesh.triangles[mixed])


@CASES
@settings(max_examples=40)
def test_tree_is_that_of_plain_containers(seed: int, n: int, depth: float) -> None:
    polygon, arcs, offsets = polygon_and_arcs(seed, n, depth)
    cells = label_cells(mesh_convex(polygon, 0.03), arcs, offsets, ANYTHING)
    distances = plain_distances(cells.mesh, arcs, offsets)
    for tolerance in (0.0, 0.003):
        sorted_arcs = sorted((arc.sides, arc.points.tolist()) for arc in dissection_tree(cells, tolerance))
        plain = plain_tree(cells.mesh, cells.labels, distances, tolerance)
        assert sorted_arcs == sorted((sides, points.tolist()) for sides, points in plain)


def test_equal_arcs_go_to_the_first() -> None:
    # Two pieces with one and the same arc over half of the trunk tie at every point there, but for rounding.
    polygon = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    deep = np.array([[0.0, 0.0], [0.0, 0.5], [1.0, 0.5], [1.0, 0.0]])
    arcs = np.concatenate([deep, polygon[[1, 2]], [[1.0, 1.0], [1.0, 0.5], [0.0, 0.5], [0.0, 1.0]], polygon[[3, 0]]])
    offsets = np.array([0, 4, 6, 10, 12], dtype=np.int64)
    mesh = mesh_convex(polygon, 0.03)
    cells = label_cells(mesh, arcs, offsets, ANYTHING)
    assert np.array_equal(cells.labels, plain_labels(mesh, plain_distances(mesh, arcs, offsets)))


def test_rooted_points_hang_together() -> None:
    mesh = mesh_convex(polygon_and_arcs(1, 5, 0.0)[0], 0.05)
    boundary = len(mesh.edge)
    labels = np.zeros(len(mesh.points), dtype=np.int64)
    labels[np.hypot(*(mesh.points - mesh.points[-1]).T) < 0.1] = 1
    kept = rooted(labels, mesh.triangles, boundary)
    assert np.array_equal(kept, labels == 0)
