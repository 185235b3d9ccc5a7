"""Magnets at the open hinge: pockets that meet, take magnets, and print; what the certificate catches."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import trimesh
from exact_designs import design_of, transform_of, with_piece

from riot.cli.main import main
from riot.fabricate import Design, FabricationError, FabricationParameters, PieceDesign, design
from riot.fabricate.certificate import certify
from riot.fabricate.export.flat import laser_notes
from riot.fabricate.export.flat_parts import flat_parts
from riot.fabricate.export.instructions import magnet_steps
from riot.fabricate.magnet_check import MagnetCheck, check_magnets, magnet
from riot.fabricate.overhang import check_supports
from riot.fabricate.pocket import Pocket
from riot.fabricate.solid import Part, common_volume, make_parts
from riot.fabricate.tuning import LEAST_WALL_MM, MAGNET_FIT_MM, SLOPE
from riot.transform.riot_file import save

PAIRS = ((0, 0), (5, 1), (6, 2))
MAGNET = FabricationParameters(magnet_mm=4.0)


@cache
def puzzle(n: int, seed: int) -> tuple[Design, tuple[Part, ...]]:
    puzzle_design = design(transform_of(n, seed), MAGNET)
    return puzzle_design, make_parts(puzzle_design)


def pockets(puzzle_design: Design, side: str) -> list[tuple[PieceDesign, Pocket]]:
    return [(piece, pocket) for piece in puzzle_design.pieces for pocket in piece.pockets if pocket.side == side]


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("side", ["p", "q"])
def test_two_magnets_meet_face_to_face_in_either_shape_and_attract(pair: tuple[int, int], side: str) -> None:
    puzzle_design, _ = puzzle(*pair)
    pose = puzzle_design.transform.pose(0.0 if side == "p" else 1.0)
    (one, first), (other, second) = pockets(puzzle_design, side)
    assert {one.index, other.index} == {
        puzzle_design.motion.open_hinge,
        (puzzle_design.motion.open_hinge - 1) % len(pose.headings),
    }
    faces = [
        puzzle_design.place(pose, piece.index, np.array([[pocket.x, pocket.y]]))[0]
        for piece, pocket in ((one, first), (other, second))
    ]
    heading = first.heading + pose.headings[one.index]
    assert math.cos(heading - second.heading - pose.headings[other.index]) == pytest.approx(-1.0)
    apart = faces[0] - faces[1]
    assert np.hypot(*apart) == pytest.approx(apart @ [math.cos(heading), math.sin(heading)], abs=0.002)
    assert 0.3 < np.hypot(*apart) < MAGNET.gap_mm + 0.7
    assert {first.pole, second.pole} == {"north", "south"}


@pytest.mark.parametrize("pair", PAIRS)
def test_puzzles_with_magnets_pass_and_print_without_supports(pair: tuple[int, int]) -> None:
    certificate = certify(*puzzle(*pair))
    assert certificate.failures == ()
    assert len([words for words in certificate.words() if words.startswith("magnets of ")]) == 2
    assert certificate.bridge == 0.0


def test_sections_lose_what_a_magnet_and_its_roof_take() -> None:
    """The two pieces of Dudeney's at the open hinge have straight walls: a box is what they lose."""
    (with_magnets, _), without = puzzle(0, 0), design_of(0, 0)
    height, layer = MAGNET.height, MAGNET.layer_mm
    radius, depth = 0.5 * MAGNET.magnet_mm + MAGNET_FIT_MM, MAGNET.magnet_height_mm + MAGNET_FIT_MM
    for piece, plain in zip(with_magnets.pieces, without.pieces, strict=True):
        for k in range(round(height / layer)):
            middle = (k + 0.5) * layer
            whole, bored = (
                next(slab.section for slab in of.slabs if slab.low < middle < slab.high) for of in (plain, piece)
            )
            over = (height - middle if piece.upside_down else middle) - 0.5 * height - 0.5 * layer  # as it is printed
            half, below = (min(radius, (radius / math.sin(math.atan(SLOPE)) - z) * SLOPE) for z in (over, over - layer))
            width = 2.0 * half if over > 1e-9 - radius - layer and below > layer else 0.0
            assert whole.area - bored.area == pytest.approx(len(piece.pockets) * width * depth, abs=0.02)
            assert whole.buffer(0.002).covers(bored)
            # The circle of a magnet is within the room at all heights of the layer.
            nearest = min(max(0.0, over), over + layer)
            assert not piece.pockets or width >= 2.0 * math.sqrt(max(0.0, radius**2 - nearest**2)) - 1e-6


@pytest.mark.parametrize("pair", PAIRS)
def test_magnets_go_in_and_larger_ones_do_not(pair: tuple[int, int]) -> None:
    puzzle_design, parts = puzzle(*pair)
    larger = replace(puzzle_design, parameters=replace(MAGNET, magnet_mm=4.3))
    for piece in puzzle_design.pieces:
        for pocket in piece.pockets:
            solid = next(part.solid for part in parts if part.name == piece.name)
            assert common_volume(solid, magnet(puzzle_design, pocket, reach=3.0)) == 0.0
            assert common_volume(solid, magnet(larger, pocket)) > 0.1


