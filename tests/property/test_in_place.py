"""Hinges printed in place: what holds of every pin and socket, and that the certificate catches what does not."""

from __future__ import annotations

import math
import re
import zipfile
from dataclasses import replace
from functools import cache
from itertools import combinations, pairwise
from pathlib import Path

import manifold3d
import numpy as np
import pytest
import trimesh
from exact_designs import transform_of
from hypothesis import given, settings
from hypothesis import strategies as st

from riot.cli.main import main
from riot.draw.scene import Label
from riot.fabricate import Design, FabricationError, FabricationParameters, design, write_puzzle
from riot.fabricate.captive_check import check_captive
from riot.fabricate.certificate import FabricationCertificate, certify
from riot.fabricate.cones import cone_height, cone_pin, cone_socket
from riot.fabricate.export.drawing import drawing_of
from riot.fabricate.export.inlay import bodies_of, chain_bodies
from riot.fabricate.export.instructions import end_in_words
from riot.fabricate.export.page import page_scenes
from riot.fabricate.in_place import chain_part, check_placement, placed_on_bed
from riot.fabricate.layers import rings_slabs
from riot.fabricate.motion_check import placed_parts
from riot.fabricate.part_check import thinner_pin
from riot.fabricate.pivot import make_pivot
from riot.fabricate.rings import Ring
from riot.fabricate.solid import Part, extruded, make_parts
from riot.fabricate.tuning import LEAST_WALL_MM, SLOPE
from riot.motion.planner import motion_of
from riot.parameters.fabrication import PIVOTS
from riot.transform.riot_file import save

PAIRS = ((0, 0), (5, 1))


def in_place(**changes: float) -> FabricationParameters:
    return FabricationParameters(**{**PIVOTS["in-place"], **changes})  # type: ignore[arg-type]


@cache
def puzzle(n: int, seed: int) -> tuple[Design, tuple[Part, ...]]:
    puzzle_design = design(transform_of(n, seed), in_place())
    return puzzle_design, make_parts(puzzle_design)


@cache
def certificate_of(n: int, seed: int) -> FabricationCertificate:
    return certify(*puzzle(n, seed))


def apart(pin: Ring, hole: Ring) -> float:
    """Distance in space of a disc and what is around a hole, two rings on one axis; mm."""
    return math.hypot(max(0.0, hole.hole - pin.radius), max(0.0, pin.low - hole.high, hole.low - pin.high))


@settings(max_examples=60, deadline=None)
@given(
    clearance=st.floats(0.15, 0.6),
    layer=st.sampled_from([0.1, 0.15, 0.2, 0.3]),
    thickness=st.floats(8.0, 30.0),
    pin=st.floats(1.75, 8.0),
    wall=st.floats(0.8, 4.0),
)
def test_a_socket_follows_its_pin_and_keeps_it(
    clearance: float, layer: float, thickness: float, pin: float, wall: float
) -> None:
    parameters = in_place(clearance_mm=clearance, layer_mm=layer, thickness_mm=thickness, pin_mm=pin, wall_mm=wall)
    if parameters.levels[0] < cone_height(parameters):
        with pytest.raises(FabricationError, match="the socket does not hold two cones") as caught:
            make_pivot(parameters)
        make_pivot(replace(parameters, thickness_mm=caught.value.value))
        return
    pins, holes = cone_pin(parameters), cone_socket(parameters)
    for rings, top in ((pins, parameters.height), (holes, parameters.levels[0])):
        assert (rings[0].low, rings[-1].high) == (0.0, top)
        assert all(below.high == above.low for below, above in pairwise(rings))
    nearest = min(apart(one, hole) for one in pins for hole in holes)
    assert clearance <= nearest <= clearance + 0.01
    # Wherever the pin is sideways, its widest rings above and below the waist do not pass the narrowest hole.
    waist = min(range(len(holes)), key=lambda k: holes[k].hole)
    below = max(ring.radius for ring in pins if ring.high <= holes[waist].low)
    above = max(ring.radius for ring in pins if ring.low >= holes[waist].high)
    assert min(below, above) > holes[waist].hole + 0.2
    assert min(ring.radius - ring.hole for ring in holes) >= LEAST_WALL_MM - 0.01
    # Nothing leans out further than a slope that prints: the pin as it widens, the socket as it narrows.
    lean = SLOPE * layer + 1e-6
    assert all(after.radius - before.radius <= lean for before, after in pairwise(pins))
    assert all(before.hole - after.hole <= 2.0 * lean for before, after in pairwise(holes))


