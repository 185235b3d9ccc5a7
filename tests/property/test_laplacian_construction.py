"""The paper's construction: what each phase must lower, what comes back as it was, where pieces end (paper §4.3)."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
import shapely
from blobs import blob, pair_shapes
from hypothesis import given, settings
from hypothesis import strategies as st

from riot.construction.given_trunks import given_pair
from riot.construction.laplacian import construct_laplacian
from riot.construction.laplacian.contact import TrunkArcs
from riot.construction.laplacian.method import tile
from riot.construction.laplacian.phases import close_gaps, part_overlaps, scale_arcs
from riot.construction.laplacian.residual import residuals
from riot.construction.plan import ConstructionPlan, TrunkPair, plan_pair
from riot.construction.plan_transform import construct_plan
from riot.construction.tuning import CONTACT_DISTANCE
from riot.groundtruth.pairs import dudeney, exact_pair, exact_transform
from riot.parameters import ConstructParameters
from riot.scores.crs import best_trunk_pairs
from riot.transform.certificate import certify
from riot.transform.deformation import measure_deformation
from riot.transform.riot_file import from_json, to_json
from riot.types import FloatArray

PARAMETERS = ConstructParameters()
SEEDS = st.integers(0, 10_000)


@cache
def blob_plan() -> ConstructionPlan:
    """Two blobs on a trunk pair that can be made conjugate."""
    a, b = blob(1), blob(2)
    for score in best_trunk_pairs(a, b, count=16):
        pair = TrunkPair(a, b, a.points, b.points, score.trunk_a, score.trunk_b)
        try:
            plan = plan_pair(pair)
            construct_plan(plan, PARAMETERS)
        except ValueError:
            continue
        return plan
    raise AssertionError("no trunk pair of the two blobs can be constructed on")


def square_trunk() -> FloatArray:
    return np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]])


def bumps(rng: np.random.Generator, low: float = 0.15, high: float = 0.6) -> list[FloatArray]:
    """An arc on each edge of the square, of a random height and leaning either way."""
    trunk = square_trunk()
    arcs = []
    for k in range(4):
        start, along = trunk[k], trunk[(k + 1) % 4] - trunk[k]
        t = np.linspace(0.0, 1.0, 31)
        height = rng.uniform(low, high) * np.sin(math.pi * t ** rng.uniform(0.7, 1.4))
        arc = start + t[:, None] * along + height[:, None] * np.array([along[1], -along[0]])
        arc[0], arc[-1] = start, start + along
        arcs.append(arc)
    return arcs


@given(SEEDS)
@settings(max_examples=10)
def test_what_is_known_of_vertices_matches_shapely(seed: int) -> None:
    arcs = TrunkArcs.of(square_trunk(), bumps(np.random.default_rng(seed)))
    count = len(arcs.owner)
    vertices = shapely.points(np.column_stack([arcs.points[:count].real, arcs.points[:count].imag]))
    for i in range(len(arcs)):
        others = arcs.owner != i
        line = shapely.LineString(arcs.arc(i))
        assert arcs.distance[others, i] == pytest.approx(shapely.distance(vertices[others], line), abs=1e-12)
        clear = others & ~arcs.ends & (shapely.distance(vertices, shapely.Polygon(arcs.arc(i)).exterior) > 1e-9)
        assert np.array_equal(arcs.inside[clear, i], shapely.contains(shapely.Polygon(arcs.arc(i)), vertices[clear]))


@given(SEEDS)
@settings(max_examples=5)
def test_after_a_change_of_one_arc_all_is_known_as_if_anew(seed: int) -> None:
    arcs = TrunkArcs.of(square_trunk(), bumps(np.random.default_rng(seed)))
    arcs.points[arcs.span(2)][1:-1] += 0.05 - 0.02j
    arcs.renew(2)
    anew = TrunkArcs.of(square_trunk(), [arcs.arc(i) for i in range(4)])
    for name in ("distance", "foot", "inside", "ahead", "ahead_foot"):
        assert np.array_equal(getattr(arcs, name), getattr(anew, name)), name


@given(SEEDS)
@settings(max_examples=4)
def test_every_phase_lowers_what_it_is_for(seed: int) -> None:
    arcs = TrunkArcs.of(square_trunk(), bumps(np.random.default_rng(seed)))
    start = arcs.residual(1024)
    part_overlaps(arcs, 1000)
    parted = arcs.residual(1024)
    assert parted.overlaps <= max(0.1 * start.overlaps, 0.002)
    close_gaps(arcs, 1000)
    closed = arcs.residual(1024)
    assert closed.gaps <= max(0.1 * parted.gaps, 0.003)
    assert closed.total < start.total


def test_one_round_of_both_phases_leaves_little_as_a_rule() -> None:
    # To close gaps may open overlaps again, which is why there are more rounds: some arcs keep a quarter.
    left = []
    for seed in range(12):
        arcs = TrunkArcs.of(square_trunk(), bumps(np.random.default_rng(seed)))
        start = arcs.residual(1024).total
        part_overlaps(arcs, 1000)
        close_gaps(arcs, 1000)
        left.append(arcs.residual(1024).total / start)
    assert np.median(left) < 0.05 and np.max(left) < 1.0


def test_an_arc_that_leaves_over_its_top_is_scaled_into_the_trunk() -> None:
    arcs = bumps(np.random.default_rng(3))
    arcs[1] = arcs[1] * [1.0, -1.0] + [0.0, 2.0]
    arcs[1][:, 1] = 1.0 - 1.4 * np.sin(math.pi * np.linspace(0.0, 1.0, 31))
    arcs[1][[0, -1]] = square_trunk()[[1, 2]]
    scaled = scale_arcs(square_trunk(), arcs)
    assert [scaled[k] is arcs[k] for k in range(4)] == [True, False, True, True]
    assert np.array_equal(scaled[1][[0, -1]], arcs[1][[0, -1]])
    assert -CONTACT_DISTANCE <= scaled[1][:, 1].min() < 0.02
    # Heights are scaled alike, and nothing moves along the edge.
    ratio = (1.0 - scaled[1][1:-1, 1]) / (1.0 - arcs[1][1:-1, 1])
    assert np.ptp(ratio) < 1e-12
    assert scaled[1][:, 0] == pytest.approx(arcs[1][:, 0], abs=1e-15)


def test_an_arc_beyond_its_own_edge_is_laid_on_it() -> None:
    arcs = bumps(np.random.default_rng(3), 0.2, 0.3)
    arcs[3][10:20, 1] = -0.05
    scaled = scale_arcs(square_trunk(), arcs)
    assert np.array_equal(scaled[3][10:20, 1], np.zeros(10))
    assert np.array_equal(scaled[3][20:], arcs[3][20:])


@given(st.integers(3, 6), st.integers(0, 200))
@settings(max_examples=4)
def test_exact_pairs_come_back_as_they_are(n: int, seed: int) -> None:
    pair = exact_pair(n, seed)
    p, q = pair_shapes(pair)
    trunks = given_pair(p, q, p.from_source(pair.trunk_p), q.from_source(pair.trunk_q), PARAMETERS.snap, 0.0)
    transform = construct_laplacian(plan_pair(trunks), PARAMETERS)
    assert max(residual.total for residual in residuals(transform)) < 1e-3
    assert measure_deformation(transform).iou > 0.999


def test_residuals_of_an_exact_transform_are_nothing() -> None:
    for pair in (exact_pair(5, 3), dudeney()):
        assert max(residual.total for residual in residuals(exact_transform(pair))) < 1e-9


def test_the_papers_method_lowers_the_areas_and_says_what_is_left() -> None:
    plan = blob_plan()
    transform = construct_laplacian(plan, PARAMETERS)
    pair = plan.pair
    sides = ((pair.outline_q, pair.trunk_q[::-1], plan.trunk_p[::-1]), (pair.outline_p, pair.trunk_p, plan.trunk_q))
    for side, left in zip(sides, residuals(transform), strict=True):
        _, course = tile(*side, PARAMETERS)
        assert left.total < 0.25 * course[0].total
        assert left.total == pytest.approx(min(residual.total for residual in course[1:]), abs=1e-3)
    certificate = certify(transform)
    assert not certificate.passed
    assert max(certificate.p.hinge, certificate.q.hinge) < 1e-12
    assert 0.7 < measure_deformation(transform).iou < 1.0


def test_pieces_end_at_the_hinges_exactly_and_survive_the_file() -> None:
    transform = construct_laplacian(blob_plan(), PARAMETERS)
    for piece in transform.pieces:
        ends = np.array([[0.0, 0.0], [piece.length, 0.0]])
        assert np.array_equal(piece.lower[[0, -1]], ends)
        assert np.array_equal(piece.upper[[-1, 0]], ends)
        assert piece.lower[:, 1].mean() < 0.0 < piece.upper[:, 1].mean()
    again = from_json(to_json(transform))
    for first, second in zip(transform.pieces, again.pieces, strict=True):
        assert np.array_equal(first.polygon, second.polygon)


def test_the_same_plan_gives_the_same_bytes() -> None:
    assert to_json(construct_laplacian(blob_plan(), PARAMETERS)) == to_json(
        construct_laplacian(blob_plan(), PARAMETERS)
    )
