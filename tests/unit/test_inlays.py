"""Inlays: bodies of other filaments that part a piece exactly, flush with its faces; plates and files of them."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import shapely
import trimesh
from colour_pictures import picture, placed
from PIL import Image

from riot.cli.main import main
from riot.draw.texture.paint import Texture, pattern_texture
from riot.fabricate import Design, FabricationParameters, design, write_puzzle
from riot.fabricate.certificate import certify
from riot.fabricate.export.drawing import (
    INSET_MM,
    LEAST_AREA_MM2,
    LINE_MM,
    OVERCUT_MM,
    drawing_of,
    outline_drawing,
)
from riot.fabricate.export.inlay import Body, InlayTexture, bodies_of
from riot.fabricate.export.painting import painted_drawing
from riot.fabricate.export.plate_file import CONFIG
from riot.fabricate.export.poses import frames_of
from riot.fabricate.solid import Part, make_parts
from riot.groundtruth.pairs import dudeney, exact_pair, exact_transform
from riot.transform.riot_file import save
from riot.types import FloatArray

SPACE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
DEPTH = 0.6


class Halves:
    """White beyond a fifth of the shape's width, red before it."""

    def colours(self, piece: int, xy: FloatArray, step: float) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
        del piece, step
        colours = np.array([[200, 20, 20], [250, 250, 250]], dtype=np.uint8)
        return colours[(xy[:, 0] > 0.0).astype(np.int64)]


def puzzle_of(number: int) -> Design:
    transform = exact_transform(dudeney() if number == 0 else exact_pair(4, number))
    return design(transform, FabricationParameters(size_mm=150.0, inlay_mm=DEPTH))


@pytest.fixture(scope="module", params=[0, 3])
def puzzle(request: pytest.FixtureRequest) -> Design:
    return puzzle_of(request.param)


@pytest.fixture(scope="module", params=["outlines", "bands"])
def parted(request: pytest.FixtureRequest, puzzle: Design) -> list[tuple[Part, tuple[Body, ...]]]:
    textures: dict[str, Texture] = {}
    if request.param == "bands":
        textures = {side: pattern_texture("bands", puzzle.transform, side) for side in ("p", "q")}
    drawing = drawing_of(puzzle, textures)  # type: ignore[arg-type]
    assert drawing is not None
    return [(part, bodies_of(puzzle, part, drawing)) for part in make_parts(puzzle) if part.kind == "piece"]


def test_bodies_are_together_the_piece_and_share_nothing(parted: list[tuple[Part, tuple[Body, ...]]]) -> None:
    for part, bodies in parted:
        assert len(bodies) > 1
        assert sum(body.volume for body in bodies) == pytest.approx(part.volume, rel=1e-9)
        # As large together as one by one: no two of them overlap.
        union = bodies[0].solid
        for body in bodies[1:]:
            union += body.solid
        assert union.volume() == pytest.approx(part.volume, rel=1e-9)
        assert (union - part.printed).volume() < 1e-6
        assert len(bodies[0].solid.decompose()) == 1
        assert all(body.solid.status().name == "NoError" for body in bodies)


def test_inlays_are_flush_and_as_deep_as_asked_for(puzzle: Design, parted: list[tuple[Part, tuple[Body, ...]]]) -> None:
    height = puzzle.parameters.height
    for part, bodies in parted:
        for body in bodies[1:]:
            low, high = body.solid.bounding_box()[2], body.solid.bounding_box()[5]
            on_bed = body.name.startswith("front") == part.upside_down
            wanted = (0.0, DEPTH) if on_bed else (height - DEPTH, height)
            assert (low, high) == pytest.approx(wanted, abs=1e-9)
            for component in body.solid.decompose():
                assert component.volume() > 0.9 * LEAST_AREA_MM2 * DEPTH


def test_a_line_goes_along_the_outline_of_either_shape(puzzle: Design) -> None:
    drawing = outline_drawing(puzzle)
    for side, time in (("p", 0.0), ("q", 1.0)):
        outline = puzzle.transform.outline_p() if side == "p" else puzzle.transform.outline_q()
        whole = shapely.Polygon(puzzle.scale * outline)
        frames = frames_of(puzzle, puzzle.transform.pose(time))
        drawn = [frames[i].region(region) for i, (region,) in enumerate(drawing.regions[side])]  # type: ignore[index]
        line = shapely.union_all(drawn)
        assert whole.buffer(-INSET_MM + 3 * OVERCUT_MM).contains(line)
        assert whole.buffer(-INSET_MM - LINE_MM - 3 * OVERCUT_MM).intersection(line).area < 1e-6
        # Most of the way: knuckles' holes and the gaps between pieces interrupt it.
        assert line.area > 0.7 * LINE_MM * whole.buffer(-INSET_MM - 0.5 * LINE_MM).length


