"""A shape does not depend on where, how large, how turned or from which vertex its source was given."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from riot.geometry import polyline
from riot.geometry.shape import Shape
from riot.geometry.silhouette import mask_shape, polygon_shape
from riot.parameters import ShapeParameters
from riot.types import FloatArray
from riot.units import L_C

SEEDS = st.integers(0, 10_000)


def blob(seed: int, m: int = 150) -> FloatArray:
    """A smooth lobed counter-clockwise polygon without symmetry."""
    rng = np.random.default_rng(seed)
    t = np.arange(m) * (2.0 * np.pi / m)
    radius = 1.0 + sum(rng.uniform(-0.12, 0.12) * np.cos(k * t + rng.uniform(0.0, 6.0)) for k in range(1, 7))
    return np.column_stack([radius * np.cos(t), radius * np.sin(t)])


def drawn(polygon: FloatArray, side: int = 200) -> FloatArray:
    """The polygon as a picture, 255 on 0, by pixel centres."""
    low, extent = polygon.min(axis=0), np.ptp(polygon, axis=0).max()
    placed = shapely.Polygon((polygon - low) * ((side - 20) / extent) + 10.0)
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    return np.where(shapely.contains_xy(placed, x.ravel(), y.ravel()).reshape(side, side), 255.0, 0.0)


def iou(outline: FloatArray, other: FloatArray) -> float:
    a, b = shapely.Polygon(outline), shapely.Polygon(other)
    return float(a.intersection(b).area / a.union(b).area)


def check_invariants(shape: Shape) -> None:
    assert polyline.is_simple(shape.points)
    assert polyline.signed_area(shape.points) == pytest.approx(1.0, abs=1e-12)
    assert polyline.centroid(shape.points) == pytest.approx([0.0, 0.0], abs=1e-12)
    assert polyline.edge_lengths(shape.points).max() < L_C / 100.0
    assert shape.feature[0]
    assert shape.points.shape == (len(shape.feature), 2)


@settings(max_examples=40)
@given(SEEDS, st.floats(0.0, 6.28), st.floats(1e-3, 1e3), st.floats(-100.0, 100.0), st.integers(0, 149), st.booleans())
def test_polygon_shape_is_canonical(
    seed: int, angle: float, scale: float, shift: float, turn: int, reverse: bool
) -> None:
    polygon = blob(seed)
    shape = polygon_shape(polygon)
    check_invariants(shape)
    c, s = np.cos(angle), np.sin(angle)
    rotation = np.array([[c, -s], [s, c]])
    moved = np.roll(polygon, turn, axis=0) @ (scale * rotation.T) + scale * shift
    other = polygon_shape(moved[::-1] if reverse else moved)
    # Tight: rounding only, of coordinates up to a hundred sizes away from the origin.
    assert np.array_equal(other.feature, shape.feature)
    assert other.points == pytest.approx(shape.points @ rotation.T, abs=1e-10)
    assert other.source(other.points) == pytest.approx(
        shape.source(shape.points) @ (scale * rotation.T) + scale * shift, abs=1e-9 * scale
    )


@settings(max_examples=20)
@given(SEEDS)
def test_sampling_is_faithful(seed: int) -> None:
    polygon = blob(seed)
    shape = polygon_shape(polygon)
    assert iou(shape.source(shape.points), polygon) > 0.9997
    coarse = polygon_shape(polygon, parameters=ShapeParameters(vertex_tolerance=1.0))
    assert coarse.feature.sum() == shape.feature.sum()
    assert iou(coarse.source(coarse.points), polygon) > 0.995
    everything = polygon_shape(polygon, parameters=ShapeParameters(feature_tolerance=0.0))
    assert everything.feature.sum() == len(polygon)
    assert iou(everything.source(everything.points), polygon) == pytest.approx(1.0, abs=1e-12)


@settings(max_examples=12)
@given(SEEDS, st.integers(0, 3), st.tuples(*[st.integers(0, 30)] * 4))
def test_picture_padding_polarity_and_quarter_turns(seed: int, turns: int, pads: tuple[int, int, int, int]) -> None:
    picture = drawn(blob(seed))
    shape = mask_shape(picture)
    check_invariants(shape)
    padded = mask_shape(np.pad(picture, ((pads[0], pads[1]), (pads[2], pads[3]))))
    # The same pixels: only the place in the picture differs.
    assert padded.points == pytest.approx(shape.points, abs=1e-10)
    assert mask_shape(255.0 - picture).points == pytest.approx(shape.points, abs=1e-10)
    assert mask_shape(picture > 100.0).points == pytest.approx(shape.points, abs=1e-10)
    turned = mask_shape(np.rot90(picture, turns))
    c, s = np.round([np.cos(turns * np.pi / 2), np.sin(turns * np.pi / 2)])
    # Looser: where two features are equally good, the choice may differ.
    assert iou(turned.points, shape.points @ np.array([[c, s], [-s, c]])) > 0.995


@settings(max_examples=10)
@given(SEEDS, st.integers(2, 6))
def test_picture_scale(seed: int, factor: int) -> None:
    picture = drawn(blob(seed), 160)
    shape = mask_shape(picture)
    enlarged = mask_shape(np.kron(picture, np.ones((factor, factor))))
    # The blur is some pixels of the picture, hence less of an enlarged one.
    assert iou(enlarged.points, shape.points) > 0.985


@settings(max_examples=12)
@given(SEEDS)
def test_picture_agrees_with_the_outline_it_was_drawn_from(seed: int) -> None:
    polygon = blob(seed)
    picture = drawn(polygon)
    shape = mask_shape(picture)
    inside = shapely.Polygon(shape.source(shape.points))
    assert inside.area == pytest.approx((picture > 0).sum(), rel=0.01)
    # y runs upwards in a shape and downwards in a picture: rows were drawn as y here, so the shape is the mirror image.
    mirrored = polygon_shape(polygon * [1.0, -1.0])
    assert iou(shape.points, mirrored.points) > 0.975


@settings(max_examples=8)
@given(SEEDS)
def test_a_shape_made_again_of_a_shape_is_nearly_the_same(seed: int) -> None:
    shape = polygon_shape(blob(seed))
    again = polygon_shape(shape.points)
    assert iou(again.points, shape.points) > 0.995
    assert again.points[0] == pytest.approx(shape.points[0], abs=0.02)
