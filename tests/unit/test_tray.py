"""Trays to keep a puzzle in."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from pathlib import Path

import pytest
import shapely
import trimesh
from exact_designs import design_of, transform_of

from riot.cli.main import main
from riot.fabricate import FabricationError, FabricationParameters
from riot.fabricate.motion_check import placed_parts
from riot.fabricate.overhang import check_supports
from riot.fabricate.solid import extruded, make_parts
from riot.fabricate.tray import check_tray, check_tray_bed, tray_parts
from riot.fabricate.tuning import TRAY_FLOOR_MM, TRAY_GAP_MM
from riot.transform.riot_file import save


@pytest.mark.parametrize("pair", [(0, 0), (5, 1)])
def test_the_puzzle_goes_into_its_trays_closed_either_way(pair: tuple[int, int]) -> None:
    puzzle_design = design_of(*pair)
    parts = make_parts(puzzle_design)
    for tray, t in zip(tray_parts(puzzle_design), (0.0, 1.0), strict=True):
        check = check_tray(puzzle_design, tray)
        assert check.failures == () and TRAY_GAP_MM <= check.gap < TRAY_GAP_MM + 0.05
        assert check_supports(tray, 0.2).failures == ()
        # It lies on the floor, and meets the tray nowhere on its way down; it stands out, to be taken by its rim.
        for (name, solid), height in product(placed_parts(puzzle_design, parts, t), (0.001, 2.0)):
            assert (solid.translate((0.0, 0.0, TRAY_FLOOR_MM + height)) ^ tray.solid).volume() == 0.0, name
        assert tray.size[2] < TRAY_FLOOR_MM + puzzle_design.parameters.height - 3.0


def test_a_puzzle_that_is_read_on_its_back_lies_in_its_tray_turned_over() -> None:
    puzzle_design = design_of(5, 1)
    turned = replace(puzzle_design, transform=replace(puzzle_design.transform, mirrored_q=True))
    (_, tray), (_, mirrored) = tray_parts(puzzle_design), tray_parts(turned)
    image = shapely.transform(tray.slabs[1].section, lambda points: points * [-1.0, 1.0])
    assert image.symmetric_difference(mirrored.slabs[1].section).area < 0.1
    assert check_tray(turned, mirrored).failures == ()


def test_a_tray_that_is_too_narrow_fails() -> None:
    puzzle_design = design_of(0, 0)
    tray = tray_parts(puzzle_design)[0]
    floor, frame = tray.slabs
    slabs = floor, replace(frame, section=frame.section.buffer(0.4))
    narrow = replace(tray, slabs=slabs, solid=extruded(slabs))
    assert "less than 0.6" in check_tray(puzzle_design, narrow).failures[0]


def test_a_tray_larger_than_the_bed_is_refused_with_a_size_that_fits() -> None:
    with pytest.raises(FabricationError, match=r"tray-p is .* to about (\d+), .* leave out --tray") as caught:
        check_tray_bed(transform_of(0, 0), FabricationParameters(size_mm=230.0))
    size = float(str(caught.value).split("to about ")[1].split(",")[0])
    check_tray_bed(transform_of(0, 0), FabricationParameters(size_mm=size))


def test_the_command_writes_trays(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    save(transform_of(3, 1), tmp_path / "pair.riot")
    out = tmp_path / "out"
    assert main(["print", str(tmp_path / "pair.riot"), "-o", str(out), "--tray"]) == 0
    assert "tray-q: the puzzle lies in it with 0.6" in capsys.readouterr().out
    assert all(trimesh.load_mesh(out / f"tray-{side}.stl").is_watertight for side in "pq")
    assert '"tray"' in (out / "parts.json").read_text(encoding="utf-8")