def test_both_kinds_of_pieces_have_their_roofs_above_when_they_are_printed() -> None:
    puzzle_design, parts = puzzle(0, 0)
    both = [(piece, part) for piece, part in zip(puzzle_design.pieces, parts, strict=False) if piece.pockets]
    assert {piece.upside_down for piece, _ in both} == {False, True}
    for _, part in both:
        assert check_supports(part, 0.2).failures == ()
        assert check_supports(replace(part, upside_down=not part.upside_down), 0.2).failures


def test_layers_for_a_laser_have_slots_as_wide_as_the_magnet_all_through() -> None:
    puzzle_design, _ = puzzle(5, 1)
    assert "slots through both layers" in laser_notes(puzzle_design)[0]
    regions = {part.name: part.region for part in flat_parts(puzzle_design, "layers")}
    for piece in puzzle_design.pieces:
        for pocket in piece.pockets:
            slot = pocket.box(0.01, pocket.depth - 0.01, MAGNET.magnet_mm)
            assert not any(regions[f"{piece.name}-{layer}"].intersects(slot) for layer in ("bottom", "top"))


def changed(puzzle_design: Design, change: Callable[[Pocket], Pocket]) -> list[MagnetCheck]:
    """The checks after a change of the first magnet's pocket of the first piece that has one; its solid stays."""
    index = next(piece.index for piece in puzzle_design.pieces if piece.pockets)
    other = with_piece(
        puzzle_design, index, lambda piece: replace(piece, pockets=(change(piece.pockets[0]), *piece.pockets[1:]))
    )
    return list(check_magnets(other, puzzle(0, 0)[1]))


def test_the_certificate_catches_magnets_that_repel_miss_or_do_not_go_in() -> None:
    puzzle_design, _ = puzzle(0, 0)
    repels, _ = changed(
        puzzle_design, lambda pocket: replace(pocket, pole="south" if pocket.pole == "north" else "north")
    )
    assert repels.failures == ("magnets of P do not attract each other",)
    misses, _ = changed(puzzle_design, lambda pocket: replace(pocket, x=pocket.x + 0.1))
    assert any("do not meet face to face" in words for words in misses.failures)
    assert any("does not go into its pocket" in words for words in misses.failures)
    solid = make_parts(design_of(0, 0))
    assert all("does not go into its pocket" in check.failures[0] for check in check_magnets(puzzle_design, solid))


def test_the_certificate_catches_thin_walls() -> None:
    puzzle_design, parts = puzzle(0, 0)
    index = next(piece.index for piece in puzzle_design.pieces if piece.pockets)
    pocket = puzzle_design.pieces[index].pockets[0]
    hole = pocket.box(pocket.depth + 0.4, pocket.depth + LEAST_WALL_MM + 0.4, 1.0)
    thin = with_piece(
        puzzle_design,
        index,
        lambda piece: replace(
            piece, slabs=tuple(replace(slab, section=slab.section.difference(hole)) for slab in piece.slabs)
        ),
    )
    assert "thinner than 0.8 mm" in check_magnets(thin, parts)[0].failures[0]


def test_what_does_not_fit_is_refused_with_what_does() -> None:
    words = r"9 mm are too thin for a magnet of 5 mm .* or take smaller magnets \(magnet_mm=4\)"
    with pytest.raises(FabricationError, match=words) as caught:
        design(transform_of(0, 0), replace(MAGNET, magnet_mm=5.0))
    assert caught.value.parameter == "thickness_mm"
    thick = replace(MAGNET, magnet_mm=5.0, thickness_mm=caught.value.value)
    assert check_magnets(*_built(transform_of(0, 0), thick))[0].failures == ()
    with pytest.raises(FabricationError, match="too thin"):
        design(transform_of(0, 0), replace(thick, thickness_mm=caught.value.value - 0.2))
    small = replace(MAGNET, magnet_mm=8.0, thickness_mm=18.0, size_mm=45.0, pin_mm=1.75, wall_mm=0.8)
    with pytest.raises(
        FabricationError, match=r"no place for magnets of 8 × 2 mm .* \(magnet_mm=\d\), enlarge"
    ) as caught:
        design(transform_of(6, 2), small)
    fitting = float(str(caught.value).split("magnet_mm=")[1][0])
    design(transform_of(6, 2), replace(small, magnet_mm=fitting))


def _built(transform: object, parameters: FabricationParameters) -> tuple[Design, tuple[Part, ...]]:
    puzzle_design = design(transform, parameters)  # type: ignore[arg-type]
    return puzzle_design, make_parts(puzzle_design)


def test_the_command_writes_pockets_and_tells_where_poles_go(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save(transform_of(0, 0), tmp_path / "d.riot")
    out = tmp_path / "out"
    assert main(["print", str(tmp_path / "d.riot"), "-o", str(out), "--magnet", "4", "--magnet-height", "2"]) == 0
    assert "magnets of P: north in piece-1 and south in piece-2, faces 0.36 mm apart" in capsys.readouterr().out
    assert '"magnets"' in (out / "parts.json").read_text(encoding="utf-8")
    for index in (1, 2):
        mesh = trimesh.load_mesh(out / f"piece-{index}.stl")
        assert mesh.is_watertight and mesh.body_count == 1
    (step,) = magnet_steps(puzzle(0, 0)[0])
    assert "marks outside in piece 1, inside in piece 2" in step
    assert main(["print", str(tmp_path / "d.riot"), "-o", str(tmp_path / "thin"), "--magnet", "8"]) == 2
    told = capsys.readouterr().err
    assert "--thickness: pieces of 9 mm are too thin" in told and "Way out" not in told