def test_a_painted_side_has_the_colours_of_its_texture(puzzle: Design) -> None:
    drawing = painted_drawing(puzzle, {"p": Halves()})
    areas = [shapely.Polygon(piece.outline) for piece in puzzle.pieces]
    frames = frames_of(puzzle, puzzle.transform.pose(0.0))
    assert {drawing.base, *drawing.colours} == {"#fafafa", "#c81414"}
    half = shapely.box(-1e3, -1e3, 0.0, 1e3) if drawing.colours == ("#c81414",) else shapely.box(0.0, -1e3, 1e3, 1e3)
    wanted = [frame.region(area).intersection(half).area for frame, area in zip(frames, areas, strict=True)]
    inlaid = [region.area for (region,) in drawing.regions["p"]]
    assert all(region.is_empty for (region,) in drawing.regions["q"])
    # Knuckles take a part of it, or add to it.
    assert sum(inlaid) == pytest.approx(sum(wanted), rel=0.2)
    texture = InlayTexture(puzzle, drawing, "p")
    for i, frame in enumerate(frames):
        points = frame.paper(shapely.get_coordinates([shapely.Point(c) for c in [areas[i].representative_point()]]))
        (seen,) = texture.colours(i, points / puzzle.scale, 0.01)
        (true,) = Halves().colours(i, points / puzzle.scale, 0.01)
        assert abs(points[0, 0]) < 1.0 or seen.tolist() == true.tolist()


def test_plates_give_every_body_its_filament(puzzle: Design, tmp_path: Path) -> None:
    parts = make_parts(puzzle)
    write_puzzle(puzzle, parts, certify(puzzle, parts), tmp_path / "puzzle")
    document = json.loads((tmp_path / "puzzle" / "parts.json").read_text())
    with zipfile.ZipFile(tmp_path / "puzzle" / "plate-1.3mf") as archive:
        model = ElementTree.fromstring(archive.read("3D/3dmodel.model"))
        config = ElementTree.fromstring(archive.read(CONFIG))
    materials = [base.attrib["name"] for base in model.iter(f"{SPACE}base")]
    objects = {entry.attrib["name"]: entry for entry in model.iter(f"{SPACE}object")}
    for entry in document["parts"]:
        volume = sum(body["volume_mm3"] for body in entry["bodies"])
        if entry["kind"] != "piece":
            assert entry["bodies"] == []
            continue
        assert volume == pytest.approx(entry["volume_mm3"], abs=1e-4)
        for body in entry["bodies"]:
            mesh = trimesh.load_mesh(tmp_path / "puzzle" / body["file"])
            assert mesh.is_watertight and mesh.volume == pytest.approx(body["volume_mm3"], rel=1e-5)
        whole = objects[entry["name"]]
        triangles = list(whole.iter(f"{SPACE}triangle"))
        (told,) = [part for part in config if part.attrib["id"] == whole.attrib["id"]]
        volumes = list(told.iter("volume"))
        assert [int(part.attrib["firstid"]) for part in volumes[1:]] == [
            int(part.attrib["lastid"]) + 1 for part in volumes[:-1]
        ]
        assert int(volumes[-1].attrib["lastid"]) == len(triangles) - 1
        for part, body in zip(volumes, entry["bodies"], strict=True):
            values = {data.attrib["key"]: data.attrib["value"] for data in part}
            assert values == {"name": body["name"], "extruder": str(body["filament"])}
            for triangle in triangles[int(part.attrib["firstid"]) : int(part.attrib["lastid"]) + 1]:
                material = triangle.attrib.get("p1", whole.attrib["pindex"])
                assert materials[int(material)] == f"filament {body['filament']}"


def test_print_sinks_a_pattern_and_counts_layers(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    save(exact_transform(dudeney()), tmp_path / "d.riot")
    command = ["print", str(tmp_path / "d.riot"), "-o", str(tmp_path / "out"), "--inlay", "0.5", "--pattern", "stripes"]
    assert main(command) == 0
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"piece-1.stl", "piece-1-base.stl", "plate-1.3mf"} <= names and "texture-front.pdf" not in names
    bodies = json.loads((tmp_path / "out" / "parts.json").read_text())["parts"][0]["bodies"]
    assert {body["filament"] for body in bodies} == {1, 2, 3, 4}
    heights = [np.ptp(trimesh.load_mesh(tmp_path / "out" / body["file"]).bounds[:, 2]) for body in bodies[1:]]
    assert heights == pytest.approx([0.4] * len(heights), abs=1e-6)
    # A puzzle without inlays that replaces it leaves none of their files.
    assert main([*command[:4], "--force"]) == 0
    assert not list((tmp_path / "out").glob("*-base.stl"))
    with zipfile.ZipFile(tmp_path / "out" / "plate-1.3mf") as archive:
        assert CONFIG not in archive.namelist()


def test_print_says_which_side_stays_plain(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    transform = placed(exact_transform(dudeney()))
    save(transform, tmp_path / "d.riot")
    picture(tmp_path / "two.png", transform.p, (200, 30, 40))
    two = np.array(Image.open(tmp_path / "two.png"))
    two[:, :80, :3] = 20, 40, 200  # blue on its left
    Image.fromarray(two).save(tmp_path / "two.png")
    command = ["print", str(tmp_path / "d.riot"), "-o", str(tmp_path / "out"), "--inlay", "0.6"]
    assert main([*command, "--texture-p", str(tmp_path / "two.png")]) == 0
    assert "the back gets no inlay: --texture-q or --pattern paints it" in capsys.readouterr().err
    assert list((tmp_path / "out").glob("*-front-*.stl")) and not list((tmp_path / "out").glob("*-back-*.stl"))
