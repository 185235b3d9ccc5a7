"""Exact pairs are exact: the theorem, piece by piece."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from riot.geometry.polyline import centroid, edge_lengths, interior_angles, is_simple, signed_area
from riot.groundtruth.pairs import TOPOLOGIES, ExactPair, Topology, dudeney, exact_pair, exact_transform
from riot.transform.certificate import certify
from riot.transform.pose import rotate
from riot.types import FloatArray

pairs = st.builds(
    lru_cache(exact_pair),  # the tests below ask for the same ones
    st.integers(3, 6),
    st.integers(0, 2),
    curved=st.booleans(),
    topology=st.sampled_from(TOPOLOGIES),
)
few = settings(max_examples=12)


def assembled(pair: ExactPair, trunk: FloatArray) -> list[FloatArray]:
    """Every piece's polygon, its edge laid on the edge of a trunk."""
    placed = []
    for j, piece in enumerate(pair.pieces):
        edge = trunk[(j + 1) % len(trunk)] - trunk[j]
        placed.append(rotate(piece.polygon, math.atan2(edge[1], edge[0])) + trunk[j])
    return placed


def lower_part(pair: ExactPair, j: int) -> FloatArray:
    return pair.pieces[j].lower


def upper_part(pair: ExactPair, j: int) -> FloatArray:
    return pair.pieces[j].upper


def angle_at(polygon: FloatArray, vertices: FloatArray) -> FloatArray:
    """Interior angles of a counter-clockwise polygon at those of its vertices."""
    nearest = [int(np.argmin(np.hypot(*(polygon - v).T))) for v in vertices]
    assert np.abs(polygon[nearest] - vertices).max() < 1e-12
    return interior_angles(polygon)[nearest]


def corners(polygon: FloatArray) -> FloatArray:
    """Vertices at which a convex polygon turns."""
    return polygon[interior_angles(polygon) < math.pi - 1e-6]


@given(pairs)
@few
def test_both_shapes_are_proper(pair: ExactPair) -> None:
    for polygon in (pair.p, pair.q):
        assert is_simple(polygon)
        assert signed_area(polygon) == pytest.approx(1.0, abs=1e-12)
        assert np.abs(centroid(polygon)).max() < 1e-12


@given(pairs)
@few
def test_trunks_are_convex_conjugate_and_inscribed(pair: ExactPair) -> None:
    assert signed_area(pair.trunk_p) > 0 > signed_area(pair.trunk_q)
    assert np.abs(edge_lengths(pair.trunk_p) - edge_lengths(pair.trunk_q)).max() < 1e-14 * 10
    assert signed_area(pair.trunk_p) - signed_area(pair.trunk_q) == pytest.approx(1.0, abs=1e-13)
    for polygon, trunk in ((pair.p, pair.trunk_p), (pair.q, pair.trunk_q[::-1])):
        assert interior_angles(trunk.copy()).max() < math.pi
        assert shapely.Polygon(polygon).buffer(1e-9).covers(shapely.Polygon(trunk))
        # Counter-clockwise along the outline too.
        order = [int(np.argmin(np.hypot(*(polygon - v).T))) for v in trunk]
        turned = np.roll(order, -int(np.argmin(order)))
        assert np.all(np.diff(turned) > 0)


@given(pairs)
@few
def test_exterior_pieces_of_each_tile_the_trunk_of_the_other(pair: ExactPair) -> None:
    n = len(pair.pieces)
    lower = sum(signed_area(lower_part(pair, j)) for j in range(n))
    upper = sum(signed_area(upper_part(pair, j)) for j in range(n))
    assert lower == pytest.approx(-signed_area(pair.trunk_q), abs=1e-13)
    assert upper == pytest.approx(signed_area(pair.trunk_p), abs=1e-13)
    for j, piece in enumerate(pair.pieces):
        assert piece.lower[:, 1].max() <= 1e-12
        assert piece.upper[:, 1].min() >= -1e-12
        assert piece.length == pytest.approx(math.dist(pair.trunk_p[j], pair.trunk_p[(j + 1) % n]), abs=1e-13)


@given(pairs)
@few
def test_the_pieces_make_both_shapes_without_gap_or_overlap(pair: ExactPair) -> None:
    for outline, trunk in ((pair.p, pair.trunk_p), (pair.q, pair.trunk_q)):
        polygons = [shapely.Polygon(piece) for piece in assembled(pair, trunk)]
        whole = shapely.Polygon(outline)
        assert all(polygon.is_valid for polygon in polygons)
        # Areas of unions, since `intersection` is unreliable along a shared noisy edge.
        for a, first in enumerate(polygons):
            for second in polygons[a + 1 :]:
                assert abs(first.area + second.area - shapely.union(first, second).area) < 1e-11
        union = shapely.union_all([*polygons])
        assert abs(union.area - 1.0) < 1e-11
        assert abs(shapely.union(union, whole).area - 1.0) < 1e-11


