"""Exact construction: conjugate trunks, partition, tree, and pairs that must come back exactly (theory §7, §8)."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from blobs import blob, pair_shapes
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_dissection import plain_distances, signed_distances

from riot import ConstructionError, Shape, Transform, TrunkError, construct
from riot.construction.conjugate import is_convex, make_conjugate
from riot.construction.mesh import mesh_convex
from riot.construction.partition import label_cells
from riot.construction.plan import TrunkPair, plan_pair
from riot.construction.plan_search import alternatives
from riot.construction.plan_transform import construct_plan
from riot.construction.tree import cell_paths, dissection_tree
from riot.geometry.polyline import edge_lengths
from riot.groundtruth.pairs import dudeney, exact_pair
from riot.parameters import ConstructParameters, RefineParameters, TrunkParameters
from riot.scores.crs import best_trunk_pairs
from riot.scores.trunks import full_trunks
from riot.types import FloatArray

SEEDS = st.integers(0, 10_000)
UNREFINED = RefineParameters(sketched=0, refined=0)


def convex_polygon(rng: np.random.Generator, n: int) -> FloatArray:
    angle = 2.0 * math.pi * (np.arange(n) + rng.uniform(-0.25, 0.25, n)) / n
    return np.stack([np.cos(angle), np.sin(angle)], axis=1) * rng.uniform(0.45, 0.6)


@given(SEEDS, st.integers(3, 7))
@settings(max_examples=40)
def test_conjugate_trunks_have_equal_edges_at_least_movement(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    p, q = convex_polygon(rng, n), convex_polygon(rng, n)[::-1]
    try:
        moved_p, moved_q = make_conjugate(p, q)
    except ConstructionError as error:
        assert error.reason == "not-convex"  # the nearest conjugate pair of a random one need not be convex
        return
    assert np.abs(edge_lengths(moved_p) - edge_lengths(moved_q)).max() < 1e-13
    assert is_convex(moved_p)
    assert is_convex(moved_q[::-1])
    # At a constrained minimum the displacement is a combination of the constraints' gradients: no admissible direction
    # shortens it. Move along random admissible directions and project back: the distance must not fall.
    distance = np.linalg.norm(np.concatenate([moved_p - p, moved_q - q]))
    for _ in range(5):
        jitter = 1e-3 * rng.normal(size=(2, n, 2))
        other_p, other_q = make_conjugate(moved_p + jitter[0], moved_q + jitter[1])
        assert np.linalg.norm(np.concatenate([other_p - p, other_q - q])) >= distance - 1e-5


def test_conjugate_trunks_stay_where_they_are() -> None:
    pair = exact_pair(5, 3)
    moved_p, moved_q = make_conjugate(pair.trunk_p, pair.trunk_q)
    assert np.abs(moved_p - pair.trunk_p).max() < 1e-12
    assert np.abs(moved_q - pair.trunk_q).max() < 1e-12


@given(SEEDS, st.integers(3, 8))
@settings(max_examples=15)
def test_mesh_covers_the_polygon(seed: int, n: int) -> None:
    polygon = convex_polygon(np.random.default_rng(seed), n)
    mesh = mesh_convex(polygon, 0.03)
    triangles = shapely.polygons(mesh.points[mesh.triangles])
    assert shapely.area(triangles).sum() == pytest.approx(shapely.Polygon(polygon).area, abs=1e-9)
    assert np.array_equal(mesh.points[mesh.corners], polygon)
    on_edges = shapely.distance(shapely.points(mesh.points[: len(mesh.edge)]), shapely.LinearRing(polygon))
    assert on_edges.max() < 1e-12
    assert len(np.unique(mesh.triangles)) == len(mesh.points)


@given(SEEDS)
@settings(max_examples=10)
def test_signed_distance_matches_shapely(seed: int) -> None:
    rng = np.random.default_rng(seed)
    arcs = [np.cumsum(rng.normal(size=(6, 2)), axis=0) * 0.2 for _ in range(3)]
    offsets = np.concatenate([[0], np.cumsum([len(arc) for arc in arcs])]).astype(np.int64)
    x = rng.normal(size=(30, 2)) * 0.5
    distances = signed_distances(x, np.concatenate(arcs), offsets)
    for k, arc in enumerate(arcs):
        assert np.abs(distances[:, k]) == pytest.approx(shapely.distance(shapely.points(x), shapely.LineString(arc)))
        polygon = shapely.Polygon(arc)
        if polygon.is_valid:
            assert np.array_equal(distances[:, k] < 0, shapely.contains_xy(polygon, x))


def test_partition_of_exact_arcs_is_the_dissection() -> None:
    pair = exact_pair(5, 4)
    p, q = pair_shapes(pair)
    transform = given_transform(pair)
    assert transform.certificate().passed
    # The cells of P's trunk are the exterior pieces of Q: their areas are those of the exact dissection.
    areas = sorted(shapely.Polygon(piece.upper).area for piece in transform.pieces)
    trunk = shapely.Polygon(p.from_source(pair.trunk_p))
    assert sum(areas) == pytest.approx(trunk.area, abs=1e-9)
    assert len(q.points) > 0
    exact = sorted(exterior_areas(q.points, q.from_source(pair.trunk_q)[::-1]))
    assert areas == pytest.approx(exact, abs=2e-3)


def exterior_areas(points: FloatArray, trunk: FloatArray) -> list[float]:
    """Areas of the parts of a polygon outside its trunk, one for each edge."""
    rest = shapely.Polygon(points).difference(shapely.Polygon(trunk).buffer(1e-9))
    return [polygon.area for polygon in rest.geoms if polygon.area > 1e-4]


def good_pair() -> TrunkPair:
    """Two blobs that are no exact pair, on trunks that can be constructed on."""
    a, b = blob(1), blob(2)
    for score in best_trunk_pairs(a, b, count=16):
        pair = TrunkPair(a, b, a.points, b.points, score.trunk_a, score.trunk_b)
        try:
            construct_plan(plan_pair(pair), ConstructParameters())
        except ConstructionError:
            continue
        return pair
    raise AssertionError("no trunk pair of the two blobs can be constructed on")


def test_cells_are_bounded_by_their_paths() -> None:
    parameters = ConstructParameters()
    plan = plan_pair(good_pair())
    mesh = mesh_convex(plan.trunk_p, 0.01)
    arcs, offsets = np.ascontiguousarray(plan.arcs_q[::-1]), plan.offsets_q[-1] - plan.offsets_q[::-1]
    cells = label_cells(mesh, arcs, offsets, parameters)
    # Almost every point is labelled with the nearest piece; the rest was cut off from its edge.
    assert (cells.labels == plain_distances(mesh, arcs, offsets).argmin(axis=1)).mean() > 0.95
    paths = cell_paths(cells, dissection_tree(cells, 0.0))
    # Where other pieces cover an edge, a cell has no width and its outline touches itself.
    polygons = [shapely.make_valid(shapely.Polygon(path)) for path in paths]
    total = sum(polygon.area for polygon in polygons)
    assert total == pytest.approx(shapely.Polygon(plan.trunk_p).area, abs=1e-9)
    assert shapely.union_all(polygons).area == pytest.approx(total, abs=1e-9)
    for k, polygon in enumerate(polygons):
        deep = (cells.labels == k) & (shapely.distance(shapely.points(mesh.points), polygon.boundary) > 0.01)
        assert shapely.contains_xy(polygon, mesh.points[deep]).all()


def given_transform(pair: object) -> Transform:
    p, q = pair_shapes(pair)  # type: ignore[arg-type]
    return construct(p, q, (p.from_source(pair.trunk_p), q.from_source(pair.trunk_q)))  # type: ignore[attr-defined]


@given(st.integers(3, 6), st.integers(0, 200))
@settings(max_examples=12)
def test_exact_pairs_come_back_exactly(n: int, seed: int) -> None:
    transform = given_transform(exact_pair(n, seed))
    assert transform.certificate().passed
    assert transform.certificate().residual < 1e-9
    assert transform.deformation().iou > 0.9997


def test_dudeneys_triangle_and_square_come_back() -> None:
    # One of its exterior pieces is empty.
    transform = given_transform(dudeney())
    certificate = transform.certificate()
    assert certificate.passed, certificate.failure
    assert transform.deformation().iou > 0.999
    assert min(shapely.Polygon(piece.polygon).area for piece in transform.pieces) > 0.01


@pytest.mark.parametrize(("seed_p", "seed_q"), [(1, 2), (7, 9)])
def test_search_and_construction_of_any_two_blobs(seed_p: int, seed_q: int) -> None:
    transform = construct(blob(seed_p), blob(seed_q))
    assert transform.certificate().passed
    deformation = transform.deformation()
    assert 0.6 < deformation.iou_p <= transform.bound_p + 1e-4
    assert 0.6 < deformation.iou_q <= transform.bound_q + 1e-4
    area = sum(shapely.Polygon(piece.polygon).area for piece in transform.pieces)
    assert area == pytest.approx(shapely.Polygon(transform.outline_p()).area, abs=1e-12)
    assert area == pytest.approx(shapely.Polygon(transform.outline_q()).area, abs=1e-12)


def test_the_partition_reaches_the_least_change_its_trunks_allow() -> None:
    pair = good_pair()
    plan = plan_pair(pair)
    transform = construct_plan(plan, ConstructParameters())
    for iou, bound in zip(transform.overlap_ratios, (plan.bound_p, plan.bound_q), strict=True):
        assert bound - 0.005 < iou < bound + 1e-3


def test_construction_is_the_same_turned() -> None:
    pair = good_pair()
    c, s = math.cos(1.0), math.sin(1.0)
    turned = Shape(pair.p.points @ np.array([[c, s], [-s, c]]), pair.p.feature, pair.p.name)
    transform, again = (
        construct(shape, pair.q, (shape.points[pair.trunk_p], pair.q.points[pair.trunk_q]), refinement=UNREFINED)
        for shape in (pair.p, turned)
    )
    assert again.deformation().iou == pytest.approx(transform.deformation().iou, abs=2e-3)
    assert again.angles == pytest.approx(transform.angles, abs=1e-9)


def test_given_trunks_may_lie_near_the_outline_and_run_either_way() -> None:
    pair = exact_pair(4, 1)
    p, q = pair_shapes(pair)
    trunk_p, trunk_q = p.from_source(pair.trunk_p), q.from_source(pair.trunk_q)
    exact = construct(p, q, (trunk_p, trunk_q))
    backwards = construct(p, q, (trunk_p[::-1], trunk_q[::-1]))
    moved = construct(p, q, (trunk_p + 0.01, trunk_q - 0.01))
    assert backwards.deformation().iou == pytest.approx(exact.deformation().iou, abs=1e-3)
    assert moved.deformation().iou > 0.95


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda p, q: (p, q[::-1]), "same way round"),
        (lambda p, q: (p[:3], q), "3 and 4 vertices"),
        (lambda p, q: (p + 1.0, q), "from_source"),
        (lambda p, q: (p[[0, 2, 1, 3]], q), "do not follow one another"),
        (lambda p, q: (p[[0, 0, 1, 2]], q), "do not follow one another"),
        (lambda p, q: (p[:2], q[:2]), "n ≥ 3"),
        (lambda p, q: (p,), "holds 1 items"),
        (lambda p, q: (p, "here"), "all of them numbers"),
        (lambda p, q: ([[0.0, 0.0], [1.0]], q), "all of them numbers"),
    ],
)
def test_wrong_trunks_are_refused_with_a_reason(change: object, words: str) -> None:
    pair = exact_pair(4, 1)
    p, q = pair_shapes(pair)
    trunks = change(p.from_source(pair.trunk_p), q.from_source(pair.trunk_q))  # type: ignore[operator]
    with pytest.raises(TrunkError, match=words):
        construct(p, q, trunks)


@pytest.mark.parametrize("pieces", [(3, 3), (4, 5)])
def test_the_number_of_pieces_can_be_chosen(pieces: tuple[int, int]) -> None:
    p, q = blob(1), blob(2)
    plans = alternatives(p, q, pieces=pieces)
    assert {len(plan.trunk_p) for plan in plans} <= set(range(pieces[0], pieces[1] + 1))
    assert pieces[0] <= len(construct(p, q, pieces=pieces)) <= pieces[1]
    candidates = full_trunks(p, TrunkParameters())
    kept = candidates.of_sizes(*pieces)
    expected = [t for t in range(len(candidates)) if pieces[0] <= candidates.sizes[t] <= pieces[1]]
    assert [kept.of(k).tolist() for k in range(len(kept))] == [candidates.of(t).tolist() for t in expected]
    with pytest.raises(TrunkError, match="same number of 30 to 31 vertices"):
        construct(p, q, pieces=(30, 31))


def test_shape_without_trunks_is_refused_with_its_name() -> None:
    needle = Shape.from_polygon([[0.0, 0.0], [60.0, 0.0], [60.0, 1.0], [0.0, 1.0]], name="needle")
    with pytest.raises(TrunkError, match="needle"):
        construct(needle, blob(1))


def test_a_piece_that_covers_all_is_rejected_with_a_reason() -> None:
    # The tower is far deeper than the other trunk, and half as wide: the piece opposite loses its edge.
    tower = Shape.from_polygon(
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.75, 1.0], [0.75, 4.0], [0.25, 4.0], [0.25, 1.0], [0.0, 1.0]]
    )
    square = Shape.from_polygon([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    trunk = tower.from_source([[0.1, 0.0], [0.9, 0.0], [0.75, 1.0], [0.25, 1.0]])
    seed_q = square.from_source([[0.1, 0.0], [0.0, 0.6], [0.4, 1.0], [1.0, 0.6]])
    with pytest.raises(ConstructionError) as caught:
        construct(tower, square, (trunk, seed_q))
    assert caught.value.reason == "lost-contact"


def test_plans_of_equal_input_are_equal() -> None:
    pair = good_pair()
    transforms = [construct_plan(plan_pair(pair), ConstructParameters()) for _ in range(2)]
    for first, second in zip(transforms[0].pieces, transforms[1].pieces, strict=True):
        assert np.array_equal(first.lower, second.lower)
        assert np.array_equal(first.upper, second.upper)
