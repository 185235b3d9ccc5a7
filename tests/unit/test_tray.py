"""Trays to keep a puzzle in."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import shapely
import trimesh
from exact_designs import design_of, transform_of

from riot.cli.main import main
from riot.draw.scene import Region
from riot.fabricate import FabricationError, FabricationParameters
from riot.fabricate.export.flat import write_flat_files
from riot.fabricate.export.tray_sheet import tray_flat_parts, tray_marks
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


def test_a_laser_cuts_a_base_and_frames_and_the_booklet_shows_them(tmp_path: Path) -> None:
    puzzle_design = design_of(5, 1)
    trays = tray_parts(puzzle_design)
    parts = {part.name: part for part in tray_flat_parts(puzzle_design, trays)}
    assert set(parts) == {"tray-p-base", "tray-p-frame", "tray-q-base", "tray-q-frame"}
    for tray in trays:
        base, frame = parts[f"{tray.name}-base"], parts[f"{tray.name}-frame"]
        assert (base.copies, frame.copies) == (1, 2)  # 5.4 mm deep, of sheets of 3 mm
        recess = base.region.difference(frame.region)
        assert recess.area == pytest.approx(base.region.area - frame.region.area)
        assert not base.engraved.is_empty and base.region.contains(base.engraved)
    names = {path.name for path in write_flat_files(puzzle_design, tmp_path, dxf=False, trays=trays)}
    assert {"laser-trays-1.svg", "laser-trays-kerf-1.svg"} <= names
    drawn = tray_marks(puzzle_design, trays[1], (60.0, 40.0))
    points = np.concatenate([ring for mark in drawn if isinstance(mark, Region) for ring in mark.rings])
    assert len(drawn) == 2 + len(puzzle_design.pieces)
    assert np.ptp(points, axis=0).max() <= 60.0 + 1e-9 and abs(points.max(axis=0) + points.min(axis=0)).max() < 1e-6


def test_the_command_writes_trays(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    save(transform_of(3, 1), tmp_path / "pair.riot")
    out = tmp_path / "out"
    assert main(["print", str(tmp_path / "pair.riot"), "-o", str(out), "--tray"]) == 0
    assert "tray-q: the puzzle lies in it with 0.6" in capsys.readouterr().out
    assert all(trimesh.load_mesh(out / f"tray-{side}.stl").is_watertight for side in "pq")
    record = json.loads((out / "parts.json").read_text(encoding="utf-8"))
    assert {check["name"]: round(check["gap"], 1) for check in record["certificate"]["trays"]} == {
        "tray-p": 0.6,
        "tray-q": 0.6,
    }
