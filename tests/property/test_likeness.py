"""Likeness: a metric that rotation, start vertex and, where asked, mirroring do not change; exact over all shifts."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from riot import Shape
from riot.scores.descriptor import ComplexArray, Descriptor, descriptor, outline_descriptor
from riot.scores.likeness import (
    OUTLINE_SHIFTS,
    REGION_SHIFTS,
    REGION_WEIGHT,
    DescriptorIndex,
    distance,
    margin,
    near_duplicates,
)
from riot.types import FloatArray

RESOLUTION = 0.04
"""What sampling may change; a ripple of the outline changes more (see the first test)."""

ROUNDING = 1e-6

SEEDS = st.integers(0, 300)


def lobes(seed: int, corners: int = 90, ripple: float = 0.0) -> FloatArray:
    rng = np.random.default_rng(seed)
    angle = np.arange(corners) * 2 * math.pi / corners
    waves = [rng.uniform(-0.18, 0.18) * np.sin(k * angle + rng.uniform(0, 6)) for k in range(2, 7)]
    radius = 1.0 + np.sum(waves, axis=0) + ripple * np.sin(9 * angle)
    return np.asarray(radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1), dtype=np.float64)


def turned(polygon: FloatArray, angle: float) -> FloatArray:
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    return np.asarray(polygon @ turn.T)


def described(polygon: FloatArray) -> Descriptor:
    return descriptor(Shape.from_polygon(polygon))


def index_of(seeds: range) -> DescriptorIndex:
    return DescriptorIndex.build([described(lobes(seed)) for seed in seeds])


@given(SEEDS)
def test_it_is_zero_for_the_same_outline_alone(seed: int) -> None:
    first, second = described(lobes(seed)), described(lobes(seed, ripple=0.15))
    assert distance(first, first) < ROUNDING
    assert distance(first, second, mirrored=True) > 2 * RESOLUTION


@given(SEEDS, st.booleans())
def test_it_is_symmetric(seed: int, mirrored: bool) -> None:
    first, second = described(lobes(seed)), described(lobes(seed + 1))
    assert distance(first, second, mirrored=mirrored) == pytest.approx(
        distance(second, first, mirrored=mirrored), abs=ROUNDING
    )


@given(SEEDS, st.booleans())
def test_it_obeys_the_triangle_inequality(seed: int, mirrored: bool) -> None:
    a, b, c = (described(lobes(seed + step)) for step in range(3))
    direct = distance(a, c, mirrored=mirrored)
    assert direct <= distance(a, b, mirrored=mirrored) + distance(b, c, mirrored=mirrored) + ROUNDING


@given(SEEDS, st.floats(0.0, 6.3), st.integers(0, 89), st.floats(0.1, 10.0))
def test_turning_scaling_and_the_start_vertex_change_nothing(seed: int, angle: float, start: int, scale: float) -> None:
    polygon = lobes(seed)
    other = scale * np.roll(turned(polygon, angle), start, axis=0) + 3.0
    assert distance(described(polygon), described(other)) < RESOLUTION


@given(SEEDS, st.floats(0.0, 6.3))
def test_mirroring_changes_nothing_where_asked(seed: int, angle: float) -> None:
    polygon = lobes(seed)
    first, second = described(polygon), described(turned(polygon * [-1.0, 1.0], angle)[::-1])
    assert distance(first, second, mirrored=True) < RESOLUTION


def test_mirroring_counts_otherwise() -> None:
    flag = np.array([(0, 0), (1, 0), (1, 3), (3, 3), (3, 4), (0, 4)], dtype=np.float64)
    first, second = described(flag), described(flag * [-1.0, 1.0])
    assert distance(first, second) > 2 * RESOLUTION > distance(first, second, mirrored=True)


@given(SEEDS)
def test_it_equals_brute_force_over_all_shifts(seed: int) -> None:
    first, second = described(lobes(seed)), described(lobes(seed + 1))

    def least(a: ComplexArray, b: ComplexArray, shifts: int) -> float:
        phase = np.exp(2j * np.pi * np.outer(np.arange(shifts), np.arange(a.shape[1])) / shifts)
        return min(float(np.linalg.norm(a * row - b)) for row in phase)

    slow = least(first.outline, second.outline, OUTLINE_SHIFTS) + REGION_WEIGHT * least(
        first.region, second.region, REGION_SHIFTS
    )
    assert distance(first, second) == pytest.approx(slow, abs=ROUNDING)


def test_the_index_finds_what_single_distances_order() -> None:
    index = index_of(range(30))
    query = described(lobes(77))
    singles = [distance(query, index.descriptor(number), mirrored=True) for number in range(len(index))]
    numbers, distances = index.nearest(query, 5, exclude=[int(np.argmin(singles))], mirrored=True)
    assert numbers.tolist() == np.argsort(singles)[1:6].tolist()
    assert distances.tolist() == [singles[number] for number in numbers]


def test_the_index_refuses_to_find_none() -> None:
    with pytest.raises(ValueError, match="at least"):
        index_of(range(2)).nearest(described(lobes(0)), 0)


def test_clusters_are_the_components_of_near_pairs_in_any_order() -> None:
    rng = np.random.default_rng(3)
    polygons = [lobes(seed) for seed in range(8)]
    polygons += [polygon + rng.normal(0.0, 0.003, polygon.shape) for polygon in polygons[:5]]
    stacked = DescriptorIndex.build([described(polygon) for polygon in polygons])
    expected = [*range(8), *range(5)]
    assert near_duplicates(stacked, 0.12).tolist() == expected
    for threshold in (0.12, 0.3, 0.5):
        clusters = near_duplicates(stacked, threshold, mirrored=True)
        order = rng.permutation(len(polygons))
        again = near_duplicates(stacked.subset(order), threshold, mirrored=True)
        together = clusters[:, None] == clusters
        assert ((again[:, None] == again) == together[np.ix_(order, order)]).all()
        near = np.array([stacked.distances(stacked.descriptor(k), mirrored=True) for k in range(len(stacked))])
        reach = near <= threshold
        for _ in range(len(polygons)):
            reach = reach @ reach
        assert (reach == together).all()


def test_a_collection_without_a_shape_has_no_cluster() -> None:
    assert near_duplicates(DescriptorIndex.build([]), 0.1).tolist() == []


def test_the_margin_falls_from_one_to_less_than_zero() -> None:
    index, groups = index_of(range(6)), np.array([0, 0, 1, 1, 2, 2])
    perfect = margin(index.descriptor(0), 0, index, groups)
    assert perfect.value == pytest.approx(1.0, abs=ROUNDING) and groups[perfect.nearest] != 0
    mistaken = margin(index.descriptor(2), 0, index, groups)
    assert mistaken.value < 0 and mistaken.nearest == 2
    alone = margin(index.descriptor(0), 0, index, np.zeros(6, dtype=np.int64))
    assert math.isnan(alone.value) and alone.nearest == -1


@given(SEEDS, st.integers(0, 5), st.sampled_from([(0, 0, 1, 1, 2, 2), (0, 1, 1, 1, 2, 3)]))
def test_recognised_is_what_the_nearest_shape_but_the_input_says(seed: int, own: int, things: tuple[int, ...]) -> None:
    index, groups = index_of(range(6)), np.array(things)
    result = descriptor(Shape.from_polygon(lobes(seed)))
    alone = things.count(things[own]) == 1
    nearest = next(k for k in np.argsort(index.distances(result)).tolist() if k != own or alone)
    assert margin(result, own, index, groups).recognised == (groups[nearest] == groups[own])


@given(SEEDS, st.floats(0.1, 10.0))
def test_an_outline_has_the_descriptor_of_its_shape(seed: int, scale: float) -> None:
    shape = Shape.from_polygon(lobes(seed))
    assert distance(descriptor(shape), outline_descriptor(scale * shape.points + 2.0)) < ROUNDING
    with pytest.raises(ValueError, match="counter-clockwise"):
        outline_descriptor(shape.points[::-1])


def test_an_index_comes_back_from_its_arrays() -> None:
    index = index_of(range(3))
    again = DescriptorIndex.from_arrays(index.to_arrays())
    assert [again.descriptor(k) for k in range(3)] == [index.descriptor(k) for k in range(3)]
