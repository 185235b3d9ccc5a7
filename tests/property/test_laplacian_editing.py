"""Laplacian editing of polylines: what must and must not change a curve (Sorkine et al. 2004; paper §4.3)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riot.construction.laplacian.editing import edit
from riot.types import BoolArray, FloatArray

SEEDS = st.integers(0, 10_000)


def curve(rng: np.random.Generator, m: int) -> FloatArray:
    """A wavy polyline (m, 2) from left to right, unevenly sampled."""
    t = np.sort(rng.uniform(0.0, 1.0, m))
    waves = rng.uniform(-0.1, 0.1, 4)
    height = sum(size * np.sin((k + 1) * math.pi * t) for k, size in enumerate(waves))
    return np.column_stack([t, height + 0.01 * rng.normal(size=m)])


def some_handles(rng: np.random.Generator, m: int) -> BoolArray:
    """Both ends and about a fifth of the rest."""
    handles = rng.random(m) < 0.2
    handles[[0, -1]] = True
    return handles


def similarity(rng: np.random.Generator, scale: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """Matrix and shift; points are rows and stand on the left."""
    angle = rng.uniform(0.0, 2.0 * math.pi)
    c, s = scale * math.cos(angle), scale * math.sin(angle)
    return np.array([[c, s], [-s, c]]), rng.normal(size=2)


@given(SEEDS, st.integers(3, 80))
@settings(max_examples=30)
def test_handles_that_stay_leave_the_curve_as_it_is(seed: int, m: int) -> None:
    rng = np.random.default_rng(seed)
    points = curve(rng, m)
    assert np.array_equal(edit(points, some_handles(rng, m), points), points)


@given(SEEDS, st.integers(3, 80))
@settings(max_examples=30)
def test_handles_are_met_exactly(seed: int, m: int) -> None:
    rng = np.random.default_rng(seed)
    points, handles = curve(rng, m), some_handles(rng, m)
    targets = points + 0.1 * rng.normal(size=(m, 2))
    assert np.array_equal(edit(points, handles, targets)[handles], targets[handles])


@given(SEEDS, st.integers(3, 80))
@settings(max_examples=30)
def test_editing_turns_and_moves_with_the_plane(seed: int, m: int) -> None:
    rng = np.random.default_rng(seed)
    points, handles = curve(rng, m), some_handles(rng, m)
    targets = points + 0.05 * rng.normal(size=(m, 2))
    turn, shift = similarity(rng)
    here, there = edit(points, handles, targets), edit(points @ turn + shift, handles, targets @ turn + shift)
    assert there == pytest.approx(here @ turn + shift, abs=1e-7)


@given(SEEDS, st.integers(3, 80))
@settings(max_examples=30)
def test_handles_moved_by_a_similarity_take_the_whole_curve_along(seed: int, m: int) -> None:
    # What makes the editing rotation-aware: plain Laplacian coordinates would shear the curve.
    rng = np.random.default_rng(seed)
    points, handles = curve(rng, m), some_handles(rng, m)
    turn, shift = similarity(rng, rng.uniform(0.5, 2.0))
    assert edit(points, handles, points @ turn + shift) == pytest.approx(points @ turn + shift, abs=1e-6)


def plain_edit(points: FloatArray, handles: BoolArray, targets: FloatArray) -> FloatArray:
    """The definition of Sorkine et al.: dense, real, every vertex's similarity fitted by a pseudo-inverse."""
    m = len(points)
    rows = np.zeros((2 * (m - 2), 2 * m))
    for k in range(1, m - 1):
        three = [k - 1, k, k + 1]
        columns = [2 * j + axis for j in three for axis in (0, 1)]
        # x' = s x − h y + a, y' = h x + s y + b
        model = np.array([row for x, y in points[three] for row in ([x, -y, 1.0, 0.0], [y, x, 0.0, 1.0])])
        fitted = np.linalg.pinv(model)[:2]
        x, y = points[k] - 0.5 * (points[k - 1] + points[k + 1])
        block = -np.array([[x, -y], [y, x]]) @ fitted
        block[:, 2:4] += np.eye(2)
        block[:, :2] -= 0.5 * np.eye(2)
        block[:, 4:] -= 0.5 * np.eye(2)
        rows[2 * k - 2 : 2 * k, columns] = block
    known = np.repeat(handles, 2)
    solution = targets.ravel().copy()
    solution[~known] = np.linalg.lstsq(rows[:, ~known], -rows[:, known] @ solution[known], rcond=None)[0]
    return solution.reshape(m, 2)


@given(SEEDS, st.integers(4, 30))
@settings(max_examples=20)
def test_editing_is_the_least_squares_of_its_definition(seed: int, m: int) -> None:
    rng = np.random.default_rng(seed)
    points, handles = curve(rng, m), some_handles(rng, m)
    targets = points + 0.05 * rng.normal(size=(m, 2))
    assert edit(points, handles, targets) == pytest.approx(plain_edit(points, handles, targets), abs=1e-6)


def test_a_spike_whose_sides_coincide_stays_where_nothing_moves_it() -> None:
    points = np.array([[0.0, 0.0], [0.3, 0.0], [0.5, 0.0], [0.5, 1.0], [0.5, 0.0], [0.7, 0.0], [1.0, 0.0]])
    handles = np.array([True, False, False, False, False, False, True])
    targets = points + np.array([0.0, 0.1])
    edited = edit(points, handles, targets)
    assert np.isfinite(edited).all()
    assert np.array_equal(edit(points, handles, points), points)
    assert np.abs(edited - points).max() < 1.0


def test_one_handle_is_refused() -> None:
    points = curve(np.random.default_rng(1), 10)
    with pytest.raises(ValueError, match="two handles"):
        edit(points, np.arange(10) == 3, points)
