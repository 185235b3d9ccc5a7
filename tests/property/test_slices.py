"""Cutting solids: areas, volumes, scale and turns; the assignment against trying all; the depth buffer against rays."""

from __future__ import annotations

import math
from itertools import permutations
from typing import get_args

import manifold3d
import numpy as np
import numpy.typing as npt
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from riot.draw.depth_buffer import nearest_triangles
from riot.draw.solid import Body, Eye, prisms, render
from riot.slices import Cut, Model, ModelError, cut
from riot.slices.assign import assign
from riot.slices.cut import AXES, Axis, section
from riot.types import BoolArray, FloatArray

CYLINDER_SIDES = 64
SPAN = st.floats(5.0, 80.0)
COUNT = st.integers(1, 9)
THICKNESS = st.integers(30, 150).map(lambda layers: layers * 0.2)


def box(a: float, b: float, c: float) -> Model:
    return Model("box", manifold3d.Manifold.cube((a, b, c)).translate((3.0, -7.0, 11.0)))


def torus() -> Model:
    """Around the z-axis, radii 30 and 10 mm."""
    ring = manifold3d.CrossSection.circle(10.0, CYLINDER_SIDES).translate((30.0, 0.0))
    return Model("torus", manifold3d.Manifold.revolve(ring, CYLINDER_SIDES))


def ellipsoid(a: float, b: float, c: float) -> Model:
    return Model("ellipsoid", manifold3d.Manifold.sphere(1.0, 3 * CYLINDER_SIDES).scale((a, b, c)))


def blob() -> Model:
    """Nothing symmetric about it."""
    solid = manifold3d.Manifold.sphere(20.0, 32).scale((1.0, 0.7, 1.3))
    solid += manifold3d.Manifold.cube((30.0, 12.0, 9.0)).rotate((20.0, 30.0, 40.0))
    return Model("blob", solid + manifold3d.Manifold.cylinder(25.0, 6.0, 2.0, 24).translate((8.0, 9.0, 12.0)))


def disc_area(radius: float) -> float:
    """Of the polygon that stands for a disc."""
    return 0.5 * CYLINDER_SIDES * math.sin(2.0 * math.pi / CYLINDER_SIDES) * radius**2


@settings(max_examples=25)
@given(SPAN, SPAN, SPAN, COUNT, THICKNESS, st.sampled_from(AXES))
def test_slices_of_a_box_are_its_face(a: float, b: float, c: float, count: int, thickness: float, along: Axis) -> None:
    stack = cut(box(a, b, c), Cut(count, thickness, along=along))
    height, face = {"x": (a, b * c), "y": (b, c * a), "z": (c, a * b)}[along]
    assert stack.scale == pytest.approx(count * stack.thickness / height)
    assert [slice_.area for slice_ in stack.slices] == pytest.approx([face * stack.scale**2] * count)
    assert stack.iou == pytest.approx(1.0)
    assert [slice_.filled + slice_.lost for slice_ in stack.slices] == pytest.approx([0.0] * count, abs=1e-6)


@settings(max_examples=15)
@given(COUNT, THICKNESS, st.floats(10.0, 40.0), st.floats(0.0, 1.0))
def test_slices_of_a_cone_and_a_cylinder_are_discs(count: int, thickness: float, radius: float, top: float) -> None:
    solid = manifold3d.Manifold.cylinder(50.0, radius, top * radius, CYLINDER_SIDES)
    stack = cut(Model("cone", solid), Cut(count, thickness, along="z"))
    shares = 1.0 + (top - 1.0) * (np.arange(count) + 0.5) / count
    assert [slice_.area for slice_ in stack.slices] == pytest.approx(disc_area(radius * stack.scale) * shares**2)