@pytest.mark.parametrize("pair", PAIRS)
def test_a_chain_that_is_printed_in_place_is_certified(pair: tuple[int, int]) -> None:
    puzzle_design, certificate = puzzle(*pair)[0], certificate_of(*pair)
    assert certificate.failures == ()
    assert certificate.supported and certificate.bridge == 0.0 and certificate.overhang <= 35.0
    assert certificate.motion.proven and certificate.motion.overlap == 0.0
    asked = puzzle_design.parameters.clearance_mm
    assert certificate.placement is not None
    assert (certificate.placement.solids, certificate.placement.common) == (len(puzzle_design.pieces), 0.0)
    assert certificate.placement.gap >= asked
    for check in certificate.hinges:
        # The same at every turn, but for the sides of the polygons.
        assert asked <= check.turning_gap <= check.widest_gap <= check.turning_gap + 0.01
        assert max(check.pull, check.aside) < 1.2
    assert "printed in place" in " ".join(certificate.words())
    assert puzzle_design.pins == () and not any(piece.upside_down for piece in puzzle_design.pieces)


@pytest.mark.parametrize("pair", PAIRS)
def test_pieces_on_the_bed_are_apart_by_brute_force(pair: tuple[int, int]) -> None:
    puzzle_design, parts = puzzle(*pair)
    asked = puzzle_design.parameters.clearance_mm
    members = placed_on_bed(puzzle_design, parts)
    grown = manifold3d.Manifold.sphere(0.98 * asked, 16)
    for first, second in combinations(members, 2):
        assert (first.solid ^ second.solid).volume() == 0.0
        # A ball as large as the gap, at corners of the one, does not meet the other.
        low, high = np.array(second.solid.bounding_box()).reshape(2, 3)
        corners = first.mesh()[0]
        near = corners[((corners > low - asked) & (corners < high + asked)).all(axis=1)]
        for corner in near[:: max(1, len(near) // 40)].tolist():
            assert (grown.translate(corner) ^ second.solid).volume() == 0.0


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("t", [0.0, 0.31, 0.77, 1.0])
def test_pins_turn_in_their_sockets_all_the_way(pair: tuple[int, int], t: float) -> None:
    placed = placed_parts(*puzzle(*pair), t)
    assert len(placed) == len(transform_of(*pair))
    assert all((first ^ second).volume() < 1e-9 for (_, first), (_, second) in combinations(placed, 2))


def test_a_chain_lies_straight_on_the_bed_and_its_pieces_well_apart() -> None:
    puzzle_design, parts = puzzle(0, 0)
    placement = puzzle_design.placement
    assert placement is not None and placement.gap >= 2.0
    wide, deep, high = chain_part(puzzle_design, parts).size
    assert (wide, deep) == pytest.approx((placement.width, placement.depth), abs=0.01)
    assert high == puzzle_design.parameters.height


class TestRefusals:
    """What cannot be printed in place is told before anything is built."""

    def test_thin_pieces(self) -> None:
        with pytest.raises(FabricationError, match=r"thickness_mm: the socket .* at 6 mm; make it \d") as caught:
            design(transform_of(0, 0), in_place(thickness_mm=6.0))
        assert design(transform_of(0, 0), in_place(thickness_mm=caught.value.value)).placement

    def test_a_bed_too_small_for_every_pose(self) -> None:
        with pytest.raises(FabricationError, match=r"the chain is \d+ × \d+ mm .* lessen size_mm \(400\) to") as caught:
            design(transform_of(0, 0), in_place(size_mm=400.0))
        assert caught.value.reason == "bed"
        size = float(re.findall(r"to about (\d+)", str(caught.value))[0])
        assert design(transform_of(0, 0), in_place(size_mm=size)).placement

    def test_a_motion_that_lifts(self) -> None:
        transform = transform_of(3, 1)
        motion = motion_of(transform)
        lifted = replace(motion, lifted=((motion.open_hinge + 1) % 3,))
        with pytest.raises(FabricationError, match=r"must lift.*choose another pivot than in-place"):
            design(replace(transform, plan=lifted), in_place())

    def test_fix_thins_the_waist_and_keeps_the_pivot(self) -> None:
        thin = thinner_pin(in_place())
        assert thin is not None and (thin.pivot, thin.pin_mm) == ("in-place", 2.0)
        assert thinner_pin(thin) is None


class TestDamage:
    """The certificate must fail, and say where."""

    def test_a_socket_that_lets_its_pin_go(self) -> None:
        puzzle_design, parts = puzzle(0, 0)
        hinge = next(piece.start.hinge for piece in puzzle_design.pieces if piece.start.kind == "pin")
        before, after = puzzle_design.pieces[hinge - 1], puzzle_design.pieces[hinge]
        lower, end = (before, before.end) if after.start.captive else (after, after.start)
        wide = max(ring.radius for ring in cone_pin(puzzle_design.parameters)) + 1.0
        drill = extruded(rings_slabs((Ring(0.0, 20.0, wide),))).translate((end.x, end.y, -5.0))
        drilled = tuple(replace(part, solid=part.solid - drill) if part.name == lower.name else part for part in parts)
        check = check_captive(drilled, puzzle_design, before, after)
        assert f"hinge {hinge}: its pin comes up out of its socket: lessen clearance_mm" in check.failures
        assert math.isinf(check.pull)

    def test_pieces_that_touch_on_the_bed(self) -> None:
        puzzle_design, parts = puzzle(0, 0)
        swollen = replace(parts[0], solid=parts[0].solid.translate((0.2, 0.0, 0.0)))
        failures = check_placement(puzzle_design, (swollen, *parts[1:])).failures
        assert any("piece-1" in words and "where they are printed: clearance_mm asks" in words for words in failures)
        raised = replace(parts[0], solid=parts[0].solid.translate((0.0, 0.0, 0.1)))
        failures = check_placement(puzzle_design, (raised, *parts[1:])).failures
        assert any("0.100 mm over the bed" in words for words in failures)


class TestFiles:
    """One STL and one plate hold the chain as it is printed."""

    def test_the_chain_is_one_file_of_several_solids(self, tmp_path: Path) -> None:
        puzzle_design, parts = puzzle(5, 1)
        folder = tmp_path / "out"
        write_puzzle(puzzle_design, parts, certificate_of(5, 1), folder)
        assert {path.name for path in folder.iterdir()} == {"chain.stl", "plate-1.3mf", "parts.json"}
        mesh = trimesh.load_mesh(folder / "chain.stl")
        assert mesh.is_watertight and mesh.body_count == len(puzzle_design.pieces)
        assert mesh.volume == pytest.approx(sum(part.volume for part in parts), rel=1e-6)
        scene = trimesh.load_scene(folder / "plate-1.3mf")
        assert len(scene.geometry) == 1
        placed = scene.to_mesh()
        assert placed.extents == pytest.approx(mesh.extents, abs=1e-3)
        assert placed.bounds[0, 2] == pytest.approx(0.0, abs=1e-6)
        assert (placed.bounds[0, :2] > 3.9).all() and (placed.bounds[1, :2] < 216.1).all()
        with zipfile.ZipFile(folder / "plate-1.3mf") as archive:
            model = archive.read("3D/3dmodel.model").decode()
            volumes = archive.read("Metadata/Slic3r_PE_model.config").decode()
        # One object of several bodies, so that a slicer moves all pieces together.
        assert model.count("<item ") == model.count("<object ") == 1
        assert volumes.count("<volume ") == volumes.count('key="extruder" value="1"') == len(puzzle_design.pieces)

    def test_the_command_prints_in_place(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        save(transform_of(3, 1), tmp_path / "pair.riot")
        out = tmp_path / "out"
        arguments = ["print", str(tmp_path / "pair.riot"), "-o", str(out), "--pivot", "in-place", "--paper"]
        assert main(arguments) == 0
        words = capsys.readouterr().out
        assert "in place" in words and "certificate: passed" in words
        names = {path.name for path in out.iterdir()}
        assert {"chain.stl", "plate-1.3mf", "assembly.pdf", "laser-strips.svg", "puzzle-p.png"} <= names
        assert not any(name.startswith(("piece-", "pin", "laser-layers")) for name in names)


def test_pages_say_that_there_is_nothing_to_insert() -> None:
    puzzle_design, _ = puzzle(0, 0)
    told = [mark.text for page in page_scenes(puzzle_design) for mark in page.marks if isinstance(mark, Label)]
    assert any("nothing to insert" in words for words in told)
    ends = {end_in_words(puzzle_design, end) for piece in puzzle_design.pieces for end in (piece.start, piece.end)}
    assert ends == {"free", "pin, in place", "socket, in place"}


def test_a_chain_takes_inlays_which_together_with_its_base_are_the_chain() -> None:
    puzzle_design, parts = puzzle(0, 0)
    inlaid = replace(puzzle_design, parameters=replace(puzzle_design.parameters, inlay_mm=0.6))
    drawing = drawing_of(inlaid)
    assert drawing is not None
    bodies = chain_bodies(inlaid, parts, {part.name: bodies_of(inlaid, part, drawing) for part in parts})
    whole = chain_part(inlaid, parts).solid
    together = manifold3d.Manifold.batch_boolean([body.solid for body in bodies], manifold3d.OpType.Add)
    assert {body.filament for body in bodies} == {1, 2} and len(bodies) == 3 * len(parts)
    assert sum(body.volume for body in bodies) == pytest.approx(whole.volume(), rel=1e-6)
    assert together.volume() == pytest.approx(whole.volume(), rel=1e-6)
