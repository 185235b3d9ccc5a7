"""The files of a puzzle: read back by another program they are the same solids; all are written, or none."""

from __future__ import annotations

import json
import re
import struct
import zipfile
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh

from riot.cli import print_puzzle
from riot.cli.main import main
from riot.draw.palette import PIECES
from riot.fabricate import Design, FabricationError, FabricationParameters, design
from riot.fabricate.certificate import FabricationCertificate, certify
from riot.fabricate.export.solids import write_puzzle
from riot.fabricate.export.stl import stl_bytes
from riot.fabricate.plates import check_bed, lay_out
from riot.fabricate.solid import Part, make_parts
from riot.fabricate.tuning import BED_SPACE_MM
from riot.groundtruth.pairs import dudeney, exact_pair, exact_transform
from riot.transform.riot_file import save

Puzzle = tuple[Design, tuple[Part, ...], FabricationCertificate]


def made_of(n: int, seed: int, parameters: FabricationParameters) -> Puzzle:
    puzzle = design(exact_transform(dudeney() if n == 0 else exact_pair(n, seed)), parameters)
    parts = make_parts(puzzle)
    return puzzle, parts, certify(puzzle, parts)


@pytest.fixture(scope="module")
def puzzle() -> Puzzle:
    return made_of(0, 0, FabricationParameters())