def test_slices_of_an_ellipsoid_are_ellipses() -> None:
    a, b, c = 20.0, 30.0, 45.0
    stack = cut(ellipsoid(a, b, c), Cut(9, 10.0, along="z"))
    heights = (np.arange(9) + 0.5) / 4.5 - 1.0
    wanted = math.pi * a * b * stack.scale**2 * (1.0 - heights**2)
    assert [slice_.area for slice_ in stack.slices] == pytest.approx(wanted, rel=2e-3)
    for slice_ in stack.slices:
        low, high = np.array(slice_.outline.bounds).reshape(2, 2)
        assert (high - low)[1] / (high - low)[0] == pytest.approx(b / a, rel=1e-2)


@pytest.mark.parametrize("along", AXES)
def test_areas_times_thickness_add_up_to_the_volume(along: Axis) -> None:
    """As the midpoint rule does: four times as many slices, a fraction of the error."""
    for model in (torus(), ellipsoid(20.0, 30.0, 45.0)):
        errors = []
        for count in (4, 12, 36):
            stack = cut(model, Cut(count, 6.0, along=along))
            total = sum(slice_.section.area for slice_ in stack.slices) * stack.thickness
            errors.append(abs(total / stack.solid.volume() - 1.0))
        assert 4.0 * errors[2] < 2.0 * errors[1] < errors[0] < 0.1


def test_a_hole_is_filled_and_told() -> None:
    stack = cut(torus(), Cut(5, 10.0, along="z"))
    for slice_ in stack.slices:
        assert len(slice_.outline.interiors) == 0
        assert slice_.lost == 0.0
        assert slice_.filled == pytest.approx(slice_.area - slice_.section.area)
    height = 10.0 * stack.scale
    outer = [30.0 * stack.scale + math.sqrt(height**2 - (20.0 - 10.0 * k) ** 2) for k in range(5)]
    assert [slice_.area for slice_ in stack.slices] == pytest.approx([disc_area(radius) for radius in outer], rel=2e-2)
    assert stack.iou < 0.7


def test_of_two_parts_the_larger_is_kept_and_the_other_told() -> None:
    stack = cut(torus(), Cut(3, 20.0, along="x"))
    middle = stack.slices[1]
    assert shapely.get_num_geometries(middle.section) == 2
    assert middle.lost + middle.area == pytest.approx(middle.section.area)
    assert middle.lost == pytest.approx(middle.area, rel=1e-6)


@settings(max_examples=10)
@given(st.floats(0.1, 50.0))
def test_the_file_s_scale_does_not_matter(factor: float) -> None:
    how = Cut(4, 12.0)
    plain = cut(blob(), how)
    scaled = cut(Model("blob", blob().solid.scale((factor,) * 3).translate((5.0, 6.0, 7.0))), how)
    assert scaled.along == plain.along
    assert scaled.scale * factor == pytest.approx(plain.scale)
    for first, second in zip(plain.slices, scaled.slices, strict=True):
        assert shapely.symmetric_difference(first.outline, second.outline).area < 1e-6 * first.area


@settings(max_examples=10)
@given(st.floats(0.0, 360.0))
def test_a_turn_about_the_axis_turns_the_slices(angle: float) -> None:
    plain = cut(blob(), Cut(4, 12.0, along="z"))
    turned = cut(Model("blob", blob().solid.rotate((0.0, 0.0, angle))), Cut(4, 12.0, along="z"))
    assert [slice_.area for slice_ in turned.slices] == pytest.approx([slice_.area for slice_ in plain.slices])
    assert turned.iou == pytest.approx(plain.iou)


def test_axes_are_alike() -> None:
    """What is cut along z is what its turned copies are along x and y: nothing is mirrored."""
    plain = cut(blob(), Cut(4, 12.0, along="z"))
    for along, matrix in (("x", [[0, 0, 1], [1, 0, 0], [0, 1, 0]]), ("y", [[0, 1, 0], [0, 0, 1], [1, 0, 0]])):
        solid = blob().solid.transform(np.column_stack([np.array(matrix, dtype=np.float64), np.zeros(3)]))
        turned = cut(Model("blob", solid), Cut(4, 12.0, along=along))  # type: ignore[arg-type]
        for first, second in zip(plain.slices, turned.slices, strict=True):
            assert shapely.symmetric_difference(first.outline, second.outline).area < 1e-6 * first.area


