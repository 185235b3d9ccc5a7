"""Other programs read the solids: PrusaSlicer asks for no support and lays holes and pins as wide as designed; admesh
finds nothing to repair. Skipped where a program is missing."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import shapely

from riot.draw.texture.names import SIDES, Pattern
from riot.draw.texture.paint import pattern_texture
from riot.fabricate import Design, FabricationParameters, design, write_puzzle
from riot.fabricate.certificate import certify
from riot.fabricate.export.drawing import drawing_of
from riot.fabricate.export.stl import stl_bytes
from riot.fabricate.solid import make_parts
from riot.groundtruth.pairs import dudeney, exact_pair, exact_transform
from riot.parameters.fabrication import PIVOTS
from riot.types import FloatArray

pytestmark = pytest.mark.system
LINE_MM = 0.45
"""Width of the outer line that PrusaSlicer is told to lay."""

CHORDS_MM = 0.05
"""How much narrower a circle may come out that is laid in chords; half the interference of a pin."""

needs_slicer = pytest.mark.skipif(shutil.which("prusa-slicer") is None, reason="PrusaSlicer is not installed")
needs_admesh = pytest.mark.skipif(shutil.which("admesh") is None, reason="admesh is not installed")


@pytest.fixture(scope="module", params=sorted(set(PIVOTS) - {"in-place"}))
def puzzle(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Design, Path]:
    puzzle_design = design(exact_transform(dudeney()), FabricationParameters(**PIVOTS[request.param]))
    parts = make_parts(puzzle_design)
    folder = tmp_path_factory.mktemp("sliced") / request.param
    write_puzzle(puzzle_design, parts, certify(puzzle_design, parts), folder)
    return puzzle_design, folder


@pytest.fixture(scope="module")
def chain(tmp_path_factory: pytest.TempPathFactory) -> tuple[Design, Path]:
    puzzle_design = design(exact_transform(dudeney()), FabricationParameters(**PIVOTS["in-place"]))
    parts = make_parts(puzzle_design)
    folder = tmp_path_factory.mktemp("sliced") / "in-place"
    write_puzzle(puzzle_design, parts, certify(puzzle_design, parts), folder)
    return puzzle_design, folder


def sliced(model: Path, folder: Path, *options: str) -> str:
    target = folder / f"{model.stem}.gcode"
    settings = ["--nozzle-diameter", "0.4", "--layer-height", "0.2", "--first-layer-height", "0.2", "--skirts", "0"]
    settings += ["--external-perimeter-extrusion-width", str(LINE_MM), "--gcode-comments", *options]
    subprocess.run(["prusa-slicer", "-g", str(model), *settings, "-o", str(target)], check=True, capture_output=True)
    return target.read_text()


def outer_loops(code: str, height: float) -> list[FloatArray]:
    """The outer perimeters of the layer that ends at a height: middle lines of what is laid, mm."""
    layer = next(part for part in code.split(";LAYER_CHANGE") if re.search(rf"^;Z:{height:g}$", part, re.MULTILINE))
    loops: list[list[tuple[float, float]]] = []
    outer = False
    for line in layer.splitlines():
        if line.startswith(";TYPE:"):
            outer = "External perimeter" in line or "Overhang perimeter" in line
        move = re.match(r"G1 X([-\d.]+) Y([-\d.]+)(?: E([\d.]+))?", line)
        if move is None:
            continue
        there = float(move[1]), float(move[2])
        if move[3] is None:
            loops.append([there])
        elif outer:
            loops[-1].append(there)
    return [np.array(loop) for loop in loops if len(loop) > 8]


def widths(code: str, height: float) -> list[float]:
    """Diameters of the round loops of a layer, smallest first."""
    found = []
    for loop in outer_loops(code, height):
        region = shapely.Polygon(loop)
        round_ = region.area / (region.length**2 / (4.0 * np.pi))
        if round_ > 0.97:
            found.append(2.0 * float(np.sqrt(region.area / np.pi)))
    return sorted(found)


@needs_slicer
def test_the_slicer_asks_for_no_support(puzzle: tuple[Design, Path], tmp_path: Path) -> None:
    for model in sorted(puzzle[1].glob("*.stl")):
        code = sliced(model, tmp_path, "--support-material", "--support-material-auto")
        assert "TYPE:Support" not in code, model.name
        assert "TYPE:External perimeter" in code


@needs_slicer
def test_the_slicer_does_ask_where_a_piece_lies_wrongly(puzzle: tuple[Design, Path], tmp_path: Path) -> None:
    code = sliced(puzzle[1] / "piece-1.stl", tmp_path, "--support-material", "--rotate-x", "180")
    assert "TYPE:Support" in code


@needs_slicer
def test_holes_and_pins_are_laid_as_wide_as_designed(puzzle: tuple[Design, Path], tmp_path: Path) -> None:
    puzzle_design, folder = puzzle
    sizes = puzzle_design.parameters
    held = sizes.pin_mm + 2.0 * sizes.clearance_mm if sizes.pivot == "screw" else sizes.pin_mm - sizes.press_mm
    for piece in puzzle_design.pieces:
        code = sliced(folder / f"{piece.name}.stl", tmp_path)
        # Below the head, or above the nut: the last layer of the knuckle away from the bed.
        height = sizes.levels[0] if not piece.upside_down else round(sizes.height - sizes.levels[1], 6)
        count = (piece.start.kind == "pin") + (piece.end.kind == "pin")
        holes = [width - LINE_MM for width in widths(code, height)][:count]
        wanted = sizes.pin_mm + 2.0 * sizes.clearance_mm if piece.upside_down else held
        assert holes == pytest.approx([wanted] * len(holes), abs=CHORDS_MM) and holes
    if sizes.pivot == "printed":
        code = sliced(folder / "pin.stl", tmp_path)
        (pin,) = [width + LINE_MM for width in widths(code, 6.0)][-1:]
        assert pin == pytest.approx(sizes.pin_mm, abs=CHORDS_MM)
        assert pin - held == pytest.approx(sizes.press_mm, abs=CHORDS_MM)


@needs_slicer
def test_the_plate_is_sliced_as_a_whole(puzzle: tuple[Design, Path], tmp_path: Path) -> None:
    code = sliced(puzzle[1] / "plate-1.3mf", tmp_path, "--support-material", "--bed-shape", "0x0,220x0,220x220,0x220")
    assert "TYPE:Support" not in code and code.count(";LAYER_CHANGE") >= round(puzzle[0].parameters.height / 0.2)


@needs_slicer
def test_pockets_of_magnets_need_no_support(tmp_path: Path) -> None:
    puzzle_design = design(exact_transform(dudeney()), FabricationParameters(magnet_mm=4.0))
    for piece, part in zip(puzzle_design.pieces, make_parts(puzzle_design), strict=False):
        if piece.pockets:
            (tmp_path / f"{piece.name}.stl").write_bytes(stl_bytes(part))
            code = sliced(tmp_path / f"{piece.name}.stl", tmp_path, "--support-material", "--support-material-auto")
            assert "TYPE:Support" not in code and "TYPE:External perimeter" in code, piece.name


@needs_slicer
@pytest.mark.parametrize("pattern", [None, "bands"])
def test_inlays_are_sliced_where_they_are_and_nowhere_else(pattern: Pattern | None, tmp_path: Path) -> None:
    transform = exact_transform(exact_pair(4, 3))
    puzzle_design = design(transform, FabricationParameters(inlay_mm=0.6))
    parts, height = make_parts(puzzle_design), puzzle_design.parameters.height
    textures = {side: pattern_texture(pattern, transform, side) for side in SIDES if pattern}
    drawing = drawing_of(puzzle_design, textures)
    write_puzzle(puzzle_design, parts, certify(puzzle_design, parts), tmp_path / "puzzle", drawing=drawing)
    nozzles = ["--nozzle-diameter", "0.4,0.4,0.4,0.4", "--bed-shape", "0x0,220x0,220x220,0x220"]
    code = sliced(tmp_path / "puzzle" / "plate-1.3mf", tmp_path, "--support-material", *nozzles)
    assert "TYPE:Support" not in code
    used: dict[str, set[float]] = {}
    tool, z = "", 0.0
    for line in code.splitlines():
        if re.match(r"T\d\b", line):
            tool = line.split()[0]
        elif line.startswith(";Z:"):
            z = float(line[3:])
        elif re.match(r"G1 X[-\d.]+ Y[-\d.]+ E", line):
            used.setdefault(tool, set()).add(round(z, 3))
    assert len(used) == (4 if pattern else 2) and max(used["T0"]) == pytest.approx(height)
    low, high = {0.2, 0.4, 0.6}, {round(height - 0.4, 3), round(height - 0.2, 3), height}
    inlaid = set[float]().union(*(layers for name, layers in used.items() if name != "T0"))
    assert inlaid == low | high


@needs_slicer
@pytest.mark.parametrize("threshold", ["0", "55"])
def test_a_chain_in_place_is_sliced_without_supports_or_overhangs(
    chain: tuple[Design, Path], threshold: str, tmp_path: Path
) -> None:
    options = ["--support-material", "--support-material-auto", "--support-material-threshold", threshold]
    for name in ("chain.stl", "plate-1.3mf"):
        code = sliced(chain[1] / name, tmp_path, *options, "--bed-shape", "0x0,220x0,220x220,0x220")
        assert "TYPE:Support" not in code and "TYPE:Overhang" not in code, name
        assert "TYPE:External perimeter" in code


@needs_slicer
def test_pins_and_sockets_in_place_are_laid_with_their_gap(chain: tuple[Design, Path], tmp_path: Path) -> None:
    puzzle_design, folder = chain
    sizes, layer = puzzle_design.parameters, 0.2
    pivot = puzzle_design.pivot
    assert pivot is not None
    code = sliced(folder / "plate-1.3mf", tmp_path)
    hinges = sum(piece.start.kind == "pin" for piece in puzzle_design.pieces)
    for height in (layer, pivot.lower[len(pivot.lower) // 2].high, sizes.levels[0]):
        (pin,) = [ring.radius for ring in pivot.upper if ring.low < height - 0.5 * layer < ring.high]
        (hole,) = [ring.hole for ring in pivot.lower if ring.low < height - 0.5 * layer < ring.high]
        # The pins' outer lines lie within their edges, the sockets' outside of theirs; the sockets' chords are longer.
        wanted = [2.0 * pin - LINE_MM] * hinges + [2.0 * hole + LINE_MM] * hinges
        assert widths(code, height) == pytest.approx(wanted, abs=1.5 * CHORDS_MM), height


@needs_admesh
def test_admesh_finds_one_part_a_piece_in_a_chain(chain: tuple[Design, Path]) -> None:
    words = subprocess.run(["admesh", str(chain[1] / "chain.stl")], check=True, capture_output=True, text=True).stdout
    assert re.search(rf"Number of parts\s+:\s+{len(chain[0].pieces)}\b", words)
    assert re.search(r"Total disconnected facets\s+:\s+0\s+0\b", words)
    assert re.search(r"Degenerate facets\s+:\s+0\b", words)


@needs_admesh
def test_admesh_finds_nothing_to_repair(puzzle: tuple[Design, Path]) -> None:
    for model in sorted(puzzle[1].glob("*.stl")):
        words = subprocess.run(["admesh", str(model)], check=True, capture_output=True, text=True).stdout
        for what in ("Degenerate facets", "Edges fixed", "Facets removed", "Facets added", "Backwards edges"):
            assert re.search(rf"{what}\s+:\s+0\b", words), (model.name, what)
        assert re.search(r"Total disconnected facets\s+:\s+0\s+0\b", words)
        assert re.search(r"Number of parts\s+:\s+1\b", words)
