"""Fabrication: what holds of every design and its solids, and that the certificate catches what does not."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields, replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from riot import Transform
from riot.errors import ParameterError
from riot.fabricate import Design, FabricationError, FabricationParameters, PieceDesign, design
from riot.fabricate import certificate as certificate_module
from riot.fabricate.certificate import certify, fix
from riot.fabricate.design import upper_pieces
from riot.fabricate.model import Slab
from riot.fabricate.motion_check import placed_parts, pressed_pairs
from riot.fabricate.outlines import disc, narrowest, widening_parameter
from riot.fabricate.overhang import check_supports
from riot.fabricate.pivot import knuckle_radius, make_pivot
from riot.fabricate.solid import Part, extruded, genus, make_parts
from riot.fabricate.sub_chains import sub_chains
from riot.fabricate.telescope import make_telescope
from riot.fabricate.tuning import GREATEST_TURN, LARGEST_HINGE_SHARE
from riot.geometry.polyline import extent, signed_area
from riot.groundtruth.pairs import dudeney, exact_pair, exact_transform
from riot.motion.planner import plan_motion
from riot.parameters import MotionParameters, allowed_range
from riot.parameters.fabrication import PIVOTS
from riot.transform.motion import LIFT, Motion

PAIRS = ((3, 1), (5, 1), (6, 2))
LIFTED_MM = 150.0


@cache
def transform_of(n: int, seed: int) -> Transform:
    return exact_transform(dudeney() if n == 0 else exact_pair(n, seed))


@cache
def design_of(n: int, seed: int) -> Design:
    return design(transform_of(n, seed))


def lifting(transform: Transform) -> Transform:
    """The same with a plan that lifts at one hinge though it need not: the second from the open one."""
    flat = plan_motion(transform, MotionParameters(gap=0.35 / LIFTED_MM, relief=3.8 / LIFTED_MM))
    n = len(transform)
    lifted = (flat.open_hinge + 2) % n
    level = np.zeros(n, dtype=np.int64)
    level[(lifted + np.arange((flat.open_hinge - lifted - 1) % n + 1)) % n] = 1
    ground = np.zeros((1, n), dtype=np.int64)
    plan = Motion(
        flat.open_hinge,
        (lifted,),
        flat.search,
        np.concatenate([[0.0], LIFT + (1.0 - 2.0 * LIFT) * flat.times, [1.0]]),
        np.concatenate([flat.turns[:1], flat.turns, flat.turns[-1:]]),
        np.concatenate([ground, np.tile(level, (len(flat.times), 1)), ground]),
        flat.gap,
        flat.relief,
        flat.tried,
        flat.chain,
        flat.place_p,
        flat.place_q,
    )
    return replace(transform, plan=plan)


@cache
def lifted_design() -> Design:
    return design(lifting(transform_of(4, 2)), FabricationParameters(size_mm=LIFTED_MM))


def designs() -> list[Design]:
    return [design_of(0, 0), *(design_of(*pair) for pair in PAIRS), lifted_design()]


def with_piece(puzzle_design: Design, index: int, changed: Callable[[PieceDesign], PieceDesign]) -> Design:
    pieces = tuple(changed(piece) if i == index else piece for i, piece in enumerate(puzzle_design.pieces))
    return replace(puzzle_design, pieces=pieces)


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


def test_a_size_too_small_is_refused_with_the_size_that_is_enough() -> None:
    transform = transform_of(6, 2)
    with pytest.raises(FabricationError, match=r"hinges \d and \d come within .* enlarge size_mm \(30\) to") as caught:
        design(transform, FabricationParameters(size_mm=30.0, pin_mm=8.0))
    assert (caught.value.reason, caught.value.parameter) == ("hinges-meet", "size_mm")
    design(transform, FabricationParameters(size_mm=caught.value.value, pin_mm=8.0))


def test_fixing_says_what_it_changed_and_stays_within_the_ranges() -> None:
    puzzle_design = fix(transform_of(6, 2), FabricationParameters(size_mm=30.0, pin_mm=8.0))
    assert puzzle_design.certificate.passed
    assert puzzle_design.design.parameters.pin_mm == 1.75
    assert "pin_mm: 1.75 instead of 8" in puzzle_design.changes
    untouched = fix(transform_of(3, 1))
    assert untouched.changes == ()
    assert untouched.design.parameters == FabricationParameters()


def test_fixing_keeps_the_size_where_it_must(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[FabricationParameters] = []

    def never(transform: Transform, parameters: FabricationParameters) -> Design:
        tried.append(parameters)
        raise FabricationError("hinges-meet", "too small", "size_mm", 80.0)

    monkeypatch.setattr(certificate_module, "design", never)
    with pytest.raises(
        FabricationError, match=r"too small \(tried with pin_mm: 1.75 instead of 3, pivot: rod instead of printed\)"
    ) as caught:
        fix(transform_of(3, 1), FabricationParameters(size_mm=50.0), enlarge=False)
    assert (caught.value.parameter, caught.value.value) == ("size_mm", 80.0)
    assert [(attempt.size_mm, attempt.pin_mm) for attempt in tried] == [(50.0, 3.0), (50.0, 1.75)]


def test_what_no_change_mends_is_told_as_it_is() -> None:
    with pytest.raises(FabricationError, match=r"make it 8.6 mm$") as caught:
        fix(lifting(transform_of(6, 2)), FabricationParameters(size_mm=60.0, thickness_mm=6.0, pin_mm=8.0))
    assert caught.value.parameter == "thickness_mm"


def test_what_cannot_be_fixed_says_what_was_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    def never(transform: Transform, parameters: FabricationParameters) -> Design:
        raise FabricationError("hinges-meet", f"too small at {parameters.size_mm:g} mm", "size_mm")

    monkeypatch.setattr(certificate_module, "design", never)
    tried = r"too small at 1000 mm \(tried with size_mm: 1000 instead of 500, pin_mm: 1.75 instead of 3, pivot: .*\)"
    with pytest.raises(FabricationError, match=tried) as caught:
        fix(transform_of(3, 1), FabricationParameters(size_mm=500.0))
    assert (caught.value.reason, caught.value.parameter) == ("hinges-meet", "size_mm")


def test_an_inexact_transform_is_refused() -> None:
    transform = transform_of(3, 1)
    first = transform.pieces[0]
    broken = replace(transform, pieces=(replace(first, upper=first.upper * [1.0, 1.01]), *transform.pieces[1:]))
    with pytest.raises(FabricationError, match="the transform is not exact") as caught:
        design(broken)
    assert caught.value.reason == "uncertified"


def test_a_narrow_corner_is_told_of_and_a_thicker_wall_mends_it() -> None:
    thin = shapely.Polygon([(0.0, 0.0), (60.0, -6.0), (60.0, 6.0)]).buffer(-0.175)
    puzzle_design = design_of(3, 1)
    start = next(piece.start for piece in puzzle_design.pieces if piece.start.kind == "pin")
    joined = shapely.union_all([thin, disc(0.0, 0.0, start.radius)])
    piece = replace(puzzle_design.pieces[0], body=thin, start=start, slabs=(Slab(0.0, 9.0, joined),))
    assert narrowest(piece) < 1.0
    assert widening_parameter(piece, 0.8) == "wall_mm"


class TestDamage:
    """The certificate must fail, and say where."""

    def test_pieces_without_a_gap(self) -> None:
        puzzle_design = design_of(5, 1)
        hinge = next(piece.start.hinge for piece in puzzle_design.pieces if piece.start.kind == "pin")

        def grown(piece: PieceDesign) -> PieceDesign:
            return replace(
                piece, slabs=tuple(Slab(slab.low, slab.high, slab.section.buffer(0.36)) for slab in piece.slabs)
            )

        failures = certify(with_piece(puzzle_design, hinge, grown)).failures
        assert any(f"hinge {hinge}" in words and "gap_mm" in words for words in failures)

    def test_knuckles_without_room(self) -> None:
        puzzle_design = design_of(5, 1)
        hinge = next(piece.start.hinge for piece in puzzle_design.pieces if piece.start.kind == "pin")

        def unrelieved(piece: PieceDesign) -> PieceDesign:
            return replace(
                piece, slabs=tuple(Slab(s.low, s.high, shapely.union(s.section, piece.body)) for s in piece.slabs)
            )

        damaged = with_piece(puzzle_design, hinge, unrelieved)
        certificate = certify(damaged)
        assert not certificate.motion.proven
        assert certificate.motion.overlap > 1.0
        assert any(words.startswith(f"hinge {hinge}:") for words in certificate.failures)
        assert any("overlap by" in words and "at time" in words for words in certificate.failures)

    def test_holes_too_small_for_the_pin(self) -> None:
        puzzle_design = design_of(5, 1)
        pivot = puzzle_design.pivot
        assert pivot is not None
        thick = replace(puzzle_design.parameters, clearance_mm=0.4, press_mm=0.3)
        damaged = replace(puzzle_design, parameters=thick, pivot=replace(make_pivot(thick), profile=pivot.profile))
        failures = certify(damaged).failures
        assert any("clearance_mm asks for 0.4" in words for words in failures)
        assert any("0.10 mm thicker than the hole" in words and "press_mm asks for 0.3" in words for words in failures)

    def test_a_solid_that_is_not_its_layers(self) -> None:
        puzzle_design = design_of(5, 1)
        parts = make_parts(puzzle_design)
        worn = replace(parts[0], solid=extruded(parts[0].slabs[:-1]))
        failures = certify(puzzle_design, (worn, *parts[1:])).failures
        assert any(words.startswith("piece-1 has") and "where its layers have" in words for words in failures)

    def test_a_piece_in_two_parts(self) -> None:
        puzzle_design = design_of(5, 1)
        parts = make_parts(puzzle_design)
        two = replace(parts[0], solid=parts[0].solid + parts[0].solid.translate((500.0, 0.0, 0.0)))
        assert any("piece-1 is in 2 parts" in words for words in certify(puzzle_design, (two, *parts[1:])).failures)

    def test_pieces_that_cannot_lift_past_each_other(self) -> None:
        puzzle_design = lifted_design()
        upper = puzzle_design.motion.lifted[0]

        def wide(piece: PieceDesign) -> PieceDesign:
            lowest = piece.slabs[0]
            return replace(piece, slabs=(Slab(lowest.low, lowest.high, piece.footprint.buffer(1.0)), *piece.slabs[1:]))

        failures = certify(with_piece(puzzle_design, upper, wide)).failures
        assert any(words.startswith(f"piece-{upper + 1} cannot lift past") for words in failures)


class TestSupports:
    """Every layer against the one below."""

    @pytest.mark.parametrize("which", range(5))
    def test_no_design_needs_supports(self, which: int) -> None:
        certificate = certify(designs()[which])
        assert certificate.supported
        assert 0.0 < certificate.overhang <= 35.0
        assert certificate.bridge == 0.0

    @pytest.mark.parametrize("pivot", ["printed", "filament", "rod", "screw"])
    def test_every_pivot_is_held_and_prints_without_supports(self, pivot: str) -> None:
        parameters = FabricationParameters(**PIVOTS[pivot])
        certificate = certify(design(transform_of(0, 0), parameters))
        assert certificate.failures == ()
        assert certificate.bridge == 0.0
        for check in certificate.hinges:
            assert check.turning_gap == pytest.approx(parameters.clearance_mm, abs=2e-3)
            assert check.pull <= 1.0
            if pivot == "screw":
                assert check.interference is None
            else:
                assert check.interference == pytest.approx(parameters.press_mm, abs=4e-3)

    @pytest.mark.parametrize("layer", [0.1, 0.15, 0.2, 0.28, 0.4])
    @pytest.mark.parametrize("pivot", ["rod", "screw"])
    def test_any_layer_height_will_do(self, layer: float, pivot: str) -> None:
        parameters = FabricationParameters(layer_mm=layer, pivot=pivot, thickness_mm=12.0)  # type: ignore[arg-type]
        assert certify(design(transform_of(0, 0), parameters)).failures == ()

    def test_pieces_that_lie_the_wrong_way_need_supports(self) -> None:
        puzzle_design = design_of(5, 1)
        for solid_part in make_parts(puzzle_design)[: len(puzzle_design.pieces)]:
            check = check_supports(replace(solid_part, upside_down=not solid_part.upside_down), 0.2)
            assert check.failures and check.unsupported > 1.0

    def test_what_spans_two_sides_is_a_bridge_and_what_ends_in_the_air_is_none(self) -> None:
        floor = shapely.box(0.0, 0.0, 20.0, 6.0)
        for width, bridged in ((7.0, True), (7.9, True), (8.1, False)):
            walls = floor.difference(shapely.box(5.0, 0.0, 5.0 + width, 6.0))
            slabs = Slab(0.0, 2.0, floor), Slab(2.0, 4.0, walls), Slab(4.0, 5.0, floor)
            check = check_supports(Part("bridge", "piece", 1, slabs, extruded(slabs)), 0.2)
            assert (check.failures == ()) is bridged
            assert check.bridge == pytest.approx(width if bridged else 0.0, abs=0.01)
        around = Slab(0.0, 2.0, floor), Slab(2.0, 4.0, floor.buffer(0.3))
        assert check_supports(Part("brim", "piece", 1, around, extruded(around)), 0.3).failures == ()
        assert check_supports(Part("brim", "piece", 1, around, extruded(around)), 0.2).failures != ()

    def test_a_screw_asks_for_thickness_that_is_enough(self) -> None:
        with pytest.raises(FabricationError, match="does not hold the nut of an M3 screw") as caught:
            make_pivot(FabricationParameters(pivot="screw"))
        make_pivot(FabricationParameters(pivot="screw", thickness_mm=caught.value.value))
        with pytest.raises(FabricationError, match=r"no screw of 3.3 mm; choose one of 2, 2.5, 3, 4"):
            make_pivot(FabricationParameters(pivot="screw", pin_mm=3.3))

    def test_lifts_that_contradict_each_other_are_refused(self) -> None:
        motion = design_of(6, 2).motion
        first = motion.open_hinge
        upper_pieces(replace(motion, lifted=((first + 1) % 6, (first + 3) % 6)))
        with pytest.raises(FabricationError, match="lift an odd number of pieces apart") as caught:
            upper_pieces(replace(motion, lifted=((first + 1) % 6, (first + 2) % 6)))
        assert caught.value.reason == "supports"


@pytest.mark.parametrize("pair", [(5, 1), (6, 2)])
def test_hinges_that_are_too_large_name_the_least_size_that_will_do(pair: tuple[int, int]) -> None:
    transform = transform_of(*pair)
    parameters = FabricationParameters(size_mm=60.0, pin_mm=1.75, wall_mm=0.8)
    certificate = certify(design(transform, parameters))
    assert certificate.hinge_share > LARGEST_HINGE_SHARE
    asked = max(check.value for check in certificate.parts if check.failures)
    assert f"enlarge size_mm (60) to {asked:g}" in " ".join(certificate.failures)
    for size, passed in ((asked, True), (asked - 2.0, False)):
        larger = certify(design(transform, replace(parameters, size_mm=size)))
        assert (larger.hinge_share <= LARGEST_HINGE_SHARE) is passed
        assert any("as large as it" in words for words in larger.failures) is not passed