@pytest.mark.parametrize("along", get_args(Axis))
def test_a_prism_is_cut_along_itself(along: Axis) -> None:
    prism = manifold3d.Manifold.cylinder(20.0, 15.0, 15.0, 6)
    turn = {"x": (0.0, 90.0, 0.0), "y": (90.0, 0.0, 0.0), "z": (0.0, 0.0, 0.0)}[along]
    stack = cut(Model("prism", prism.rotate(turn)), Cut(3, 10.0))
    assert stack.along == along
    assert stack.iou == pytest.approx(1.0)


@pytest.mark.parametrize("along", AXES)
def test_slices_fill_the_object_s_box_and_stand_up_as_in_the_file(along: Axis) -> None:
    model = blob()
    stack = cut(model, Cut(5, 8.0, along=along))
    assert stack.solid.bounding_box()[:3] == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert stack.solid.bounding_box()[5] == pytest.approx(stack.height)
    assert [slice_.low for slice_ in stack.slices[1:]] == [slice_.high for slice_ in stack.slices[:-1]]
    mesh = stack.solid.to_mesh64().vert_properties[:, :3]
    size = stack.upright(np.asarray(mesh)).max(axis=0)
    assert size == pytest.approx(np.array(model.size) * stack.scale)
    for slice_ in stack.slices:
        assert section(stack.solid, 0.5 * (slice_.low + slice_.high)).area == pytest.approx(slice_.section.area)


