"""Candidate vertices and trunks against brute force and shapely (paper §4.1)."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
import shapely
from blobs import blob, blob_polygon
from hypothesis import given, settings
from hypothesis import strategies as st

from riot import Shape
from riot.geometry.polyline import arc_length, insert_midpoints, signed_area
from riot.kernels.congruency import frechet
from riot.kernels.enumerate import enumerate_convex
from riot.kernels.segments import inside_shares
from riot.kernels.visibility import seen_from
from riot.parameters import TrunkParameters
from riot.scores.edges import admissible_edges
from riot.scores.trunks import Trunks, full_trunks, quick_trunks
from riot.scores.vertices import congruency, convex_points, passes_visibility, sparse_points
from riot.units import L_C

SEEDS = st.integers(0, 10_000)


def visible_area(points: np.ndarray, k: int, rays: int = 4000) -> float:
    """Area seen from vertex k, by many rays."""
    ring = shapely.LinearRing(points)
    origin = points[k]
    angles = (np.arange(rays) + 0.5) * (2.0 * math.pi / rays)
    area = 0.0
    start = origin + 1e-9 * (points.mean(axis=0) - origin)
    polygon = shapely.Polygon(points)
    for angle in angles:
        far = start + 10.0 * np.array([math.cos(angle), math.sin(angle)])
        inside = shapely.intersection(shapely.LineString([start, far]), polygon)
        first = inside if inside.geom_type == "LineString" else inside.geoms[0]
        if first.is_empty or first.geom_type != "LineString" or first.distance(shapely.Point(start)) > 1e-6:
            continue
        area += 0.5 * first.length**2 * (2.0 * math.pi / rays)
    assert ring.is_simple
    return area


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_visible_area_matches_ray_casting(seed: int) -> None:
    points = blob_polygon(seed, waves=7, depth=0.5, count=60)
    points = points / math.sqrt(shapely.Polygon(points).area)
    indices = np.array([0, 17, 41])
    views = seen_from(points, arc_length(points), indices)
    for row, k in enumerate(indices):
        assert views[row, 0] == pytest.approx(visible_area(points, int(k)), abs=4e-3)


def plainly_seen(points: np.ndarray, k: int) -> tuple[float, float, float]:
    """What vertex k sees, with every edge tried for every ray: the same arithmetic without the sweep."""
    m, lengths, origin = len(points), arc_length(points), points[k]
    after, before = (k + 1) % m, (k - 1) % m
    (fx, fy), (bx, by) = points[after] - origin, points[before] - origin
    forward = np.arctan2(fy, fx)
    cone = (np.arctan2(by, bx) - forward) % (2.0 * np.pi)
    others = [i for i in range(m) if i not in (k, after, before)]
    x, y = (points[others] - origin).T
    angles = (np.arctan2(y, x) - forward) % (2.0 * np.pi)
    area, hidden, low = 0.0, 0.0, 0.0
    perimeter = np.hypot(fx, fy) + np.hypot(bx, by)
    last_x, last_y, last_s = fx, fy, lengths[k + 1] - lengths[k]
    for high in [*np.sort(angles[angles < cone]), cone]:
        if high - low < 1e-12:
            continue
        dx, dy = np.cos(forward + 0.5 * (low + high)), np.sin(forward + 0.5 * (low + high))
        nearest, edge = np.inf, -1
        for step in range(1, m - 1):
            (x0, y0), (x1, y1) = points[(k + step) % m] - origin, points[(k + step + 1) % m] - origin
            c0, c1 = dx * y0 - dy * x0, dx * y1 - dy * x1
            if (c0 <= 0.0) != (c1 <= 0.0):
                share = c0 / (c0 - c1)
                far = dx * (x0 + share * (x1 - x0)) + dy * (y0 + share * (y1 - y0))
                if 0.0 < far < nearest:
                    nearest, edge = far, (k + step) % m
        if edge >= 0:
            ax, ay = points[edge] - origin
            ex, ey = points[(edge + 1) % m] - origin - [ax, ay]
            ends = []
            for angle in (forward + low, forward + high):
                dx, dy = np.cos(angle), np.sin(angle)
                cross = dx * ey - dy * ex
                share = min(1.0, max(0.0, 0.0 if cross == 0.0 else (dy * ax - dx * ay) / cross))
                ends.append((ax + share * ex, ay + share * ey, share * np.hypot(ex, ey)))
            (start_x, start_y, start_s), (end_x, end_y, end_s) = ends
            area += 0.5 * abs(start_x * end_y - start_y * end_x)
            base = (lengths[edge] - lengths[k]) % lengths[-1]
            window = np.hypot(start_x - last_x, start_y - last_y)
            section = base + start_s - last_s
            hidden = max(hidden, section if section > window * (1.0 + 1e-9) else 0.0)
            perimeter += window
            perimeter += np.hypot(end_x - start_x, end_y - start_y)
            last_x, last_y, last_s = end_x, end_y, base + end_s
        low = high
    window = np.hypot(bx - last_x, by - last_y)
    section = lengths[-1] - (lengths[before + 1] - lengths[before]) - last_s
    hidden = max(hidden, section if section > window * (1.0 + 1e-9) else 0.0)
    return area, perimeter + window, hidden


def seen_polygons(kind: str, seed: int) -> np.ndarray:
    """Unit-area polygons, some with many vertices on one ray: those decide whether a sweep keeps every crossing."""
    if kind == "blob":
        points = blob_polygon(seed, waves=7, depth=0.5, count=48)
    elif kind == "comb":
        teeth = [((t + 1, 0), (t + 1, 3), (t, 3), (t, 0)) for t in range(8, -1, -2)]
        points = np.array([(0, -1), (9, -1), *itertools.chain(*teeth)], dtype=float)
    else:
        points = insert_midpoints(windmill(6, 0.4), np.arange(12), 0.2)[0]
    angle = 0.1 * seed
    c, s = math.cos(angle), math.sin(angle)
    return np.ascontiguousarray(points @ np.array([[c, s], [-s, c]])) / math.sqrt(signed_area(points))


@given(st.sampled_from(["blob", "comb", "windmill"]), st.integers(0, 60), st.integers(0, 1000))
@settings(max_examples=40)
def test_the_sweep_sees_what_trying_every_edge_for_every_ray_does(kind: str, seed: int, k: int) -> None:
    points = seen_polygons(kind, seed)
    k %= len(points)
    view = seen_from(points, arc_length(points), np.array([k]))[0]
    # Not to the bit: NumPy's vectorised arctan2 differs from the kernel's in the last place.
    assert view.tolist() == pytest.approx(plainly_seen(points, k), rel=1e-13, abs=1e-13)


def test_convex_shape_is_seen_whole() -> None:
    square = Shape.from_polygon([[0, 0], [1, 0], [1, 1], [0, 1]])
    indices = np.arange(len(square.points))
    area, perimeter, hidden = seen_from(square.points, arc_length(square.points), indices).T
    assert area == pytest.approx(1.0, abs=1e-9)
    assert perimeter == pytest.approx(4.0, abs=1e-9)
    assert hidden == pytest.approx(0.0, abs=1e-9)


def test_l_shape_hides_one_leg() -> None:
    # From the end of one leg of an L the window starts at the inner corner: all closed-form.
    points = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]])
    area, _, hidden = seen_from(points, arc_length(points), np.array([1]))[0]
    # The ray from (2, 0) through (1, 1) meets the left side at (0, 2): only the part beyond it is hidden.
    assert area == pytest.approx(2.5)
    assert hidden == pytest.approx(2.0)


def naive_frechet(a: np.ndarray, b: np.ndarray) -> float:
    distance = np.hypot(*(a[:, None] - b[None]).transpose(2, 0, 1))
    reach = np.full(distance.shape, np.inf)
    for i, j in itertools.product(range(len(a)), range(len(b))):
        before = [reach[p, q] for p, q in ((i - 1, j), (i, j - 1), (i - 1, j - 1)) if p >= 0 and q >= 0]
        reach[i, j] = max(distance[i, j], min(before, default=0.0))
    return float(reach[-1, -1])


@given(SEEDS, st.integers(2, 12))
@settings(max_examples=30)
def test_frechet_distance_matches_its_definition(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = rng.normal(size=(2, count, 2))
    assert frechet(a, b, count, np.empty(count)) == pytest.approx(naive_frechet(a, b), abs=1e-12)


def test_symmetric_point_is_congruent_with_itself() -> None:
    # About the top of an isosceles triangle both sides are straight: turned by θ they coincide, all the way
    # down to the corners, where the last sample turns off.
    triangle = Shape.from_polygon([[-1.0, 0.0], [1.0, 0.0], [0.0, 3.0]])
    top = int(triangle.points[:, 1].argmax())
    congruent = congruency(triangle, np.array([top]), TrunkParameters())
    assert congruent.turn[0] == pytest.approx(2.0 * math.pi - 2.0 * math.atan2(1.0, 3.0), abs=0.01)
    assert congruent.score[0] > 0.95
    assert congruent.length[0] > 0.3 * triangle.perimeter


def is_convex(corners: np.ndarray) -> bool:
    ahead = np.roll(corners, -1, axis=0) - corners
    behind = corners - np.roll(corners, 1, axis=0)
    cross = behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0]
    return bool((cross > 0).all()) and shapely.Polygon(corners).is_valid


@pytest.mark.parametrize("seed", [3, 8])
def test_enumeration_matches_combinations(seed: int) -> None:
    shape = blob(seed)
    parameters = TrunkParameters(spacing=4.0, sparse_tolerance=0.08)
    trunks = quick_trunks(shape, parameters)
    candidates = sparse_points(shape, parameters)
    candidates = candidates[passes_visibility(shape, candidates)]
    admissible = admissible_edges(shape, candidates, parameters)
    most = min(len(convex_points(shape, parameters)), parameters.max_vertices)
    expected = set()
    for n in range(3, most + 1):
        for chosen in itertools.combinations(range(len(candidates)), n):
            allowed = all(admissible[chosen[k], chosen[(k + 1) % n]] for k in range(n))
            if allowed and is_convex(shape.points[candidates[list(chosen)]]):
                expected.add(tuple(candidates[list(chosen)].tolist()))
    assert {tuple(trunks.of(t).tolist()) for t in range(len(trunks))} == expected
    assert len(expected) == len(trunks) > 0


def test_too_many_trunks_of_one_size_end_the_enumeration() -> None:
    around = np.arange(9) * (2.0 * math.pi / 9.0)
    points = np.column_stack([np.cos(around), np.sin(around)])
    allowed = ~np.eye(9, dtype=np.bool_)
    triangles, longer = enumerate_convex(points, allowed, 3, 1000)
    assert triangles.tolist() == [list(chosen) for chosen in itertools.combinations(range(9), 3)]
    assert longer
    assert len(enumerate_convex(points, allowed, 9, 1000)[0]) == 1
    assert enumerate_convex(points, allowed, 4, 17)[0].tolist() == [
        list(chosen) for chosen in itertools.islice(itertools.combinations(range(9), 4), 17)
    ]
    # Only edges to the next vertex: one nonagon, which no triangle hints at but its paths do.
    ring = np.roll(np.eye(9, dtype=np.bool_), 1, axis=1)
    assert len(enumerate_convex(points, ring, 3, 10)[0]) == 0
    assert all(enumerate_convex(points, ring, n, 10)[1] for n in range(3, 10))
    assert enumerate_convex(points, ring, 9, 10)[0].tolist() == [list(range(9))]
    shape = Shape.from_polygon(windmill(6, 0.6))
    every, few = full_trunks(shape), full_trunks(shape, TrunkParameters(max_trunks=len(full_trunks(shape)) - 1))
    assert set(few.sizes) < set(every.sizes)
    assert np.array_equal(few.vertices, every.vertices[: len(few.vertices)])


@given(SEEDS)
@settings(max_examples=12)
def test_every_trunk_keeps_the_papers_conditions(seed: int) -> None:
    shape = blob(seed, waves=6)
    parameters = TrunkParameters()
    polygon = shapely.Polygon(shape.points).buffer(1e-9)
    lengths = arc_length(shape.points)
    convex = convex_points(shape, parameters)
    for trunks in (quick_trunks(shape, parameters), full_trunks(shape, parameters)):
        for t in np.linspace(0, len(trunks) - 1, min(8, len(trunks))).astype(int):
            trunk = trunks.of(int(t))
            corners = shape.points[trunk]
            assert is_convex(corners)
            assert 3 <= len(trunk) <= len(convex)
            assert trunks.areas[t] == pytest.approx(_trunk_area_from_pieces(shape, trunk), abs=1e-9)
            for k, start in enumerate(trunk):
                stop = trunk[(k + 1) % len(trunk)]
                edge = shapely.LineString([shape.points[start], shape.points[stop]])
                assert edge.intersection(polygon).length >= parameters.min_inside * edge.length - 1e-6
                assert (lengths[stop] - lengths[start]) % lengths[-1] < parameters.max_arc * lengths[-1]
                between = np.arange(start + 1, stop) if stop > start else np.r_[start + 1 : len(lengths) - 1, 0:stop]
                assert np.isin(convex, between).any()


def _trunk_area_from_pieces(shape: Shape, trunk: np.ndarray) -> float:
    area = float(shapely.Polygon(shape.points).area)
    for k, start in enumerate(trunk):
        stop = trunk[(k + 1) % len(trunk)]
        arc = np.arange(start, stop + 1) if stop > start else np.r_[start : len(shape.points), 0 : stop + 1]
        x, y = shape.points[arc].T
        area -= 0.5 * float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    return area


def turned(shape: Shape, angle: float) -> Shape:
    c, s = math.cos(angle), math.sin(angle)
    return Shape(shape.points @ np.array([[c, s], [-s, c]]), shape.feature, shape.name)


@given(SEEDS, st.floats(0.0, 6.28))
@settings(max_examples=10)
def test_trunks_turn_with_the_shape(seed: int, angle: float) -> None:
    shape = blob(seed)
    before, after = quick_trunks(shape), quick_trunks(turned(shape, angle))
    # Ties in the conditions may fall either way by rounding, no more.
    assert abs(len(before) - len(after)) <= 0.01 * len(before)
    if np.array_equal(before.vertices, after.vertices):
        assert after.edges == pytest.approx(before.edges, abs=1e-9)
        assert after.alphas == pytest.approx(before.alphas, abs=1e-9)
        assert after.thetas == pytest.approx(before.thetas, abs=1e-6)


def windmill(spikes: int, inner: float) -> np.ndarray:
    """Straight-sided star: an even number of spikes puts every vertex exactly half the boundary from another."""
    around = np.pi * np.arange(2 * spikes) / spikes
    radius = np.where(np.arange(2 * spikes) % 2, inner, 1.0)
    return np.stack([radius * np.cos(around), radius * np.sin(around)], axis=1)


@pytest.mark.parametrize("move", ["turn", "scale", "mirror"])
def test_symmetric_stars_do_not_lose_trunks_by_rounding(move: str) -> None:
    points = windmill(6, 0.6)
    c, s = math.cos(0.7), math.sin(0.7)
    moved = {"turn": points @ np.array([[c, s], [-s, c]]), "scale": 137.3 * points, "mirror": points * [-1.0, 1.0]}
    before, after = Shape.from_polygon(points), Shape.from_polygon(moved[move])
    for trunks_of in (quick_trunks, full_trunks):
        assert len(trunks_of(before)) == len(trunks_of(after)) > 0
        assert trunks_of(after).areas == pytest.approx(trunks_of(before).areas, abs=1e-9)


@given(st.floats(0.0, 6.28))
@settings(max_examples=20)
def test_edges_along_a_straight_side_are_inside(angle: float) -> None:
    # Both long sides are straight; the lower has a bump outwards in the middle, the upper a dent.
    points = np.array(
        [[0, 0], [1, 0], [1.5, -1], [2, 0], [3, 0], [3, 2], [2, 2], [1.5, 1], [1, 2], [0, 2]], dtype=float
    )
    c, s = math.cos(angle), math.sin(angle)
    shares = inside_shares(
        points @ np.array([[c, s], [-s, c]]), np.arange(len(points)), ~np.eye(len(points), dtype=np.bool_), 1e-9
    )
    assert shares[0, 4] == pytest.approx(1.0, abs=1e-9)
    assert shares[1, 3] == pytest.approx(1.0, abs=1e-9)
    assert shares[5, 9] == pytest.approx(2.0 / 3.0, abs=1e-9)
    assert shares[0, 1] == pytest.approx(1.0, abs=1e-9)
    assert shares[9, 5] == shares[5, 9]


@pytest.mark.parametrize("seed", [2, 6])
def test_congruent_stretches_of_neighbours_share_little_of_the_boundary_between_them(seed: int) -> None:
    shape, parameters = blob(seed, waves=6), TrunkParameters()
    lengths = arc_length(shape.points)
    trunks = full_trunks(shape, parameters)
    assert len(trunks) > 0
    for t in range(0, len(trunks), 7):
        trunk = trunks.of(t)
        reach = congruency(shape, trunk, parameters).length
        for k, start in enumerate(trunk):
            after = (k + 1) % len(trunk)
            arc = (lengths[trunk[after]] - lengths[start]) % lengths[-1]
            ahead, behind = shapely.box(0, 0, min(reach[k], arc), 1), shapely.box(arc - reach[after], 0, arc, 1)
            assert ahead.intersection(behind).area < parameters.max_overlap * L_C


def test_trunks_are_ordered_and_survive_arrays() -> None:
    trunks = full_trunks(blob(5))
    order = list(zip(trunks.sizes, trunks.areas, strict=True))
    assert order == sorted(order)
    again = Trunks.from_arrays(trunks.to_arrays())
    assert all(np.array_equal(value, again.to_arrays()[name]) for name, value in trunks.to_arrays().items())


def test_long_thin_shape_may_have_no_trunk() -> None:
    needle = Shape.from_polygon([[0.0, 0.0], [60.0, 0.0], [60.0, 1.0], [0.0, 1.0]])
    assert len(quick_trunks(needle)) == 0
    assert len(full_trunks(needle)) == 0


def test_sparse_points_are_sparse() -> None:
    shape = blob(11)
    chosen = sparse_points(shape, TrunkParameters())
    lengths = arc_length(shape.points)
    gaps = np.diff(np.append(lengths[chosen], lengths[chosen[0]] + lengths[-1]))
    assert gaps.max() < L_C / 15 + L_C / 100
    assert len(chosen) < 0.5 * len(shape.points)
