"""Flat files for lasers: what is read back is what was designed."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import ezdxf
import numpy as np
import pytest
import shapely
from svgelements import SVG
from svgelements import Path as SvgPath

from riot.errors import MissingExtraError
from riot.fabricate import Design, FabricationError, FabricationParameters, design
from riot.fabricate.export import flat as flat_module
from riot.fabricate.export.flat import KINDS, FlatFormatError, Kind, parts_of, write_flat, write_flat_files
from riot.fabricate.shelves import shelves
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.types import FloatArray

SPACE = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def puzzle_design() -> Design:
    return design(exact_transform(exact_pair(4, 3)), FabricationParameters(size_mm=150.0))


def area(points: FloatArray) -> float:
    return float(shapely.Polygon(points).area)


def svg_rings(path: Path) -> dict[str, list[tuple[str, FloatArray]]]:
    """Rings by group, in mm."""
    rings_read: dict[str, list[tuple[str, FloatArray]]] = {}
    for group in ElementTree.parse(path).getroot().iter(f"{SPACE}g"):
        rings = rings_read.setdefault(group.attrib["id"], [])
        for element in group:
            data = element.attrib["d"]
            assert data.count("M") == 1
            assert data.endswith("Z")
            rings.append((element.attrib["id"], np.array(re.findall(r"-?[\d.]+", data), dtype=float).reshape(-1, 2)))
    return rings_read


def dxf_rings(path: Path) -> list[tuple[str, FloatArray]]:
    """Rings in the order of the file, with their layers; mm."""
    drawing = ezdxf.readfile(path)  # type: ignore[attr-defined]
    assert drawing.units == ezdxf.units.MM
    assert not drawing.audit().errors
    low, high = drawing.header["$EXTMIN"], drawing.header["$EXTMAX"]
    assert 0.0 <= low[0] < high[0] < 1e4
    rings_read = []
    for entity in drawing.modelspace():
        assert entity.dxftype() == "LWPOLYLINE"
        assert entity.closed
        rings_read.append((entity.dxf.layer, np.array(entity.get_points("xy"))))
    return rings_read


@pytest.mark.parametrize("kerf", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_areas_are_read_back(puzzle_design: Design, tmp_path: Path, kind: Kind, kerf: bool) -> None:
    flat_parts = parts_of(puzzle_design, kind, puzzle_design.parameters.kerf_mm if kerf else 0.0)
    outlines = [area(np.array(flat_part.region.exterior.coords)) for flat_part in flat_parts]
    holes = [area(np.array(ring.coords)) for flat_part in flat_parts for ring in flat_part.region.interiors]
    write_flat(puzzle_design, tmp_path / "cut.svg", kind, kerf=kerf)
    write_flat(puzzle_design, tmp_path / "cut.dxf", kind, kerf=kerf)
    groups = svg_rings(tmp_path / "cut.svg")
    assert [area(ring) for _, ring in groups["outlines"]] == pytest.approx(outlines, rel=1e-6)
    assert [area(ring) for _, ring in groups.get("holes", [])] == pytest.approx(holes, rel=1e-6)
    drawn = dxf_rings(tmp_path / "cut.dxf")
    assert [area(ring) for _, ring in drawn] == pytest.approx(holes + outlines, rel=1e-6)
    assert [layer for layer, _ in drawn] == ["HOLES"] * len(holes) + ["OUTLINES"] * len(outlines)


def test_outlines_are_the_pieces_at_true_size(puzzle_design: Design, tmp_path: Path) -> None:
    write_flat(puzzle_design, tmp_path / "cut.svg")
    rings = svg_rings(tmp_path / "cut.svg")["outlines"]
    assert [name for name, _ in rings] == [piece.name for piece in puzzle_design.pieces]
    for (_, ring), piece in zip(rings, puzzle_design.pieces, strict=True):
        # Moved, and y turned over, no more: the same lengths one after another.
        assert np.diff(ring, axis=0) == pytest.approx(np.diff(piece.outline, axis=0) * [1.0, -1.0], abs=2e-6)


def test_sizes_are_in_millimetres(puzzle_design: Design, tmp_path: Path) -> None:
    write_flat(puzzle_design, tmp_path / "cut.svg")
    root = ElementTree.parse(tmp_path / "cut.svg").getroot()
    assert root.attrib["width"].endswith("mm")
    size = (float(root.attrib["width"][:-2]), float(root.attrib["height"][:-2]))
    assert [float(number) for number in root.attrib["viewBox"].split()] == [0.0, 0.0, *size]
    # Another reader, at one unit a millimetre, sees the same; its inch is off by a millionth.
    paths = [
        element for element in SVG.parse(tmp_path / "cut.svg", ppi=25.4).elements() if isinstance(element, SvgPath)
    ]
    seen = sum(area(np.array([(step.end.x, step.end.y) for step in path][1:])) for path in paths)
    assert seen == pytest.approx(sum(area(piece.outline) for piece in puzzle_design.pieces), rel=1e-5)


def test_lines_are_hair_thin_and_nothing_is_filled(puzzle_design: Design, tmp_path: Path) -> None:
    write_flat(puzzle_design, tmp_path / "cut.svg", "layers")
    root = ElementTree.parse(tmp_path / "cut.svg").getroot()
    groups = list(root.iter(f"{SPACE}g"))
    assert [group.attrib["id"] for group in groups] == ["holes", "outlines"]
    assert all(group.attrib["fill"] == "none" for group in groups)
    assert all(0.0 < float(group.attrib["stroke-width"]) < 0.05 for group in groups)


@pytest.mark.parametrize("kind", KINDS)
def test_parts_are_apart(puzzle_design: Design, kind: Kind) -> None:
    regions = [flat_part.region for flat_part in parts_of(puzzle_design, kind, 0.5)]
    for i, region in enumerate(regions):
        assert region.is_valid
        for other in regions[:i]:
            assert region.distance(other) > 0.99 * flat_module.LASER_SPACE_MM


@pytest.mark.parametrize("kind", KINDS)
def test_what_the_beam_leaves_is_nominal(puzzle_design: Design, kind: Kind) -> None:
    kerf = 0.3
    for nominal, path in zip(parts_of(puzzle_design, kind), parts_of(puzzle_design, kind, kerf), strict=True):
        left = path.region.buffer(-0.5 * kerf, quad_segs=64)
        # Only concave corners keep a fillet of half the kerf.
        assert left.area == pytest.approx(nominal.region.area, rel=1e-3)
        assert path.region.area > nominal.region.area
        assert len(path.region.interiors) == len(nominal.region.interiors)
        for hole, narrow in zip(nominal.region.interiors, path.region.interiors, strict=True):
            assert area(np.array(narrow.coords)) < area(np.array(hole.coords))


def test_layers_have_the_knuckles_holes(puzzle_design: Design) -> None:
    flat_parts = {flat_part.name: flat_part for flat_part in parts_of(puzzle_design, "layers")}
    pins = sum(pin.count for pin in puzzle_design.pins)
    for layer, expected in (("bottom", pins), ("middle", pins), ("top", pins)):
        holes = [
            ring
            for name, flat_part in flat_parts.items()
            if name.endswith(layer)
            for ring in flat_part.region.interiors
        ]
        assert len(holes) == expected
        widths = [np.ptp(np.array(ring.coords)[:, 0]) for ring in holes]
        more = puzzle_design.parameters.clearance_mm if layer == "middle" else puzzle_design.parameters.play_mm
        assert widths == pytest.approx([puzzle_design.parameters.pin_mm + 2.0 * more] * expected, rel=0.01)


def test_layers_of_telescopic_hinges_are_refused(puzzle_design: Design, tmp_path: Path) -> None:
    from riot.fabricate.telescope import make_telescope

    lifting = replace(puzzle_design, telescope=make_telescope(FabricationParameters(thickness_mm=15.0)))
    with pytest.raises(FabricationError, match="stacked"):
        write_flat(lifting, tmp_path / "cut.svg", "layers")
    written = write_flat_files(lifting, tmp_path)
    assert [path.name for path in written] == [
        "laser-outlines.svg",
        "laser-outlines-kerf.svg",
        "laser-outlines.dxf",
        "laser-outlines-kerf.dxf",
    ]


def test_files_are_deterministic(puzzle_design: Design, tmp_path: Path) -> None:
    for folder in ("first", "second"):
        (tmp_path / folder).mkdir()
    first, second = (
        write_flat_files(puzzle_design, tmp_path / "first"),
        write_flat_files(puzzle_design, tmp_path / "second"),
    )
    assert len(first) == 8
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]


def test_other_formats_are_refused(puzzle_design: Design, tmp_path: Path) -> None:
    with pytest.raises(FlatFormatError, match=r"\.svg or \.dxf"):
        write_flat(puzzle_design, tmp_path / "cut.pdf")
    assert not list(tmp_path.iterdir())


def test_dxf_without_its_package(puzzle_design: Design, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise ModuleNotFoundError(name=name)

    monkeypatch.setattr(flat_module.importlib, "import_module", missing)
    with pytest.raises(MissingExtraError, match=r"riot-shapes\[print\]"):
        write_flat(puzzle_design, tmp_path / "cut.dxf")
    write_flat(puzzle_design, tmp_path / "cut.svg")


def test_shelves_keep_boxes_apart_and_on_their_pages() -> None:
    sizes = np.random.default_rng(1).uniform(5.0, 60.0, (40, 2))
    sizes[0] = (150.0, 20.0)
    spots = shelves(sizes, 100.0, 160.0, 4.0)
    assert spots[0].turned
    boxes = []
    for spot, size in zip(spots, sizes, strict=True):
        wide, high = size[::-1] if spot.turned else size
        assert 0.0 <= spot.x <= spot.x + wide <= 100.0
        assert 0.0 <= spot.y <= spot.y + high <= 160.0
        boxes.append((spot.page, shapely.box(spot.x, spot.y, spot.x + wide, spot.y + high)))
    for i, (page, box) in enumerate(boxes):
        assert all(page != other or box.distance(near) > 3.99 for other, near in boxes[:i])
    assert 1 < len({page for page, _ in boxes}) < 8
    with pytest.raises(ValueError, match="does not fit"):
        shelves(np.array([[120.0, 170.0]]), 100.0, 160.0, 4.0)
