"""The detail step: exact pairs come back, straight stays straight, the tree stays a tree (theory §8)."""

from __future__ import annotations

import contextlib
import importlib
import math
from functools import cache
from unittest import mock

import numpy as np
import pytest
import shapely
from blobs import blob, pair_shapes
from hypothesis import given, settings
from hypothesis import strategies as st

from riot import ConstructionError, Shape, construct
from riot.construction.detail import add_detail
from riot.construction.dissected_plan import DissectedPlan, dissect_plan
from riot.construction.dissection import dissect
from riot.construction.plan import ConstructionPlan
from riot.construction.tuning import DRAW_BACK_ROUNDS
from riot.geometry.polyline import simplify_open
from riot.groundtruth.pairs import ExactPair, exact_pair
from riot.kernels.detail import BENDABLE, collisions, difference, solved
from riot.kernels.matching import along, at, corresponding, merged, turnings
from riot.parameters import ConstructParameters, DetailParameters
from riot.scores.crs import best_trunk_pairs
from riot.types import FloatArray

SEEDS = st.integers(0, 2**32 - 1)


PARAMETERS = ConstructParameters()


def drafted(p: Shape, q: Shape, trunks: tuple[FloatArray, FloatArray]) -> DissectedPlan:
    """What `construct` keeps on given trunks."""
    drafts: list[DissectedPlan] = []

    def record(plan: ConstructionPlan, parameters: ConstructParameters) -> DissectedPlan:
        drafts.append(dissect_plan(plan, parameters))
        return drafts[-1]

    with mock.patch.object(importlib.import_module("riot.construction.plan_transform"), "dissect_plan", record):
        construct(p, q, trunks)
    return drafts[-1]


def exact_draft(pair: ExactPair) -> DissectedPlan:
    p, q = pair_shapes(pair)
    return drafted(p, q, (p.from_source(pair.trunk_p), q.from_source(pair.trunk_q)))


@cache
def blob_draft() -> DissectedPlan:
    """Of two blobs that are no exact pair."""
    a, b = blob(1), blob(2)
    for score in best_trunk_pairs(a, b, count=16):
        with contextlib.suppress(ConstructionError):
            return drafted(a, b, (a.points[score.trunk_a], b.points[score.trunk_b]))
    raise AssertionError("no trunk pair of the two blobs can be constructed on")


def wave(rng: np.random.Generator, count: int) -> FloatArray:
    """A polyline (count, 2) from (0, 0) to (1, 0)."""
    x = np.sort(np.concatenate([[0.0, 1.0], rng.uniform(0.05, 0.95, count - 2)]))
    y = 0.1 * np.sin(3.0 * np.pi * x) * rng.uniform(-1.0, 1.0)
    return np.stack([x, y], axis=1)


