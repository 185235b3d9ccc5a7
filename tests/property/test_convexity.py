"""Convexity: closed forms, invariance, and the hull against shapely's; the stage's table agrees with the function."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from pipeline.stages.convexity import STAGE
from pipeline.stages.shape_arrays import pack_shapes
from pipeline.store.artifact import Artifact
from riot import Shape
from riot.parameters import ConvexityParameters
from riot.scores.convexity import Convexity, convexity
from riot.types import FloatArray
from riot.units import D_C


def lobes(seed: int, corners: int = 40) -> FloatArray:
    rng = np.random.default_rng(seed)
    angle = np.arange(corners) * 2 * math.pi / corners
    radius = 1.0 + sum(rng.uniform(-0.15, 0.15) * np.sin(k * angle + rng.uniform(0, 6)) for k in range(2, 7))
    return np.asarray(radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1), dtype=np.float64)


def star(points: int, inner: float) -> FloatArray:
    angle = np.arange(2 * points) * math.pi / points
    radius = np.where(np.arange(2 * points) % 2, inner, 1.0)
    return np.asarray(radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1), dtype=np.float64)


@given(st.integers(3, 12))
def test_a_regular_polygon_is_convex(corners: int) -> None:
    measured = convexity(Shape.from_polygon(star(corners, math.cos(math.pi / corners))))
    assert measured.solidity == pytest.approx(1.0, abs=1e-9) and measured.concavities == 0


@given(st.integers(4, 9), st.floats(0.3, 0.5))
def test_a_star_has_a_concavity_between_any_two_points(points: int, inner: float) -> None:
    outer = star(points, math.cos(math.pi / points))
    measured = convexity(Shape.from_polygon(star(points, inner)))
    areas = [shapely.Polygon(star(points, inner)).area, shapely.Polygon(outer).area]
    assert measured == Convexity(pytest.approx(areas[0] / areas[1], rel=1e-9), points)  # type: ignore[arg-type]


@given(st.integers(0, 500))
def test_it_is_what_shapely_finds(seed: int) -> None:
    shape, depth = Shape.from_polygon(lobes(seed)), ConvexityParameters().depth * D_C
    polygon = shapely.Polygon(shape.points)
    hull = polygon.convex_hull
    pockets = [pocket for pocket in shapely.get_parts(hull.difference(polygon)) if pocket.area > 1e-9]
    far = [max(hull.exterior.distance(shapely.points(pocket.exterior.coords))) for pocket in pockets]
    measured = convexity(shape)
    assert measured.solidity == pytest.approx(polygon.area / hull.area, rel=1e-9)
    assert sum(np.array(far) > 1.02 * depth) <= measured.concavities <= sum(np.array(far) > 0.5 * depth)


@given(st.integers(0, 500), st.floats(0.0, 6.3), st.booleans())
def test_turning_and_mirroring_change_nothing(seed: int, angle: float, mirrored: bool) -> None:
    polygon = lobes(seed)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    other = polygon @ turn.T * ([-1.0, 1.0] if mirrored else [1.0, 1.0])
    depth = ConvexityParameters(depth=0.0401)
    first, second = convexity(Shape.from_polygon(polygon), depth), convexity(Shape.from_polygon(other), depth)
    assert first.solidity == pytest.approx(second.solidity, rel=1e-9) and first.concavities == second.concavities


def test_a_deeper_limit_counts_fewer() -> None:
    shape = Shape.from_polygon(star(5, 0.5))
    assert [convexity(shape, ConvexityParameters(depth=depth)).concavities for depth in (0.0, 0.05, 0.9)] == [5, 5, 0]


def test_the_stage_measures_every_shape_of_a_batch() -> None:
    shapes = [Shape.from_polygon(star(5, 0.4)), None, Shape.from_polygon(star(6, 1.0))]
    artifact = STAGE.run([Artifact(pack_shapes(shapes), {"errors": []})], [ConvexityParameters()], None)
    (added,) = STAGE.tables
    columns = added.values(artifact)
    assert columns["concavities"].tolist() == [5, -1, 0] and math.isnan(columns["solidity"][1])
    assert columns["solidity"][0] == convexity(Shape.from_polygon(star(5, 0.4))).solidity
    assert {column.name for column in added.columns} == columns.keys() and artifact.document == {"errors": []}