@given(pairs)
@few
def test_certificate_of_the_transform(pair: ExactPair) -> None:
    transform = exact_transform(pair)
    assert certify(transform).passed
    assert np.abs(transform.outline_p() - pair.p).max() < 1e-12
    distance = shapely.hausdorff_distance(shapely.LinearRing(transform.outline_q()), shapely.LinearRing(pair.q))
    assert distance < 1e-12


@given(pairs)
@few
def test_angles_about_every_hinge_make_a_full_turn(pair: ExactPair) -> None:
    alpha = interior_angles(pair.trunk_p)
    conjugate = interior_angles(pair.trunk_q[::-1].copy())[::-1]
    theta = 2 * math.pi - angle_at(pair.p, pair.trunk_p)
    theta_bar = 2 * math.pi - angle_at(pair.q, pair.trunk_q)
    assert np.abs(theta + alpha + conjugate - 2 * math.pi).max() < 1e-9
    assert np.abs(theta_bar + alpha + conjugate - 2 * math.pi).max() < 1e-9
    # Theory §1.3: the sum is a quantity of each trunk alone.
    assert theta.sum() == pytest.approx(4 * math.pi, abs=1e-9)
    assert theta_bar.sum() == pytest.approx(4 * math.pi, abs=1e-9)


@given(st.integers(3, 5), st.integers(0, 1000), st.sampled_from(TOPOLOGIES))
@settings(max_examples=8)
def test_straight_pieces_are_convex(n: int, seed: int, topology: Topology) -> None:
    pair = exact_pair(n, seed, curved=False, topology=topology)
    for j in range(n):
        for half in (lower_part(pair, j), upper_part(pair, j)):
            assert interior_angles(half).max() <= math.pi + 1e-9


def test_the_seed_decides_everything() -> None:
    first, again, other = exact_pair(4, 7), exact_pair(4, 7), exact_pair(4, 8)
    for a, b in zip(
        [first.p, first.q, first.trunk_p, first.trunk_q], [again.p, again.q, again.trunk_p, again.trunk_q], strict=True
    ):
        assert a.tobytes() == b.tobytes()
    assert first.p.shape != other.p.shape or not np.allclose(first.p, other.p)
    star, binary = exact_pair(5, 7, topology="star"), exact_pair(5, 7, topology="binary")
    assert star.p.shape != binary.p.shape or not np.allclose(star.p, binary.p)


def test_seven_pieces_too() -> None:
    for seed in range(3):
        assert certify(exact_transform(exact_pair(7, seed))).passed


def test_wrong_arguments_say_what_is_allowed() -> None:
    with pytest.raises(ValueError, match="n ≥ 3"):
        exact_pair(2, 0)
    with pytest.raises(ValueError, match="star, binary, random"):
        exact_pair(3, 0, topology="bush")  # type: ignore[arg-type]


def test_dudeney() -> None:
    pair = dudeney()
    scale = math.sqrt(math.sqrt(3) / 4)  # back to the triangle of side 1
    triangle, square = corners(pair.p * scale), corners(pair.q * scale)
    assert len(triangle) == 3
    assert np.allclose(edge_lengths(triangle), 1.0, rtol=0, atol=1e-14)
    assert len(square) == 4
    assert np.allclose(edge_lengths(square), 0.658037006, rtol=0, atol=1e-9)
    assert np.allclose(interior_angles(square), math.pi / 2, rtol=0, atol=1e-13)
    for polygon in (pair.p, pair.q):
        assert signed_area(polygon * scale) == pytest.approx(0.433012701892219, abs=1e-13)
    # The published hinges E, Q, P, F, and junctions R, S, in the frame whose origin is corner A.
    corner = pair.p[np.argmin(pair.p @ [2.0, 1.0])] * scale
    expected = [
        (0.25, math.sqrt(3) / 4),
        (0.245492383283759, 0),
        (0.745492383283759, 0),
        (0.75, math.sqrt(3) / 4),
    ]
    assert np.allclose(pair.trunk_p * scale - corner, expected, atol=1e-14)
    points = np.concatenate(assembled(pair, pair.trunk_p)) * scale - corner
    for x, y in [(0.533493649053890, 0.185266510250340), (0.461998734229868, 0.247746191641879)]:
        assert np.hypot(points[:, 0] - x, points[:, 1] - y).min() < 1e-14
    empty = [abs(signed_area(lower_part(pair, j))) < 1e-15 for j in range(4)]
    assert empty == [False, True, False, False]
    assert certify(exact_transform(pair)).passed