@given(SEEDS)
@settings(max_examples=25)
def test_samples_correspond_monotonically_and_hold_every_vertex(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = wave(rng, 12), wave(rng, 17) + np.array([0.0, 0.05])
    u, v = merged(a, turnings(a, 0.02), b, turnings(b, 0.02), 0.02)
    assert (np.diff(u) >= 0.0).all()
    assert (np.diff(v) >= 0.0).all()
    for points, positions in ((a, u), (b, v)):
        lengths = along(points)
        assert positions[[0, -1]] == pytest.approx(lengths[[0, -1]])
        assert np.abs(lengths[:, None] - positions[None]).min(axis=1).max() < 1e-9


def test_positions_end_at_the_ends_whatever_lay_in_memory_before() -> None:
    for length in np.linspace(1.0, 2.0, 60):
        # A loop at the end of one line corresponds to the end of the other, beyond which rounding may put it.
        line = np.stack([np.linspace(0.0, length, 60), np.zeros(60)], axis=1)
        loop = length + 0.1 * np.sin(np.pi * np.linspace(0.125, 0.875, 7))
        looped = np.concatenate([line, np.stack([loop, np.zeros(7)], axis=1), line[-1:]])
        features = np.zeros(len(looped))
        features[len(line) : -1] = 0.1
        for count in range(100, 400, 4):  # memory of which the kernel may be given some
            memory = [np.tile([-1e9, -1e9, 1e9, 1e9], count // 4) for _ in range(9)]
        del memory
        u, v = merged(line, np.zeros(len(line)), looped, features, 0.02)
        assert (u[-1], v[-1]) == (along(line)[-1], along(looped)[-1])


@given(SEEDS)
@settings(max_examples=25)
def test_two_straight_lines_average_to_a_straight_line(seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, second = (
        np.stack([np.linspace(0.0, 1.0, k), np.linspace(y, z, k)], axis=1)
        for k, y, z in ((9, 0, 0.1), (14, *rng.uniform(-0.1, 0.1, 2)))
    )
    u, v = merged(first, turnings(first, 0.02), second, turnings(second, 0.02), 0.02)
    mean = 0.5 * (at(first, along(first), u) + at(second, along(second), v))
    chord = shapely.LineString(mean[[0, -1]])
    assert shapely.distance(shapely.points(mean), chord).max() < 1e-12


def test_a_corner_corresponds_to_a_corner() -> None:
    first = np.array([[0.0, 0.0], [0.5, 0.2], [1.0, 0.0]])
    second = np.array([[0.0, 0.0], [0.53, 0.25], [1.0, 0.02]])
    u, v = merged(first, turnings(first, 0.02), second, turnings(second, 0.02), 0.02)
    at_corner = np.abs(u - along(first)[1]).argmin()
    assert v[at_corner] == pytest.approx(along(second)[1])


@given(SEEDS)
@settings(max_examples=10)
def test_a_line_corresponds_to_itself(seed: int) -> None:
    line = wave(np.random.default_rng(seed), 15)
    lengths = along(line)
    assert corresponding(line, lengths, line, 0.01) == pytest.approx(lengths, abs=1e-9)


@given(SEEDS)
@settings(max_examples=15)
def test_the_solution_is_that_of_a_dense_least_squares(seed: int) -> None:
    # Three arcs from fixed leaves to one junction.
    rng = np.random.default_rng(seed)
    sizes = rng.integers(3, 8, 3)
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    count = int(offsets[-1])
    targets, wanted = rng.normal(size=(count, 2)), rng.normal(size=(count, 2))
    weights, softness = rng.uniform(0.0, 2.0, count) * (rng.random(count) < 0.3), rng.uniform(0.1, 1.0, count)
    which, known, size = np.full(count, -1), targets.copy(), 0
    for i in range(3):
        inner = np.arange(offsets[i] + 1, offsets[i + 1] - 1)
        which[inner] = size + np.arange(len(inner))
        size += len(inner)
    which[offsets[1:] - 1] = size
    rows, right = [], []

    def add(places: list[int], factors: list[float], goal: FloatArray, weight: float) -> None:
        row, rest = np.zeros(size + 1), np.array(factors) @ goal[places]
        for sample, factor in zip(places, factors, strict=True):
            if which[sample] < 0:
                rest = rest - factor * known[sample]
            else:
                row[which[sample]] += factor
        rows.append(math.sqrt(weight) * row)
        right.append(math.sqrt(weight) * rest)

    for i in range(3):
        steps = np.hypot(*np.diff(targets[offsets[i] : offsets[i + 1]], axis=0).T)
        for k in range(offsets[i], offsets[i + 1]):
            j = k - offsets[i]
            before, after = (steps[j - 1] if j else 0.0), (steps[j] if j < len(steps) else 0.0)
            mean = 0.5 * (before + after)
            add([k], [1.0], targets, softness[k] * mean)
            add([k], [1.0], wanted, weights[k])
            if before and after:
                first, second = targets[k] - targets[k - 1], targets[k + 1] - targets[k]
                bent = math.atan2(first[0] * second[1] - first[1] * second[0], first @ second) / BENDABLE
                factors = [1 / before, -1 / before - 1 / after, 1 / after]
                add([k - 1, k, k + 1], factors, targets, 1 / (mean * (1 + bent**2)))
    expected = np.linalg.lstsq(np.array(rows), np.array(right), rcond=None)[0]
    solution = solved(targets, offsets, which, known, wanted, weights, softness, 0.0)
    assert solution[which >= 0] == pytest.approx(expected[which[which >= 0]], abs=1e-8)
    assert np.array_equal(solution[which < 0], known[which < 0])


@given(SEEDS)
@settings(max_examples=40)
def test_collisions_are_found_where_shapely_finds_them(seed: int) -> None:
    rng = np.random.default_rng(seed)
    lines = [np.cumsum(rng.normal(size=(5, 2)), axis=0) + 2.0 * rng.normal(size=2) for _ in range(2)]
    ends = np.array([[0, 1], [2, 3]])
    offsets = np.array([0, 5, 10])
    colliding = collisions(np.concatenate(lines), offsets, ends, 1e-9)
    assert colliding.any() != shapely.MultiLineString(lines).is_simple


@given(SEEDS)
@settings(max_examples=20)
def test_difference_is_that_of_the_regions(seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, second = (
        [[0.0, 0.0], *np.stack([np.linspace(0.1, 0.9, 7), rng.uniform(0.05, 0.5, 7)], axis=1), [1.0, 0.0]]
        for _ in range(2)
    )
    expected = shapely.Polygon(first).symmetric_difference(shapely.Polygon(second)).area
    assert difference(np.array(first), np.array(second), 2048) == pytest.approx(expected, abs=2e-3)


@pytest.mark.parametrize(
    ("n", "seed", "curved"), [(3, 1, True), (4, 3, False), (4, 5, True), (5, 0, True), (7, 5, True)]
)
def test_exact_pairs_come_back_unchanged(n: int, seed: int, curved: bool) -> None:
    transform = exact_draft(exact_pair(n, seed, curved=curved)).transform()
    deformation = transform.deformation()
    assert transform.certificate().passed
    assert deformation.iou > 1.0 - 1e-6
    assert max(deformation.hausdorff_p, deformation.hausdorff_q) < 1e-6


def test_straight_sides_stay_straight_if_area_may_be_lost_for_it() -> None:
    # All arcs are straight between corners, and one trunk is a little wrong: there are gaps and overlaps.
    pair = exact_pair(4, 3, curved=False)
    p, q = pair_shapes(pair)
    trunk_p, trunk_q = p.from_source(pair.trunk_p), q.from_source(pair.trunk_q)
    moved = trunk_q + np.array([[0.02, 0.0], [0.0, -0.02], [-0.01, 0.01], [0.0, 0.0]])
    draft = drafted(p, q, (trunk_p, moved))
    assert draft.transform().certificate().passed
    for dissection in (draft.lower, draft.upper):
        match, parameters = dissection.match, DetailParameters(max_loss=0.05, max_share=1e9)
        for path in add_detail(dissection.plain_paths, dissection.arcs, match, parameters).paths:
            # One corner, at the star's middle, and one where the arcs begin at each leaf, at most.
            assert len(simplify_open(path, 1e-3)) <= 5


def test_leaves_are_the_corners_to_the_bit_and_cells_tile_the_trunk() -> None:
    for dissection in (blob_draft().lower, blob_draft().upper):
        n = len(dissection.trunk)
        for k, path in enumerate(dissection.paths):
            assert np.array_equal(path[0], dissection.trunk[k])
            assert np.array_equal(path[-1], dissection.trunk[(k + 1) % n])
        polygons = [shapely.Polygon(path) for path in dissection.paths]
        assert all(polygon.is_valid for polygon in polygons)
        total = sum(polygon.area for polygon in polygons)
        assert total == pytest.approx(shapely.Polygon(dissection.trunk).area, abs=1e-9)
        assert shapely.union_all(polygons).area == pytest.approx(total, abs=1e-9)


def test_detail_costs_little_area_and_less_if_less_is_allowed() -> None:
    dissection = blob_draft().lower
    for allowed in (0.002, 1e-5):
        parameters = DetailParameters(max_loss=allowed)
        detailed = add_detail(dissection.plain_paths, dissection.arcs, dissection.match, parameters)
        assert detailed.loss <= allowed
        assert detailed.rounds <= DRAW_BACK_ROUNDS


def test_the_detailed_transform_is_certified_and_the_same_again() -> None:
    draft = blob_draft()
    transform = draft.transform()
    assert transform.certificate().passed
    again = dissect_plan(draft.plan, PARAMETERS).transform()
    for first, second in zip(transform.pieces, again.pieces, strict=True):
        assert np.array_equal(first.lower, second.lower)
        assert np.array_equal(first.upper, second.upper)


def test_detail_turns_with_the_trunk() -> None:
    dissection = blob_draft().upper
    c, s = math.cos(1.0), math.sin(1.0)
    turn = np.array([[c, s], [-s, c]])
    offsets = np.concatenate([[0], np.cumsum([len(arc) for arc in dissection.arcs])]).astype(np.int64)
    arcs = np.concatenate(dissection.arcs)
    first, second = (
        dissect(dissection.trunk @ by, (arcs @ by, offsets), PARAMETERS, "the trunk") for by in (np.eye(2), turn)
    )
    for path, turned in zip(first.paths, second.paths, strict=True):
        assert shapely.hausdorff_distance(shapely.LineString(path @ turn), shapely.LineString(turned)) < 1e-6
