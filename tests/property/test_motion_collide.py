"""The collision kernel against shapely, and the stretches that it proves free against dense sampling."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from riot.kernels.collide import clear_share, separation
from riot.types import FloatArray, IntArray


def blob(rng: np.random.Generator, size: float = 1.0) -> FloatArray:
    """A simple polygon, seldom convex."""
    count = int(rng.integers(3, 25))
    angles = np.sort(2.0 * np.pi * (np.arange(count) + 0.8 * rng.random(count)) / count)
    radii = size * (0.2 + rng.random(count))
    return np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)


def packed(bodies: list[list[FloatArray]]) -> tuple[FloatArray, IntArray, IntArray]:
    rings = [ring for body in bodies for ring in body]
    points = np.concatenate([np.empty((0, 2)), *rings])
    return points, offsets([len(ring) for ring in rings]), offsets([len(body) for body in bodies])


def offsets(sizes: list[int]) -> IntArray:
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


def placed(points: FloatArray, placement: FloatArray) -> FloatArray:
    c, s = np.cos(placement[2]), np.sin(placement[2])
    return points @ np.array([[c, s], [-s, c]]) + placement[:2]


@settings(max_examples=150)
@given(st.integers(0, 2**32 - 1))
def test_distance_and_overlap_are_shapelys(seed: int) -> None:
    rng = np.random.default_rng(seed)
    # A body of two parts, and one that may lie within another.
    first = [blob(rng), blob(rng, 0.4) + np.array([3.0, 0.0])]
    second = [blob(rng, float(rng.choice([0.1, 1.0])))]
    placement = np.array([*rng.uniform(-4.0, 4.0, 2), rng.uniform(-7.0, 7.0)])
    mine = separation(*packed([first, second]), 0, 1, placement, 100.0)
    first_region = shapely.MultiPolygon([shapely.Polygon(ring) for ring in first])
    second_region = shapely.Polygon(placed(second[0], placement))
    assert mine == pytest.approx(first_region.distance(second_region), abs=1e-12)
    assert (mine == 0.0) == first_region.intersects(second_region)
    # With a cap: the same below it, no less than it above.
    capped = separation(*packed([first, second]), 0, 1, placement, 0.5)
    assert capped == pytest.approx(mine, abs=1e-12) if mine < 0.5 else capped >= 0.5


def test_an_empty_body_meets_nothing() -> None:
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    for bodies in ([[square], []], [[], [square]]):
        assert separation(*packed(bodies), 0, 1, np.zeros(3), 1.0) == np.inf


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1))
def test_what_is_proven_free_is_free_and_ends_where_something_is_met(seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, floor = int(rng.integers(2, 5)), 1e-3
    lengths = rng.uniform(0.8, 1.2, m)
    middles = np.stack([0.5 * lengths, np.zeros(m)], axis=1)
    # Thin pieces that keep off their hinges, so that there is room to move.
    rings = [blob(rng) * [0.3, 0.15] + middle for middle in middles]
    arrays = packed([[ring] for ring in rings for _ in range(3)])
    reaches = np.array(
        [
            [np.hypot(*(ring - [x, 0.0]).T).max() for x in (0.0, length)]
            for ring, length in zip(rings, lengths, strict=True)
        ]
    )
    before, after = np.zeros(m - 1), rng.uniform(-3.0, 3.0, m - 1)
    share, checks = clear_share(*arrays, lengths, reaches, before, after, floor, 0.3, False)
    assert checks > 0

    def least(t: float) -> float:
        heading, at, parts = 0.0, np.zeros(2), []
        for k, ring in enumerate(rings):
            heading += 0.0 if k == 0 else before[k - 1] + t * (after[k - 1] - before[k - 1])
            parts.append(shapely.Polygon(placed(ring, np.array([*at, heading]))))
            at = at + lengths[k] * np.array([np.cos(heading), np.sin(heading)])
        return min(parts[i].distance(parts[k]) for k in range(m) for i in range(k))

    assert all(least(share * t) > 0.0 for t in np.linspace(0.0, 1.0, 100)[:-1])
    assert share == 1.0 or least(share) < floor
    whole, _ = clear_share(*arrays, lengths, reaches, before, after, floor, 0.3, True)
    assert (whole == 1.0) == (share == 1.0)
