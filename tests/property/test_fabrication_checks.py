"""Fabrication: the certificate catches what cannot be made, and says what will do."""

from __future__ import annotations

from dataclasses import replace

import pytest
import shapely
from exact_designs import design_of, designs, lifted_design, lifting, transform_of, with_piece

from riot import Transform
from riot.fabricate import Design, FabricationError, FabricationParameters, PieceDesign, design
from riot.fabricate import certificate as certificate_module
from riot.fabricate.certificate import BuiltPuzzle, certify, fix, way_out
from riot.fabricate.design import upper_pieces
from riot.fabricate.model import Slab
from riot.fabricate.outlines import disc, narrowest, widening_parameter
from riot.fabricate.overhang import check_supports
from riot.fabricate.pivot import make_pivot
from riot.fabricate.solid import Part, extruded, make_parts
from riot.fabricate.tuning import LARGEST_HINGE_SHARE
from riot.parameters.fabrication import PIVOTS


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


def test_what_nothing_mends_in_place_is_told_to_take_pins(monkeypatch: pytest.MonkeyPatch) -> None:
    def not_in_place(transform: Transform, parameters: FabricationParameters) -> BuiltPuzzle:
        if parameters.pivot == "in-place":
            raise FabricationError("falls-apart", "piece-1 falls into 2 parts", "size_mm")
        return fix(transform, parameters)

    monkeypatch.setattr(certificate_module, "fix", not_in_place)
    told = way_out(transform_of(3, 1), FabricationParameters(pivot="in-place"))
    assert told.startswith("it passes with pivot: printed instead of in-place; ")


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
