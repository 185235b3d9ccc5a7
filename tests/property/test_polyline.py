"""Properties of `riot.geometry.polyline`."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riot.geometry import polyline
from riot.kernels.simplify import TIE, halved
from riot.types import FloatArray


def star_shaped(seed: int, m: int = 60) -> FloatArray:
    """A simple counter-clockwise polygon around the origin."""
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0.0, 2.0 * np.pi, m))
    angle = angle[np.append(np.diff(angle) > 1e-3, True)]
    angle = np.unique(np.concatenate([angle, [0.0, 2.0, 4.0]]))
    radius = rng.uniform(0.5, 1.5, len(angle))
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


SEEDS = st.integers(0, 10_000)


@settings(max_examples=40)
@given(SEEDS, st.integers(0, 59), st.floats(0.0, 6.28), st.floats(0.1, 50.0), st.floats(0.01, 0.5))
def test_simplify_is_canonical(seed: int, turn: int, angle: float, scale: float, tolerance: float) -> None:
    points = star_shaped(seed)
    c, s = np.cos(angle), np.sin(angle)
    moved = np.roll(points, turn, axis=0) @ (scale * np.array([[c, s], [-s, c]])) + [3.0, -7.0]
    kept = polyline.simplify(points, tolerance)
    again = polyline.simplify(moved, scale * tolerance)
    assert set((again - turn) % len(points)) == set(kept)


@settings(max_examples=40)
@given(SEEDS, st.floats(0.0, 0.5))
def test_simplify_drops_only_what_is_near(seed: int, tolerance: float) -> None:
    points = star_shaped(seed)
    kept = polyline.simplify(points, tolerance)
    assert (np.diff(kept) > 0).all()
    for first, last in zip(kept, np.roll(kept, -1), strict=True):
        inner = np.arange(first + 1, last if last > first else last + len(points)) % len(points)
        a, b = points[first], points[last]
        t = np.clip((points[inner] - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        distance = np.linalg.norm(points[inner] - a - t[:, None] * (b - a), axis=1)
        assert (distance <= tolerance + 1e-12).all()


@settings(max_examples=30)
@given(SEEDS, st.floats(-100.0, 100.0))
def test_measures(seed: int, shift: float) -> None:
    points = star_shaped(seed) + shift
    assert polyline.signed_area(points) > 0.0
    assert polyline.signed_area(points[::-1]) == pytest.approx(-polyline.signed_area(points))
    assert polyline.centroid(points[::-1]) == pytest.approx(polyline.centroid(points))
    assert polyline.arc_length(points)[-1] == pytest.approx(polyline.edge_lengths(points).sum())
    assert polyline.interior_angles(points).sum() == pytest.approx((len(points) - 2) * np.pi)


@settings(max_examples=30)
@given(SEEDS, st.floats(0.02, 1.0))
def test_midpoints_are_closer_than_the_spacing(seed: int, spacing: float) -> None:
    points = star_shaped(seed)
    kept = polyline.simplify(points, 0.2)
    samples, is_kept = polyline.insert_midpoints(points, kept, spacing)
    assert (polyline.edge_lengths(samples) < spacing).all()
    assert np.array_equal(samples[is_kept], points[kept])
    indices = polyline.spread(samples, np.flatnonzero(is_kept), 4.0 * spacing)
    assert set(np.flatnonzero(is_kept)) <= set(indices)


def plainly_farthest(points: FloatArray, origin: FloatArray) -> int:
    square = ((points - origin) ** 2).sum(axis=1)
    tied = np.flatnonzero(square >= square.max() * (1.0 - TIE))
    return int(tied[np.lexsort((points[tied, 1], points[tied, 0]))[0]])


@settings(max_examples=60)
@given(SEEDS, st.floats(0.0, 0.6), st.booleans())
def test_simplify_is_douglas_peucker_on_both_halves(seed: int, tolerance: float, regular: bool) -> None:
    around = np.arange(36) * (np.pi / 18.0)
    # A regular polygon's vertices are all equally far from its centroid: the tie is decided by coordinates.
    points = np.column_stack([np.cos(around), np.sin(around)]) if regular else star_shaped(seed)
    m = len(points)
    first = plainly_farthest(points, polyline.centroid(points))
    second = plainly_farthest(points, points[first])
    assert polyline.farthest(points, polyline.centroid(points)) == first
    turned = np.concatenate([points[first:], points[: first + 1]])
    middle = (second - first) % m
    halves = [polyline.simplify_open(half, tolerance) for half in (turned[: middle + 1], turned[middle:])]
    expected = np.sort((np.concatenate([halves[0], middle + halves[1][1:-1]]) + first) % m)
    assert np.array_equal(polyline.simplify(points, tolerance), expected)


def test_simplify_takes_read_only_and_reversed_polygons() -> None:
    points = star_shaped(3)
    kept = polyline.simplify(points, 0.1)
    locked = points.copy()
    locked.flags.writeable = False
    assert np.array_equal(polyline.simplify(locked, 0.1), kept)
    assert np.array_equal(np.sort(len(points) - 1 - polyline.simplify(points[::-1], 0.1)), kept)
    assert polyline.simplify(np.zeros((4, 2)), 0.1).tolist() == [0]


@settings(max_examples=40)
@given(SEEDS, st.floats(0.01, 1.0))
def test_midpoints_halve_intervals(seed: int, spacing: float) -> None:
    starts = np.sort(np.random.default_rng(seed).uniform(0.0, 5.0, 7))
    positions, is_start = halved(starts, 6.0, spacing)
    expected: list[float] = []
    for start, interval in zip(starts, np.diff(np.append(starts, starts[0] + 6.0)), strict=True):
        divisions = 1
        while interval / divisions >= spacing:
            divisions *= 2
        expected += (start + np.arange(divisions) * (interval / divisions)).tolist()
    assert positions.tolist() == expected
    assert np.array_equal(positions[is_start], starts)


def test_square() -> None:
    square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 2.0], [0.0, 2.0]])
    assert polyline.signed_area(square) == 4.0
    assert polyline.centroid(square).tolist() == [1.0, 1.0]
    assert polyline.interior_angles(square) == pytest.approx(np.pi * np.array([0.5, 0.5, 1.0, 0.5, 0.5]))
    assert polyline.simplify(square, 0.1).tolist() == [0, 1, 3, 4]
    assert polyline.is_simple(square)
    assert not polyline.is_simple(square[[0, 3, 1, 4]])
    assert polyline.at_length(square, np.array([9.0])).tolist() == [[1.0, 0.0]]


def test_open_polyline_keeps_ends_and_spikes() -> None:
    line = np.array([[0.0, 0.0], [1.0, 0.0], [3.0, 0.0], [2.0, 0.0]])
    assert polyline.simplify_open(line, 0.5).tolist() == [0, 2, 3]


@given(st.floats(0.0, 6.28), st.booleans())
@settings(max_examples=30)
def test_sides_parallel_to_chords_keep_their_corners(angle: float, mirror: bool) -> None:
    # Every point of the flat top is equally far from the chord below it: rounding must not choose among them.
    corners = np.array([[0, 0], [20, 0], [17, 4], [12, 4], [11, 5], [6, 5], [4, 2]], dtype=float)
    dense = polyline.at_length(corners, np.arange(0.0, polyline.edge_lengths(corners).sum(), 0.11))
    expected = dense[polyline.simplify(dense, 0.3)]
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, s], [-s, c]]) @ np.diag([-1.0 if mirror else 1.0, 1.0])
    moved = dense @ turn
    moved = moved[::-1] if mirror else moved
    kept = moved[polyline.simplify(moved, 0.3)] @ np.linalg.inv(turn)
    gaps = np.hypot(*(kept[:, None] - expected[None]).transpose(2, 0, 1))
    assert len(kept) == len(expected)
    assert gaps.min(axis=1).max() < 1e-9
