"""Fabrication: what holds of every design and its solids."""

from __future__ import annotations

import math
from dataclasses import fields
from itertools import pairwise

import numpy as np
import pytest
import shapely
from exact_designs import PAIRS, design_of, designs, lifted_design, transform_of
from hypothesis import given, settings
from hypothesis import strategies as st

from riot.errors import ParameterError
from riot.fabricate import FabricationError, FabricationParameters, design
from riot.fabricate.certificate import certify
from riot.fabricate.motion_check import placed_parts, pressed_pairs
from riot.fabricate.outlines import disc
from riot.fabricate.pivot import knuckle_radius
from riot.fabricate.solid import genus, make_parts
from riot.fabricate.sub_chains import sub_chains
from riot.fabricate.telescope import make_telescope
from riot.fabricate.tuning import GREATEST_TURN
from riot.geometry.polyline import extent, signed_area
from riot.parameters import allowed_range


@pytest.mark.parametrize("which", range(5))
def test_every_design_is_certified_and_its_solids_are_what_its_layers_say(which: int) -> None:
    puzzle_design = designs()[which]
    parts = make_parts(puzzle_design)
    certificate = certify(puzzle_design, parts)
    assert certificate.failures == ()
    assert certificate.motion.proven
    assert certificate.motion.overlap == 0.0
    assert certificate.motion.gap >= puzzle_design.parameters.gap_mm
    for solid_part, check in zip(parts, certificate.parts, strict=True):
        assert (check.status, check.components) == ("NoError", 1)
        assert solid_part.volume == pytest.approx(sum(slab.volume for slab in solid_part.slabs), rel=1e-9)
        points, triangles = solid_part.mesh()
        edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
        # A closed surface: every edge is there once in either direction.
        assert len(np.unique(edges, axis=0)) == len(edges)
        assert set(map(tuple, edges.tolist())) == set(map(tuple, edges[:, ::-1].tolist()))
        a, b, c = points[triangles].transpose(1, 0, 2)
        assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0 == pytest.approx(solid_part.volume, rel=1e-9)
        assert len(points) - len(edges) // 2 + len(triangles) == 2 - 2 * check.genus


@pytest.mark.parametrize("pair", [(0, 0), *PAIRS])
def test_a_piece_is_its_outline_extruded_but_for_the_account_of_its_hinges(pair: tuple[int, int]) -> None:
    puzzle_design = design_of(*pair)
    height, radius = puzzle_design.parameters.height, knuckle_radius(puzzle_design.parameters)
    for piece in puzzle_design.pieces:
        ends = [end for end in (piece.start, piece.end) if end.kind == "pin"]
        flat = piece.body.area * height
        # Knuckles add at most their cylinders, relief and holes take at most theirs.
        most = sum(math.pi * radius**2 * (ring.high - ring.low) for end in ends for ring in end.rings)
        least = sum(math.pi * (end.relief_radius + 0.02) ** 2 * height for end in ends)
        assert flat - least < piece.volume < flat + most
        # Away from the hinges it is exactly the outline extruded.
        far = shapely.union_all([disc(end.x, end.y, end.relief_radius + 0.05) for end in ends])
        for slab in piece.slabs:
            assert slab.section.difference(far).symmetric_difference(piece.body.difference(far)).area < 0.05


@pytest.mark.parametrize("pair", [(0, 0), *PAIRS])
def test_handles_are_counted_by_knuckles(pair: tuple[int, int]) -> None:
    puzzle_design = design_of(*pair)
    for piece, solid_part in zip(puzzle_design.pieces, make_parts(puzzle_design), strict=False):
        expected = (piece.start.kind == "pin") + (piece.end.kind == "pin")
        assert genus(solid_part.slabs) == solid_part.solid.genus() == expected


