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
from riot.fabricate.export import laser_sheet
from riot.fabricate.export.flat import FlatFormatError, laser_notes, write_flat, write_flat_files
from riot.fabricate.export.flat_parts import KINDS, FlatPart, Kind, flat_parts, stack_mm
from riot.fabricate.export.laser_coupon import CUTS, LAMELLA_MM, laser_coupon
from riot.fabricate.export.laser_sheet import LASER_COLOURS, LASER_SPACE_MM, laser_sheets
from riot.fabricate.telescope import make_telescope
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.types import FloatArray

SPACE = "{http://www.w3.org/2000/svg}"
INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"


@pytest.fixture(scope="module")
def puzzle_design() -> Design:
    return design(exact_transform(exact_pair(4, 3)), FabricationParameters(size_mm=150.0))


def area(points: FloatArray) -> float:
    return float(shapely.Polygon(points).area)


def svg_rings(path: Path) -> dict[str, list[tuple[str, FloatArray]]]:
    """Closed lines by layer, in mm; names of one ring in the group of each path."""
    rings_read: dict[str, list[tuple[str, FloatArray]]] = {}
    for group in ElementTree.parse(path).getroot().iter(f"{SPACE}g"):
        rings = rings_read.setdefault(group.attrib["id"], [])
        for element in group:
            for line in re.findall(r"M([^MZ]+)Z", element.attrib["d"]):
                points = np.array(re.findall(r"-?[\d.]+", line), dtype=float).reshape(-1, 2)
                rings.append((element.attrib["id"], points))
    return rings_read


def dxf_rings(path: Path) -> list[tuple[str, FloatArray]]:
    """Closed lines in the order of the file, with their layers; mm."""
    drawing = ezdxf.readfile(path)  # type: ignore[attr-defined]
    assert drawing.units == ezdxf.units.MM
    assert not drawing.audit().errors
    low, high = drawing.header["$EXTMIN"], drawing.header["$EXTMAX"]
    assert 0.0 <= low[0] < high[0] < 1e4
    return [(entity.dxf.layer, np.array(entity.get_points("xy"))) for entity in drawing.modelspace() if entity.closed]


def expected_areas(parts: list[FlatPart]) -> list[float]:
    """Of holes and outlines as they are cut."""
    holes = [area(np.array(ring.coords)) for part in parts for ring in part.region.interiors]
    return [*holes, *(area(np.array(part.region.exterior.coords)) for part in parts)]


