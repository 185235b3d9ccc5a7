"""Reversibility scores: closed forms, invariance, and necks against an independent visibility test."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from riot.geometry.polyline import arc_length, centroid, insert_midpoints, signed_area
from riot.geometry.shape import Shape
from riot.kernels.segments import contains, inscribed
from riot.scores.reversibility import Reversibility, concave_points, cut_off, reversibility, roundness
from riot.types import FloatArray
from riot.units import D_C, L_C


def shape_of(corners: FloatArray, spacing: float = L_C / 100) -> Shape:
    """A unit-area, counter-clockwise, centred shape with points along every edge."""
    corners = np.asarray(corners, dtype=np.float64)
    corners = corners if signed_area(corners) > 0 else corners[::-1].copy()
    corners = corners / math.sqrt(signed_area(corners))
    points, feature = insert_midpoints(corners, np.arange(len(corners)), spacing)
    return Shape(points - centroid(points), feature)


def radial(seed: int, corners: int = 40) -> FloatArray:
    """A star-shaped polygon with random lobes."""
    rng = np.random.default_rng(seed)
    angle = np.arange(corners) * 2 * math.pi / corners
    radius = np.ones(corners)
    for k in range(2, 7):
        radius += rng.uniform(-0.22, 0.22) * np.sin(k * angle + rng.uniform(0, 6))
    return np.asarray(
        np.maximum(radius, 0.15)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1), dtype=np.float64
    )


def dumbbell(neck: float = 0.2, bar: float = 1.0) -> FloatArray:
    """Two unit squares joined by a bar of height ``neck`` and length ``bar``."""
    x, y = bar / 2, neck / 2
    right = [(x, -y), (x, -0.5), (x + 1, -0.5), (x + 1, 0.5), (x, 0.5), (x, y)]
    return np.array(right + [(-a, -b) for a, b in right])


def sorted_necks(shape: Shape, result: Reversibility) -> list[tuple[float, ...]]:
    ends = np.sort(result.necks, axis=1)
    rows = np.column_stack([result.neck_ratio, result.neck_width, result.waists])
    assert np.all(ends[:, 0] < ends[:, 1]) or not len(ends)
    return sorted(map(tuple, np.round(rows, 7)))


def test_a_disc_is_almost_one() -> None:
    angle = np.arange(200) * 2 * math.pi / 200
    result = reversibility(shape_of(np.stack([np.cos(angle), np.sin(angle)], axis=1)))
    assert result.score > 1 - 1e-6
    assert math.isnan(result.waist)
    assert result.necks.shape == (0, 2)
    assert result.necks.dtype == np.int64


@given(st.floats(0.05, 20))
@settings(max_examples=20)
def test_a_rectangle_has_the_closed_form(ratio: float) -> None:
    width = math.sqrt(ratio)
    shape = shape_of(np.array([[0, 0], [width, 0], [width, 1 / width], [0, 1 / width]]))
    result = reversibility(shape)
    excess = 2 * (width + 1 / width) / (2 * math.sqrt(math.pi)) - 1
    assert result.s1 == pytest.approx(math.exp(-(excess**2) / 2), rel=1e-12)
    assert result.s2 == 1.0
    assert result.score == result.s1 == pytest.approx(roundness(shape.perimeter), rel=1e-12)


@given(st.floats(0.05, 0.35), st.floats(0.1, 0.3))
@settings(max_examples=15)
def test_a_dumbbell_has_its_waist_at_the_bar(neck: float, bar: float) -> None:
    result = reversibility(shape_of(dumbbell(neck, bar)))
    # Straight across the bar at its end the shorter side is the outline of one square. A step s along the bar
    # gives (lobe + s) / √(neck² + s²), which is greatest at s = neck² / lobe.
    across = (3 + (1 - neck)) / neck
    assert across * (1 - 1e-9) <= result.waist <= math.sqrt(across**2 + 1) * (1 + 1e-9)
    assert result.waist == result.neck_ratio[result.waists].max()
    assert result.s2 == pytest.approx(math.exp(-((result.waist - 1) ** 2) / 32), rel=1e-12)


def test_a_narrow_limb_is_cut_off_and_a_wide_one_is_not() -> None:
    # A unit square with a thin limb on its right side.
    corners = np.array([(0, 0), (1, 0), (1, 0.45), (1.6, 0.45), (1.6, 0.55), (1, 0.55), (1, 1), (0, 1)])
    shape = shape_of(corners)
    result = reversibility(shape)
    mask = cut_off(shape, result)
    root = shape.points[np.isclose(shape.points[:, 0], shape.points[concave_points(shape.points, 0.01), 0].max())]
    limb = shape.points[:, 0] > root[:, 0].max() + 1e-9
    assert np.array_equal(mask, limb)
    assert not cut_off(shape, result, 0.05).any()
    assert 0 < mask.sum() < len(mask) / 2


def test_a_low_bump_is_not_cut_off() -> None:
    corners = np.array([(0, 0), (1, 0), (1, 0.45), (1.02, 0.5), (1, 0.55), (1, 1), (0, 1)])
    shape = shape_of(corners)
    assert not cut_off(shape, reversibility(shape)).any()


@given(st.integers(0, 10_000), st.floats(0, 2 * math.pi), st.integers(1, 150), st.booleans())
@settings(max_examples=20)
def test_invariance(seed: int, angle: float, start: int, mirror: bool) -> None:
    shape = shape_of(radial(seed))
    cos, sin = math.cos(angle), math.sin(angle)
    points = np.roll(shape.points, start, axis=0) @ np.array([[cos, sin], [-sin, cos]])
    feature = np.roll(shape.feature, start)
    if mirror:
        points, feature = (points * [-1, 1])[::-1].copy(), feature[::-1].copy()
    moved = Shape(points, feature)
    before, after = reversibility(shape), reversibility(moved)
    assert after.score == pytest.approx(before.score, rel=1e-9)
    assert after.waist == pytest.approx(before.waist, rel=1e-9, nan_ok=True)
    assert sorted_necks(moved, after) == sorted_necks(shape, before)
    cut = np.roll(cut_off(shape, before), start)
    assert np.array_equal(cut_off(moved, after), cut[::-1] if mirror else cut)


@given(st.integers(0, 10_000))
@settings(max_examples=8)
def test_necks_match_their_definition(seed: int) -> None:
    shape = shape_of(radial(seed))
    result = reversibility(shape)
    m = len(shape.points)
    polygon = shapely.Polygon(shape.points).buffer(1e-9)
    shapely.prepare(polygon)
    arc = arc_length(shape.points)
    concave = set(concave_points(shape.points, 0.01 * L_C).tolist())

    def ratio(p1: int, p: int) -> float:
        along = abs(arc[p] - arc[p1])
        return float(min(along, arc[-1] - along) / float(np.linalg.norm(shape.points[p] - shape.points[p1])))

    expected = set()
    for p1 in concave:
        for p2 in range(m):
            if (p2 - p1) % m in (0, 1, m - 1):
                continue
            beside = [ratio(p1, q) if q != p1 else 0.0 for q in ((p2 - 1) % m, (p2 + 1) % m)]
            if ratio(p1, p2) * (1 + 1e-9) < max(beside) or ratio(p1, p2) <= 1 + 1e-9:
                continue
            if polygon.covers(shapely.LineString(shape.points[[p1, p2]])):
                expected.add((min(p1, p2), max(p1, p2)))
    assert {(min(a, b), max(a, b)) for a, b in result.necks.tolist()} == expected
    for (p1, p2), value, wide in zip(result.necks.tolist(), result.neck_ratio, result.neck_width, strict=True):
        assert value == pytest.approx(ratio(p1, p2), rel=1e-12)
        assert wide == pytest.approx(np.linalg.norm(shape.points[p1] - shape.points[p2]), rel=1e-12)


@given(st.integers(0, 10_000), st.integers(0, 39), st.integers(0, 39))
@settings(max_examples=60)
def test_inscribed_agrees_with_shapely(seed: int, first: int, second: int) -> None:
    points = radial(seed)
    covered = shapely.Polygon(points).buffer(1e-9).covers(shapely.LineString(points[[first, second]]))
    assert inscribed(points, first, second, 1e-9) == (covered or first == second)


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        (0, 2, True),  # along two collinear edges
        (1, 5, True),  # touches nothing, straight through
        (5, 7, False),  # over the notch's mouth
        (0, 6, True),  # ends in the notch
        (2, 6, True),
        (1, 6, True),
        (8, 6, True),
        (4, 7, False),
        (3, 4, True),  # an edge
    ],
)
def test_inscribed_in_a_notched_square(first: int, second: int, expected: bool) -> None:
    notched = np.array([(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1.5, 2), (1, 1), (0.5, 2), (0, 2)], dtype=float)
    assert inscribed(notched, first, second, 1e-9) is expected
    assert inscribed(notched, second, first, 1e-9) is expected


def test_a_segment_through_a_vertex_into_the_outside_is_refused() -> None:
    # From (0, 0) straight through the tip (1, 1) of a notch: inside before it, inside after it.
    through = np.array([(0, 0), (2, 0), (2, 2), (1, 1), (0, 2)], dtype=float)
    assert inscribed(through, 0, 2, 1e-9)
    # The same line leaves this polygon at its convex vertex (1, 1) and comes back later.
    leaving = np.array([(0, 0), (2, 0), (3, 3), (2, 2), (1.6, 1.0), (1, 1)], dtype=float)
    assert not inscribed(leaving, 0, 3, 1e-9)


def test_contains_counts_the_boundary() -> None:
    square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=float)
    assert contains(square, 0.5, 0.5, 0.0)
    assert contains(square, 1.0, 0.5, 0.0)
    assert not contains(square, 1.0 + 1e-6, 0.5, 1e-9)


@given(st.integers(0, 10_000), st.floats(-1.2, 1.2), st.floats(-1.2, 1.2), st.sampled_from([0.0, 1e-9, 0.01, 0.2]))
@settings(max_examples=100)
def test_contains_agrees_with_shapely(seed: int, x: float, y: float, tolerance: float) -> None:
    points = radial(seed)
    region, point = shapely.Polygon(points), shapely.Point(x, y)
    if abs(region.distance(point) - tolerance) > 1e-9:
        assert contains(points, x, y, tolerance) == (region.distance(point) < tolerance or region.covers(point))
    for k in range(0, len(points), 7):
        assert contains(points, points[k, 0], points[k, 1], tolerance)


def test_default_width_is_the_papers() -> None:
    shape = shape_of(dumbbell(0.2))
    result = reversibility(shape)
    assert np.array_equal(cut_off(shape, result), cut_off(shape, result, 0.2 * D_C))