@pytest.mark.parametrize("which", range(5))
def test_hinges_are_where_the_motion_says(which: int) -> None:
    puzzle_design = designs()[which]
    motion, n = puzzle_design.motion, len(puzzle_design.pieces)
    kinds = {piece.start.hinge: piece.start.kind for piece in puzzle_design.pieces}
    assert [kind for _, kind in sorted(kinds.items())] == [
        "open" if h == motion.open_hinge else "telescopic" if h in motion.lifted else "pin" for h in range(n)
    ]
    assert sum(pin.count for pin in puzzle_design.pins) == list(kinds.values()).count("pin")
    assert puzzle_design.sleeves == len(motion.lifted)
    for before, after in zip(puzzle_design.pieces, puzzle_design.pieces[1:] + puzzle_design.pieces[:1], strict=True):
        assert before.end.hinge == after.start.hinge
        assert {before.end.role, after.start.role} in ({"lower", "upper"}, {"none"})
        assert (before.end.x, before.end.y) == (before.length, 0.0)
    for piece in puzzle_design.pieces:
        assert {piece.start.role, piece.end.role} - {"none"} == {"upper" if piece.upside_down else "lower"}


def test_holes_leave_the_pin_the_clearance_asked_for() -> None:
    parameters = FabricationParameters(pin_mm=4.0, clearance_mm=0.5, press_mm=0.2, wall_mm=2.0)
    puzzle_design = design(transform_of(5, 1), parameters)
    for piece in puzzle_design.pieces:
        gap = 0.5 if piece.upside_down else -0.1
        for end in (piece.start, piece.end):
            if end.kind != "pin":
                continue
            axis, ring = shapely.Point(end.x, end.y), end.rings[0]
            slab = next(s for s in piece.slabs if s.low < 0.5 * (ring.low + ring.high) < s.high)
            assert slab.section.distance(axis) == pytest.approx(2.0 + gap, abs=2e-3)
            # The wall: from the hole's edge outwards there is nothing but wall.
            wall = disc(end.x, end.y, ring.radius - 0.01).difference(disc(end.x, end.y, 2.0 + gap + 0.02))
            assert slab.section.contains(wall)
    assert puzzle_design.pins[0].diameter == 4.0


@pytest.mark.parametrize("pair", [(0, 0), *PAIRS])
def test_size_is_the_long_side_of_the_larger_shape(pair: tuple[int, int]) -> None:
    puzzle_design = design_of(*pair)
    transform = puzzle_design.transform
    sides = [puzzle_design.scale * extent(outline) for outline in (transform.outline_p(), transform.outline_q())]
    assert max(sides) == pytest.approx(120.0)
    for piece, of in zip(puzzle_design.pieces, transform.pieces, strict=True):
        whole = shapely.Polygon(puzzle_design.scale * of.polygon)
        assert signed_area(piece.outline) > 0.0
        assert whole.contains(shapely.Polygon(piece.outline))
        # Half the gap all round, and hardly more.
        assert shapely.Polygon(piece.outline).distance(whole.boundary) == pytest.approx(0.175, abs=0.02)