@pytest.mark.parametrize("kerf", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_areas_are_read_back(puzzle_design: Design, tmp_path: Path, kind: Kind, kerf: bool) -> None:
    sheets = laser_sheets(flat_parts(puzzle_design, kind), puzzle_design.parameters, kerf=kerf)
    expected = expected_areas([part for sheet in sheets for part in sheet.parts])
    write_flat(puzzle_design, tmp_path / "cut.svg", kind, kerf=kerf)
    write_flat(puzzle_design, tmp_path / "cut.dxf", kind, kerf=kerf)
    assert len(list(tmp_path.iterdir())) == 2  # one sheet
    layers = svg_rings(tmp_path / "cut.svg")
    assert list(layers) == list(LASER_COLOURS)
    assert [area(ring) for _, ring in layers["cut"]] == pytest.approx(expected, rel=1e-6)
    drawn = dxf_rings(tmp_path / "cut.dxf")
    assert [area(ring) for layer, ring in drawn if layer == "CUT"] == pytest.approx(expected, rel=1e-6)
    assert sum(layer == "ENGRAVE" for layer, _ in drawn) == len(layers["engrave"]) > 0


def test_outlines_are_the_pieces_at_true_size(puzzle_design: Design, tmp_path: Path) -> None:
    write_flat(puzzle_design, tmp_path / "cut.svg")
    rings = svg_rings(tmp_path / "cut.svg")["cut"]
    assert len({name for name, _ in rings}) == len(rings) == 3 * len(puzzle_design.pieces)  # three sheets of 3 mm
    for piece in puzzle_design.pieces:
        outline = np.append(piece.outline, piece.outline[:1], axis=0)
        for name, ring in rings:
            if name.startswith(piece.name):
                # Turned, moved, and y turned over, no more: the same lengths one after another.
                ring = np.append(ring, ring[:1], axis=0)
                lengths = [np.hypot(*np.diff(points, axis=0).T) for points in (ring, outline)]
                assert lengths[0] == pytest.approx(lengths[1], abs=3e-6)
                assert area(ring) == pytest.approx(area(outline), rel=1e-6)


def test_sizes_are_in_millimetres(puzzle_design: Design, tmp_path: Path) -> None:
    write_flat(puzzle_design, tmp_path / "cut.svg")
    root = ElementTree.parse(tmp_path / "cut.svg").getroot()
    assert (root.attrib["width"], root.attrib["height"]) == ("220mm", "220mm")  # the bed's
    assert root.attrib["viewBox"] == "0 0 220 220"
    # Another reader, at one unit a millimetre, sees the same; its inch is off by a millionth.
    paths = [
        element
        for element in SVG.parse(tmp_path / "cut.svg", ppi=25.4).elements()
        if isinstance(element, SvgPath) and element.stroke.hex == LASER_COLOURS["cut"]
    ]
    seen = sum(area(np.array([(step.end.x, step.end.y) for step in path][1:])) for path in paths)
    assert seen == pytest.approx(3 * sum(area(piece.outline) for piece in puzzle_design.pieces), rel=1e-5)


def test_layers_are_those_of_lightburn_and_inkscape(puzzle_design: Design, tmp_path: Path) -> None:
    write_flat(puzzle_design, tmp_path / "cut.svg")
    groups = list(ElementTree.parse(tmp_path / "cut.svg").getroot().iter(f"{SPACE}g"))
    assert [group.attrib[f"{INKSCAPE}label"] for group in groups] == ["engrave", "score", "cut"]
    for group in groups:
        assert group.attrib[f"{INKSCAPE}groupmode"] == "layer"
        lines = group.attrib["id"] != "engrave"
        colour = LASER_COLOURS[group.attrib["id"]]
        assert (group.attrib["fill"], group.attrib["stroke"]) == (("none", colour) if lines else (colour, "none"))
        # Thin enough for a laser's driver (half a point), wide enough for a screen of 96 dots per inch.
        assert not lines or 0.1 <= float(group.attrib["stroke-width"]) <= 0.18


@pytest.mark.parametrize("kind", KINDS)
def test_parts_are_apart_on_the_bed(puzzle_design: Design, kind: Kind) -> None:
    parameters = replace(puzzle_design.parameters, bed_width_mm=180.0, bed_depth_mm=120.0, kerf_mm=0.5)
    sheets = laser_sheets(flat_parts(puzzle_design, kind), parameters, kerf=True)
    assert (len(sheets) > 1) == (kind != "strips")
    bed = shapely.box(0.0, 0.0, 180.0, 120.0)
    for sheet in sheets:
        regions = [part.region for part in sheet.parts]
        for i, region in enumerate(regions):
            assert region.is_valid and bed.contains(region)
            assert all(region.distance(other) > 0.99 * LASER_SPACE_MM for other in regions[:i])
            assert region.contains(sheet.parts[i].engraved)
            assert shapely.difference(sheet.parts[i].scored, region.buffer(1e-6)).is_empty


def test_several_sheets_have_a_number_each(puzzle_design: Design, tmp_path: Path) -> None:
    small = replace(puzzle_design, parameters=replace(puzzle_design.parameters, bed_width_mm=130.0))
    write_flat(small, tmp_path / "cut.svg")
    files = sorted(tmp_path.iterdir())
    assert [path.name for path in files] == [f"cut-{k + 1}.svg" for k in range(len(files))]
    assert all(ElementTree.parse(path).getroot().attrib["width"] == "130mm" for path in files)
    assert sum(len(svg_rings(path)["cut"]) for path in files) == 3 * len(small.pieces)
    with pytest.raises(FabricationError, match=r"piece-1 does not fit on the bed of 80 × 80 mm"):
        tiny = replace(puzzle_design.parameters, bed_width_mm=80.0, bed_depth_mm=80.0)
        laser_sheets(flat_parts(puzzle_design, "outlines"), tiny)


@pytest.mark.parametrize("kind", KINDS)
def test_what_the_beam_leaves_is_nominal(puzzle_design: Design, kind: Kind) -> None:
    parts, parameters = flat_parts(puzzle_design, kind), replace(puzzle_design.parameters, kerf_mm=0.3)
    (nominal_sheet,), (path_sheet,) = (laser_sheets(parts, parameters, kerf=kerf) for kerf in (False, True))
    for nominal, path in zip(nominal_sheet.parts, path_sheet.parts, strict=True):
        left = path.region.buffer(-0.15, quad_segs=64)
        # The same place, and only concave corners keep a fillet of half the kerf.
        assert left.symmetric_difference(nominal.region).area < 1e-3 * nominal.region.area
        assert path.region.area > nominal.region.area
        for hole, narrow in zip(nominal.region.interiors, path.region.interiors, strict=True):
            assert area(np.array(narrow.coords)) < area(np.array(hole.coords))


def test_layers_have_the_knuckles_holes(puzzle_design: Design) -> None:
    parts = {part.name: part for part in flat_parts(puzzle_design, "layers")}
    pins = sum(pin.count for pin in puzzle_design.pins)
    for layer in ("bottom", "top"):
        holes = [ring for name, part in parts.items() if name.endswith(layer) for ring in part.region.interiors]
        assert len(holes) == pins


@pytest.mark.parametrize(("sheet", "copies", "height"), [(3.0, 1, 6.0), (1.5, 3, 9.0), (4.0, 1, 8.0), (9.0, 1, 18.0)])
def test_layers_are_stacked_from_the_material(puzzle_design: Design, sheet: float, copies: int, height: float) -> None:
    thick = replace(puzzle_design, parameters=replace(puzzle_design.parameters, sheet_mm=sheet))
    assert stack_mm(thick, "layers") == height
    assert {part.copies for part in flat_parts(thick, "layers")} == {copies}
    assert {part.copies for part in flat_parts(thick, "outlines")} == {max(1, round(9.0 / sheet))}


def test_marks_of_all_pieces_point_to_the_top_of_p(puzzle_design: Design) -> None:
    pose = puzzle_design.transform.pose(0.0)
    for piece, part in zip(puzzle_design.pieces, flat_parts(puzzle_design, "outlines"), strict=True):
        heading = float(pose.headings[piece.index])
        as_p = shapely.affinity.rotate(part.engraved, heading, origin=(0.0, 0.0), use_radians=True)
        arrow = max(shapely.get_parts(as_p), key=lambda polygon: polygon.centroid.y)
        points = shapely.get_coordinates(arrow.exterior)[:-1]
        assert len(points) == 3 and points[:, 1].argmax() == np.abs(points[:, 0] - points[:, 0].mean()).argmin()


def test_strips_join_what_pins_would(puzzle_design: Design) -> None:
    strips = flat_parts(puzzle_design, "strips")
    assert len(strips) == sum(pin.count for pin in puzzle_design.pins)
    assert {part.name for part in strips} == {
        f"strip-{piece.index + 1}" for piece in puzzle_design.pieces if piece.start.kind == "pin"
    }
    for part in strips:
        assert part.region.bounds[3] == stack_mm(puzzle_design, "outlines")
        assert part.scored.length == pytest.approx(part.region.bounds[3])  # the fold


def test_the_comb_s_space_is_ten_kerfs() -> None:
    """A stand-in for the laser cuts half a kerf to either side of every line; the space is what it took."""
    kerf = 0.2
    (coupon,) = laser_coupon(FabricationParameters())
    lines = shapely.union_all([shapely.LineString(ring.coords) for ring in coupon.region.interiors] + [coupon.through])
    slot = max((shapely.Polygon(ring) for ring in coupon.region.interiors), key=lambda ring: ring.area)
    x0, _, x1, _ = slot.bounds
    y = slot.centroid.y
    across = shapely.LineString([(x0 - 0.5 * kerf, y), (x1 + 0.5 * kerf, y)])
    lamellas = across.difference(lines.buffer(0.5 * kerf, cap_style="flat"))
    assert across.length - lamellas.length == pytest.approx(CUTS * kerf)
    assert len(shapely.get_parts(lamellas)) == CUTS - 1 and x1 - x0 == (CUTS - 1) * LAMELLA_MM


def test_telescopic_hinges_leave_outlines_and_a_note(puzzle_design: Design, tmp_path: Path) -> None:
    lifting = replace(
        puzzle_design,
        telescope=make_telescope(FabricationParameters(thickness_mm=15.0)),
        motion=replace(puzzle_design.motion, lifted=(1,)),
    )
    with pytest.raises(FabricationError, match="stacked"):
        write_flat(lifting, tmp_path / "cut.svg", "layers")
    written = write_flat_files(lifting, tmp_path, dxf=False)
    assert not any("layers" in path.name for path in written)
    (note,) = laser_notes(lifting)
    assert "no layers" in note and "before the pieces 2 " in note
    assert laser_notes(puzzle_design) == []


def test_files_are_deterministic(puzzle_design: Design, tmp_path: Path) -> None:
    for folder in ("first", "second"):
        (tmp_path / folder).mkdir()
    first, second = (
        write_flat_files(puzzle_design, tmp_path / "first"),
        write_flat_files(puzzle_design, tmp_path / "second"),
    )
    assert {path.name for path in first} == {
        "laser-coupon.svg",
        "laser-coupon.dxf",
        *(f"laser-{kind}{kerf}.{form}" for kind in KINDS for kerf in ("", "-kerf") for form in ("svg", "dxf")),
    }
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]


def test_other_formats_are_refused(puzzle_design: Design, tmp_path: Path) -> None:
    with pytest.raises(FlatFormatError, match=r"\.svg or \.dxf"):
        write_flat(puzzle_design, tmp_path / "cut.pdf")
    assert not list(tmp_path.iterdir())


def test_dxf_without_its_package(puzzle_design: Design, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise ModuleNotFoundError(name=name)

    monkeypatch.setattr(laser_sheet.importlib, "import_module", missing)
    with pytest.raises(MissingExtraError, match=r"riot-shapes\[print\]"):
        write_flat(puzzle_design, tmp_path / "cut.dxf")
    write_flat(puzzle_design, tmp_path / "cut.svg")