@pytest.fixture(scope="module")
def folder(puzzle: Puzzle, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("print") / "puzzle"
    write_puzzle(*puzzle, path)
    return path


def test_every_stl_reads_back_as_the_same_closed_solid(puzzle: Puzzle, folder: Path) -> None:
    for solid_part in puzzle[1]:
        mesh = trimesh.load_mesh(folder / f"{solid_part.name}.stl")
        assert mesh.is_watertight and mesh.is_winding_consistent
        assert mesh.volume == pytest.approx(solid_part.volume, rel=1e-6)
        assert mesh.extents == pytest.approx(solid_part.size, abs=1e-5)
        assert mesh.euler_number == 2 - 2 * solid_part.solid.genus()


def test_a_plate_reads_back_with_all_parts_named_apart_and_on_the_bed(puzzle: Puzzle, folder: Path) -> None:
    scene = trimesh.load_scene(folder / "plate-1.3mf")
    parts = {solid_part.name: solid_part for solid_part in puzzle[1]}
    assert set(scene.geometry) == set(parts)
    for name, mesh in scene.geometry.items():
        assert mesh.is_watertight
        assert mesh.volume == pytest.approx(parts[name].volume, rel=1e-6)
    boxes = []
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        assert np.linalg.det(transform[:3, :3]) == pytest.approx(1.0)
        boxes.append(trimesh.bounds.corners(scene.geometry[name].bounds) @ transform[:3, :3].T + transform[:3, 3])
    assert len(boxes) == sum(solid_part.count for solid_part in puzzle[1])
    ends = [(box.min(axis=0), box.max(axis=0)) for box in boxes]
    for k, (low, high) in enumerate(ends):
        assert low[2] == pytest.approx(0.0, abs=1e-6)
        assert min(low[:2]) >= BED_SPACE_MM - 1e-4
        assert max(high[:2]) <= 220.0 - BED_SPACE_MM + 1e-4
        for other_low, other_high in ends[:k]:
            gaps = np.maximum(low - other_high, other_low - high)[:2]
            assert gaps.max() >= BED_SPACE_MM - 1e-4


def test_files_are_the_same_bytes_every_time(puzzle: Puzzle, folder: Path, tmp_path: Path) -> None:
    again = made_of(0, 0, FabricationParameters())
    written = write_puzzle(*again, tmp_path / "again")
    assert [path.name for path in written] == sorted(path.name for path in folder.iterdir())
    for path in written:
        assert path.read_bytes() == (folder / path.name).read_bytes()


def test_the_list_of_parts_adds_up(puzzle: Puzzle, folder: Path) -> None:
    document = json.loads((folder / "parts.json").read_text(encoding="utf-8"))
    listed = {entry["name"]: entry for entry in document["parts"]}
    for solid_part in puzzle[1]:
        entry = listed[solid_part.name]
        assert entry["count"] == solid_part.count
        assert entry["volume_mm3"] == pytest.approx(solid_part.volume, abs=1e-6)
        assert (folder / entry["file"]).exists()
    laid = [name for plate in document["plates"] for name in plate["parts"]]
    assert {name: laid.count(name) for name in laid} == {solid_part.name: solid_part.count for solid_part in puzzle[1]}
    assert document["pins"] == [{"kind": "printed", "diameter": 3.0, "length": 9.0, "count": 3}]
    assert document["parameters"]["size_mm"] == 120.0
    assert document["certificate"]["passed"] is True
    assert len([hinge for hinge in document["hinges"] if hinge["kind"] == "pin"]) == 3


def test_pieces_of_a_plate_have_the_colours_of_their_pictures(folder: Path) -> None:
    with zipfile.ZipFile(folder / "plate-1.3mf") as archive:
        root = ElementTree.fromstring(archive.read("3D/3dmodel.model"))
    space = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
    (group,) = root.iter(f"{space}basematerials")
    colours = {base.attrib["name"]: base.attrib["displaycolor"] for base in group}
    assert [colours[f"piece-{k + 1}"] for k in range(4)] == [colour.upper() for colour in PIECES[:4]]
    for part in root.iter(f"{space}object"):
        assert part.attrib["pid"] == group.attrib["id"]
        assert group[int(part.attrib["pindex"])].attrib["name"] == part.attrib["name"]


def test_an_stl_has_unit_normals_that_point_outwards(puzzle: Puzzle) -> None:
    data = stl_bytes(puzzle[1][0])
    (count,) = struct.unpack("<I", data[80:84])
    record = np.frombuffer(data[84:], dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    assert len(record) == count
    assert not data.startswith(b"solid")
    assert np.linalg.norm(record["normal"], axis=1) == pytest.approx(np.ones(count), abs=1e-5)
    top = record["corners"][:, :, 2].min(axis=1) == 9.0
    assert top.any() and (record["normal"][top, 2] == 1.0).all()


def test_a_small_bed_takes_several_plates_and_a_smaller_one_is_refused() -> None:
    puzzle = design(exact_transform(exact_pair(4, 3)), FabricationParameters(bed_width_mm=100.0, bed_depth_mm=100.0))
    parts = make_parts(puzzle)
    plates = lay_out(parts, puzzle.parameters)
    assert len(plates) > 1
    assert sorted(item.name for plate in plates for item in plate) == sorted(
        name for solid_part in parts for name in [solid_part.name] * solid_part.count
    )
    large = design(puzzle.transform, replace(puzzle.parameters, size_mm=400.0))
    with pytest.raises(FabricationError, match=r"piece-\d is \d+ × \d+ mm, the bed 100 × 100 mm: lessen size_mm"):
        lay_out(make_parts(large), large.parameters)


def test_nothing_is_written_if_anything_fails(puzzle: Puzzle, tmp_path: Path) -> None:
    drawn, parts, certificate = puzzle

    def fails(folder: Path) -> None:
        assert (folder / "parts.json").exists()
        raise RuntimeError("the printer is on fire")

    with pytest.raises(RuntimeError, match="on fire"):
        write_puzzle(drawn, parts, certificate, tmp_path / "puzzle", [fails])
    assert list(tmp_path.iterdir()) == []
    worse = replace(certificate, motion=replace(certificate.motion, failures=("hinge 2: too near",)))
    with pytest.raises(FabricationError, match="hinge 2: too near"):
        write_puzzle(drawn, parts, worse, tmp_path / "puzzle")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_with_something_in_it_is_left_alone(puzzle: Puzzle, tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(FileExistsError, match="is not empty"):
        write_puzzle(*puzzle, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


SMALL = ["--size", "30", "--pin", "8", "--wall", "6"]
"""Knuckles too large for the pieces."""


class TestPrint:
    """`riot print`."""

    @pytest.fixture
    def saved(self, tmp_path: Path) -> Path:
        path = tmp_path / "puzzle.riot"
        save(exact_transform(dudeney()), path)
        return path

    def test_writes_the_files_and_tells_the_certificate(
        self, saved: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        out = tmp_path / "out"
        assert main(["print", str(saved), "-o", str(out), "--size", "90", "--pin", "1.75", "--wall", "1.2"]) == 0
        output = capsys.readouterr().out
        assert "certificate: passed" in output and "proven at every moment" in output and "piece-4" in output
        assert {path.name for path in out.iterdir()} >= {"piece-1.stl", "pin.stl", "plate-1.3mf", "parts.json"}
        parameters = json.loads((out / "parts.json").read_text(encoding="utf-8"))["parameters"]
        assert (parameters["size_mm"], parameters["pin_mm"], parameters["wall_mm"]) == (90.0, 1.75, 1.2)

    @pytest.mark.parametrize(
        ("options", "reason"),
        [
            (["--size", "5"], "--size: must be 30 to 1000 mm, got 5.0"),
            (SMALL, "enlarge --size (30)"),
            (
                ["--size", "30"],
                "its hinges are 108% as large as it, more than 25%: enlarge --size (30) to 62, or to 52 with filament",
            ),
            (["--size", "30"], "Way out: it passes with --size:"),
        ],
    )
    def test_says_why_it_cannot_be_made(
        self, options: list[str], reason: str, saved: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        out = tmp_path / "out"
        assert main(["print", str(saved), "-o", str(out), *options]) == 2
        assert reason in capsys.readouterr().err
        assert not out.exists()

    def test_says_what_makes_a_weak_place_strong(
        self, saved: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert main(["print", str(saved), "-o", str(tmp_path / "out"), "-v"]) == 0
        output = capsys.readouterr().out
        assert "warning: piece-2: only 2.1 mm wide at its narrowest, where 3.2 mm would be strong" in output
        (wall,) = re.findall(r"advice: no place is narrower than 3.2 mm with --wall=([\d.]+)", output)
        assert main(["print", str(saved), "-o", str(tmp_path / "strong"), "-v", "--wall", wall]) == 0
        output = capsys.readouterr().out
        assert "at its narrowest" not in output and "advice" not in output

    def test_fixes_it_when_told_to(self, saved: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["print", str(saved), "-o", str(tmp_path / "out"), *SMALL, "--fix"]) == 0
        assert "changed: --pin: 1.75 instead of 8" in capsys.readouterr().out

    def test_what_is_certain_is_told_before_the_work(
        self, saved: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def too_late(*_: object) -> None:
            raise AssertionError("the puzzle is being built")

        monkeypatch.setattr(print_puzzle, "build", too_late)
        command = ["print", str(saved), "-o"]
        assert main([*command, str(tmp_path / "out"), "--size", "400"]) == 2
        message = capsys.readouterr().err
        assert "mm, the bed 220 × 220 mm: lessen --size (400) to about" in message and "--bed-width" in message
        advised = int(re.findall(r"to about (\d+)", message)[0])
        check_bed(exact_transform(dudeney()), FabricationParameters(size_mm=float(advised)))
        with pytest.raises(FabricationError, match="lessen"):
            check_bed(exact_transform(dudeney()), FabricationParameters(size_mm=advised + 5.0))

        (tmp_path / "file").write_text("")
        assert main([*command, str(tmp_path / "file" / "out")]) == 2
        assert str(tmp_path / "file" / "out") in capsys.readouterr().err
        (tmp_path / "full").mkdir()
        (tmp_path / "full" / "mine.txt").write_text("mine")
        assert main([*command, str(tmp_path / "full")]) == 2
        assert "is not empty: name another folder, or replace what is in it (--force)" in capsys.readouterr().err
        assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "full", "puzzle.riot"]

    def test_force_replaces_an_older_puzzle_and_keeps_the_rest(self, saved: Path, tmp_path: Path) -> None:
        out = tmp_path / "out"
        command = ["print", str(saved), "-o", str(out), "--size", "90"]
        assert main(command) == 0
        for name in ("mine.txt", "piece-9.stl"):
            (out / name).write_text("")
        before = (out / "parts.json").read_bytes()
        assert main(command) == 2
        assert main([*command[:-1], "100", "--force"]) == 0
        assert (out / "mine.txt").exists() and not (out / "piece-9.stl").exists()
        assert (out / "parts.json").read_bytes() != before and (out / "piece-1.stl").stat().st_size > 0