def test_samples_of_the_course_agree_with_the_motion_and_are_close() -> None:
    puzzle_design = lifted_design()
    for sub_chain in sub_chains(puzzle_design.motion, puzzle_design.scale):
        assert np.abs(np.diff(sub_chain.headings, axis=0)).max(initial=0.0) <= GREATEST_TURN * (1.0 + 1e-9)
        for k in (0, len(sub_chain.times) // 2, len(sub_chain.times) - 1):
            pose = puzzle_design.motion.pose_at(float(sub_chain.times[k]))
            origins = puzzle_design.scale * pose.origins[sub_chain.pieces]
            apart = np.linalg.norm(origins[:, None] - origins[None], axis=2)
            points = sub_chain.points[k, :-1]
            assert np.allclose(apart, np.linalg.norm(points[:, None] - points[None], axis=2), atol=1e-9)


@settings(max_examples=12)
@given(
    t=st.floats(0.0, 1.0),
    which=st.integers(0, 4),
)
def test_no_two_parts_overlap_at_any_pose(t: float, which: int) -> None:
    puzzle_design = designs()[which]
    names, placed = zip(*placed_parts(puzzle_design, make_parts(puzzle_design), t), strict=True)
    pressed = pressed_pairs(puzzle_design)
    assert all(
        (placed[i] ^ placed[j]).volume() < 1e-9
        for i in range(len(placed))
        for j in range(i)
        if {names[i], names[j]} not in pressed
    )


def test_the_telescope_lifts_far_enough_and_holds() -> None:
    puzzle_design = lifted_design()
    assert puzzle_design.telescope is not None
    check = next(check for check in certify(puzzle_design).hinges if check.kind == "telescopic")
    assert check.failures == ()
    assert puzzle_design.telescope.travel >= puzzle_design.parameters.height + 1.0
    heights = puzzle_design.lift * puzzle_design.motion.levels_at(0.5)
    assert sorted(set(heights.tolist())) == [0.0, puzzle_design.parameters.height + 1.0]


@pytest.mark.parametrize("thickness", [9.0, 12.0, 20.0, 30.0])
def test_telescopes_nest_at_any_thickness(thickness: float) -> None:
    parameters = FabricationParameters(thickness_mm=thickness)
    telescope = make_telescope(parameters)
    assert telescope.travel >= parameters.travel
    for rings in (telescope.barrel, telescope.sleeve, telescope.rod):
        assert all(below.high == pytest.approx(above.low) for below, above in pairwise(rings))
        layers = [z / parameters.layer_mm for ring in rings for z in (ring.low, ring.high)]
        assert layers == pytest.approx(np.round(layers).tolist())
    flange, ledge = telescope.sleeve[0].radius, telescope.barrel[-1].hole
    knob, inner = telescope.rod[0].radius, telescope.sleeve[-1].hole
    assert flange > ledge + 0.3 and knob > inner + 0.3


def test_thin_pieces_cannot_have_a_telescope() -> None:
    with pytest.raises(FabricationError, match="thickness_mm: a telescopic hinge of 7 mm") as caught:
        make_telescope(FabricationParameters(thickness_mm=7.0))
    assert caught.value.parameter == "thickness_mm"
    make_telescope(FabricationParameters(thickness_mm=caught.value.value))


@pytest.mark.parametrize("name", sorted(field.name for field in fields(FabricationParameters) if field.name != "pivot"))
def test_parameters_out_of_range_are_named(name: str) -> None:
    least, greatest = allowed_range(FabricationParameters, name)
    for value in (least, greatest):
        assert getattr(FabricationParameters(**{name: value}), name) == value
    for value in (np.nextafter(least, -1.0), np.nextafter(greatest, 1e9), math.nan, math.inf):
        words = rf"{name}: must be (a finite number|{least:g} to {greatest:g} mm), got {float(value)!r}"
        with pytest.raises(ParameterError, match=words) as caught:
            FabricationParameters(**{name: float(value)})
        assert caught.value.parameter == name


@settings(max_examples=60)
@given(thickness=st.floats(6.0, 30.0), layer=st.floats(0.1, 0.4), gap=st.floats(0.2, 0.6))
def test_knuckles_of_any_parameters_fill_the_height_in_whole_layers(thickness: float, layer: float, gap: float) -> None:
    parameters = FabricationParameters(thickness_mm=thickness, layer_mm=layer, axial_gap_mm=gap)
    lower, upper = parameters.levels
    assert 0.0 < lower < upper < parameters.height
    assert upper - lower >= gap - 1e-6
    rounded = 4e-9  # each of the three is rounded to 1e-9 mm
    assert abs(lower - (parameters.height - upper)) <= layer + rounded
    assert abs(parameters.height - thickness) <= 0.5 * layer + rounded
    for z in (*parameters.levels, parameters.height):
        assert abs(z / layer - round(z / layer)) < 1e-6