@settings(max_examples=20)
@given(st.integers(1, 20), st.integers(30, 150))
def test_two_of_count_thickness_and_size_tell_the_third(count: int, layers: int) -> None:
    thickness = round(0.2 * layers, 9)
    size = count * thickness
    assert Cut(count, thickness).counted(size) == (count, thickness)
    assert Cut(count, None, size).counted(1.0) == (count, pytest.approx(thickness))
    assert Cut(None, thickness, size).counted(1.0) == (count, thickness)
    assert Cut(count, thickness, size).counted(1.0) == (count, thickness)
    assert Cut(count).counted(size) == (count, pytest.approx(thickness))


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ((0, 20.0, None), "count is 0"),
        ((3, -1.0, None), "thickness is -1 mm"),
        ((3, 20.0, 0.0), "size is 0 mm"),
        ((3, math.nan, None), "thickness is nan"),
        ((None, None, 80.0), "neither count nor thickness"),
        ((4, 20.0, 100.0), r"4 slices of 20 mm are 80 mm high.*100 mm: leave one .* or give a thickness of 25"),
        ((1000, 20.0, None), "more than 200"),
    ],
)
def test_impossible_sizes_are_refused(numbers: tuple[int | None, float | None, float | None], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        Cut(*numbers)


def test_too_many_slices_for_the_file_s_height_are_refused() -> None:
    with pytest.raises(ModelError, match="more than 200: give a greater thickness or a smaller size"):
        cut(box(10.0, 10.0, 5000.0), Cut(thickness=6.0, along="z"))


def test_a_slice_without_area_is_refused_and_another_way_is_found() -> None:
    cube = manifold3d.Manifold.cube((20.0, 20.0, 20.0))
    model = Model("two", cube + cube.translate((0.0, 0.0, 40.0)))
    with pytest.raises(ModelError, match=r"two, along z: slice 2 of 3 has no area half-way up, 30\.0 mm over the foot"):
        cut(model, Cut(3, 20.0, along="z"))
    stack = cut(model, Cut(3, 20.0))
    assert stack.along == "x"
    assert all(slice_.lost == pytest.approx(slice_.area) for slice_ in stack.slices)


COSTS = arrays(np.float64, st.tuples(st.integers(1, 4), st.integers(1, 4)), elements=st.floats(0.0, 1.0)).flatmap(
    lambda costs: arrays(np.bool_, costs.shape).map(lambda not_these: np.where(not_these, np.inf, costs))
)


@settings(max_examples=60)
@given(COSTS)
def test_the_assignment_is_that_of_trying_all(costs: FloatArray) -> None:
    rows, columns = costs.shape
    assigned = assign(costs, distinct=True)
    taken = assigned[assigned >= 0]
    assert len(set(taken.tolist())) == len(taken)
    cost = costs[np.flatnonzero(assigned >= 0), taken]
    assert np.isfinite(cost).all()
    # Columns from `columns` on stand for none.
    ways = []
    for way in set(permutations(range(columns + rows), rows)):
        chosen = [(row, column) for row, column in enumerate(way) if column < columns]
        total = sum(costs[row, column] for row, column in chosen)
        if math.isfinite(total):
            ways.append((-len(chosen), total))
    most, least = min(ways)
    assert len(taken) == -most
    assert cost.sum() == pytest.approx(least)
    alone = assign(costs, distinct=False)
    for row, column in enumerate(alone.tolist()):
        assert column == (int(costs[row].argmin()) if np.isfinite(costs[row]).any() else -1)


@settings(max_examples=30)
@given(st.integers(0, 10_000))
def test_the_nearest_triangle_is_seen(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows, columns, count = 17, 23, 12
    corners = rng.uniform(0.0, 1.0, (count, 3, 3)) * np.array([columns, rows, 5.0])
    nearest_triangle = nearest_triangles(corners, rows, columns)
    x, y = np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5)
    nearest, expected = np.full((rows, columns), -np.inf), np.full((rows, columns), -1)
    for k, (a, b, c) in enumerate(corners):
        whole = (b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]
        s = ((x - a[0]) * (c - a)[1] - (y - a[1]) * (c - a)[0]) / whole
        t = ((b - a)[0] * (y - a[1]) - (b - a)[1] * (x - a[0])) / whole
        depth = a[2] + s * (b - a)[2] + t * (c - a)[2]
        better = (whole > 0) & (s >= 0) & (t >= 0) & (s + t <= 1) & (depth > nearest)
        nearest[better], expected[better] = depth[better], k
    assert (nearest_triangle == expected).all()


@settings(max_examples=25)
@given(st.floats(-3.0, 3.0), st.floats(0.2, 1.4), arrays(np.float64, (5, 2), elements=st.floats(-50.0, 50.0)))
def test_the_eye_finds_a_plane_point_again(azimuth: float, elevation: float, points: FloatArray) -> None:
    eye = Eye(azimuth, elevation)
    view = eye.view(np.column_stack([points, np.full(5, 7.0)]))
    assert eye.on_plane(view[:, 0], view[:, 1], 7.0) == pytest.approx(points, abs=1e-9)


@pytest.mark.parametrize("elevation", [0.5, 0.9, 1.3])
def test_a_box_is_seen_at_its_size_with_its_top_over_its_walls(elevation: float) -> None:
    square = np.array([[0.0, 0.0], [20.0, 0.0], [20.0, 20.0], [0.0, 20.0]])

    def red(points: FloatArray) -> tuple[BoolArray, npt.NDArray[np.uint8]]:
        return np.ones(len(points), dtype=np.bool_), np.tile(np.array([255, 0, 0], dtype=np.uint8), (len(points), 1))

    body = Body(*prisms([(0.0, 4.0, (square,)), (4.0, 10.0, (square,))]), "#4683c5", red)
    view = render([body], 0.1, Eye(math.radians(-90.0), elevation))
    top = (view.pixels == [255, 0, 0]).all(axis=2)
    wall = ~top & (view.pixels < 250).any(axis=2)
    # Less what the edges take.
    assert 0.95 * 400.0 * math.sin(elevation) < top.sum() * 0.01 <= 400.0 * math.sin(elevation)
    assert wall.sum() * 0.01 == pytest.approx(200.0 * math.cos(elevation), rel=0.1, abs=8.0)
    assert np.flatnonzero(top.any(axis=1)).max() < np.flatnonzero(wall[:, 100]).max()
