"""Transforms of bent shapes: what they keep of the inputs, in files, numbers, commands, pictures and textures."""

from __future__ import annotations

import json
import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from PIL import Image, ImageDraw

from riot import Shape, Transform, load_stiff, to_frame
from riot.cli.main import main
from riot.construction import Pins, construct, keep
from riot.construction.tuning import LEAF_RADIUS, PIN_TOLERANCE
from riot.draw.figure import figure_scene
from riot.draw.panels import deformation_marks, input_marks
from riot.draw.scene import Label, Mark, Region
from riot.draw.strip import strip_scene
from riot.draw.texture.names import SIDES, Side
from riot.draw.texture.paint import picture_texture
from riot.draw.texture.warp import warp_side
from riot.errors import FormatError
from riot.geometry.bend import Bend
from riot.geometry.silhouette import read
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.parameters import BendParameters
from riot.transform.deformation import measure_deformation, overlap_ratio
from riot.transform.provenance import file_digest
from riot.transform.riot_file import MAX_POINTS, from_json, to_json
from riot.units import L_C

HOUSE = [(40, 210), (40, 110), (120, 30), (200, 110), (200, 210)]
FISH = [(20, 120), (90, 60), (170, 110), (230, 60), (215, 125), (230, 190), (170, 140), (90, 190)]
BEND = BendParameters(method="elastic")


def draw(path: Path, polygon: list[tuple[int, int]]) -> Path:
    image = Image.new("L", (256, 256))
    ImageDraw.Draw(image).polygon(polygon, fill=255)
    image.save(path)
    return path


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("pictures")
    return draw(folder / "house.png", HOUSE), draw(folder / "fish.png", FISH)


@pytest.fixture(scope="module")
def inputs(pictures: tuple[Path, Path]) -> tuple[Shape, Shape]:
    return read(pictures[0]), read(pictures[1])


@pytest.fixture(scope="module")
def transform(inputs: tuple[Shape, Shape]) -> Transform:
    return construct(*inputs, bend=BEND)


def bend_of(transform: Transform, side: Side) -> Bend:
    bend = transform.bend_p if side == "p" else transform.bend_q
    assert bend is not None
    return bend


def test_a_transform_keeps_its_inputs(transform: Transform, inputs: tuple[Shape, Shape]) -> None:
    assert (transform.input_p, transform.input_q) == inputs
    for side, shape, given in zip(SIDES, (transform.p, transform.q), inputs, strict=True):
        bend = bend_of(transform, side)
        assert bend.bent is shape and bend.rms_strain > 0.0
        assert np.abs(bend.field.at(given.points) - shape.points).max() < 1e-9
        assert np.abs(bend.field.back(shape.points) - given.points).max() < 1e-6
    assert transform.certificate().passed
    unbent = construct(*inputs)
    assert unbent.bend_p is None and unbent.bend_q is None and unbent.input_p is unbent.p
    assert min(transform.overlap_ratios) > min(unbent.overlap_ratios)


def test_a_file_keeps_input_bend_and_bent_shape_to_the_last_bit(transform: Transform, tmp_path: Path) -> None:
    path = tmp_path / "bent.riot"
    planned = transform.planned()
    planned.save(path)
    again = Transform.load(path)
    assert again == planned and hash(again) == hash(planned) and again != replace(planned, bend_q=None)
    assert to_json(again) == to_json(planned)
    assert pickle.loads(pickle.dumps(planned)) == planned
    document = json.loads(path.read_text(encoding="utf-8"))
    assert document["version"] == 3
    assert document["p"]["points"] == transform.p.points.tolist()
    assert document["bend_p"]["input"]["points"] == transform.input_p.points.tolist()
    for side in SIDES:
        inside = bend_of(transform, side).field.nodes[:20]
        assert np.array_equal(bend_of(again, side).field.at(inside), bend_of(transform, side).field.at(inside))


def test_one_side_alone_may_be_bent(transform: Transform) -> None:
    half = replace(transform, bend_p=None)
    assert from_json(to_json(half)) == half and half.input_p is half.p
    assert half.deformation().rms_strain_p == 0.0 < half.deformation().rms_strain_q


def test_without_a_bend_version_2_is_written() -> None:
    exact = exact_transform(exact_pair(4, 1))
    document = json.loads(to_json(exact))
    assert document["version"] == 2
    assert list(document) == [
        *("format", "version", "pieces", "angles", "conjugate_angles", "place_p", "place_q", "p", "q"),
        *("trunk_p", "trunk_q", "bound_p", "bound_q"),
    ]
    for version in (1, 2, 3):
        assert from_json(json.dumps({**document, "version": version})) == exact


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("input", None),
        ("input", {"name": "", "points": [[0, 0], [2, 0], [0, 1]], "feature": [], "to_source": [[1, 0, 0], [0, 1, 0]]}),
        ("vertices", [[0.0, 0.0]]),
        ("vertices", [[0.0, float("nan")]]),
        ("triangles", []),
        ("triangles", [[0, 1, 2.5]]),
        ("triangles", [[0, 1, 10**9]]),
        ("triangles", [[0, 1, -1]]),
        ("triangles", [[0, 0, 1]]),
        ("triangles", [[0, 1, 10**30]]),
        ("moved", [[0.0, 0.0]]),
        ("moved", None),
        ("coefficients", [float("inf")]),
        ("rms_strain", -0.1),
        ("max_strain", float("nan")),
        ("max_strain", "much"),
    ],
)
def test_a_damaged_bend_is_refused(transform: Transform, name: str, value: Any) -> None:
    document = json.loads(to_json(transform))
    document["bend_q"][name] = value
    with pytest.raises(FormatError, match="damaged"):
        from_json(json.dumps(document))


@pytest.mark.parametrize("name", ["vertices", "triangles", "moved", "coefficients"])
def test_a_bend_of_too_many_values_is_refused(transform: Transform, name: str) -> None:
    document = json.loads(to_json(transform))
    document["bend_p"][name] = [0] * (MAX_POINTS + 1)
    with pytest.raises(FormatError, match=f"limit of {MAX_POINTS}"):
        from_json(json.dumps(document))


def test_strain_and_both_overlaps_are_told_apart(transform: Transform) -> None:
    deformation = measure_deformation(transform)
    assert deformation.bent
    for side in SIDES:
        bend, outline = bend_of(transform, side), getattr(transform, f"outline_{side}")()
        assert getattr(deformation, f"iou_{side}") == overlap_ratio(outline, bend.bent.points)
        assert getattr(deformation, f"input_iou_{side}") == overlap_ratio(outline, bend.shape.points)
        assert getattr(deformation, f"rms_strain_{side}") == bend.rms_strain
        assert getattr(deformation, f"max_strain_{side}") == bend.max_strain
    columns = ["shape", "iou", "hausdorff", "mean_distance"]
    assert list(to_frame(deformation).columns) == [*columns, "input_iou", "rms_strain", "max_strain"]
    exact = measure_deformation(exact_transform(exact_pair(4, 1)))
    assert not exact.bent and exact.input_iou_p == exact.iou_p and exact.max_strain_q == 0.0
    assert list(to_frame(exact).columns) == columns


def test_make_bends_and_says_so(
    pictures: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make = ["make", *map(str, pictures), "-o", str(tmp_path), "--force", "--min-iou", "1"]
    file = tmp_path / "house--fish.riot"
    assert main([*make, "--bend"]) == 4
    printed = capsys.readouterr()
    made = Transform.load(file)
    assert "IoU with the bent input" in printed.out and "strain, root mean square" in printed.out
    assert f"strains of {bend_of(made, 'p').rms_strain:.1%}" in printed.err and "--bend" not in printed.err
    assert made.history is not None and made.history.steps[-1].parameters["weight"] == BendParameters.weight
    assert main(["show", str(file), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert [numbers["rms_strain"] for numbers in shown["inputs"]] == [
        bend_of(made, side).rms_strain for side in SIDES
    ]  # fmt: skip
    assert main([*make, "--bend", "100"]) == 4
    stiff = Transform.load(file)
    assert stiff.history is not None and stiff.history.steps[-1].parameters["weight"] == 100.0
    assert max(bend_of(stiff, side).rms_strain for side in SIDES) < max(
        bend_of(made, side).rms_strain for side in SIDES
    )
    capsys.readouterr()
    assert main([*make, "--bend", "off"]) == 4
    printed = capsys.readouterr()
    without = file.read_bytes()
    assert "--bend" in printed.err and "strain" not in printed.out
    assert main(make) == 4
    assert file.read_bytes() == without and Transform.load(file).bend_p is None
    capsys.readouterr()
    assert main([*make, "--bend", "much"]) == 2
    assert "neither a weight" in capsys.readouterr().err


def test_a_trunk_pair_of_a_rank_is_bent_too(pictures: tuple[Path, Path], tmp_path: Path) -> None:
    make = ["make", *map(str, pictures), "-o", str(tmp_path), "--min-iou", "0", "--rank", "1"]
    assert main([*make, "--bend", "1"]) == 0
    assert Transform.load(tmp_path / "house--fish.riot").deformation().bent


def regions(marks: list[Mark], pen: str) -> list[np.ndarray]:
    return [mark.rings[0] for mark in marks if isinstance(mark, Region) and mark.pen == pen]


@pytest.mark.parametrize("side", SIDES)
def test_figures_show_input_bent_input_and_result(transform: Transform, side: Side) -> None:
    bend = bend_of(transform, side)
    for marks in (input_marks(transform, side), deformation_marks(transform, side)):
        (grey,), (line,) = regions(marks, "silhouette"), regions(marks, "cut")
        assert overlap_ratio(grey, bend.shape.points) > 0.99 and overlap_ratio(line, bend.bent.points) > 0.99
    assert len(regions(list(strip_scene(transform, 3).marks), "silhouette")) == 2
    texts = [mark.text for mark in figure_scene(transform).marks if isinstance(mark, Label)]
    assert any(f"strain {bend_of(transform, 'p').rms_strain:.1%}" in text for text in texts)


@pytest.mark.parametrize("side", SIDES)
def test_textures_are_carried_back_to_the_input(transform: Transform, side: Side, tmp_path: Path) -> None:
    bend, warp = bend_of(transform, side), warp_side(transform, side)
    unbent = warp_side(replace(transform, bend_p=None, bend_q=None), side)
    assert np.abs(bend.field.at(warp.images) - unbent.images).max() < 1e-6
    shape = bend.shape
    image = Image.new("RGBA", (256, 256))
    outline = [(float(x), float(y)) for x, y in shape.source(shape.points)]
    ImageDraw.Draw(image).polygon(outline, fill=(200, 40, 40, 255))
    blue = shape.source(np.zeros((1, 2)))[0]
    ImageDraw.Draw(image).ellipse((*(blue - 12), *(blue + 12)), fill=(40, 40, 200, 255))
    image.save(tmp_path / "colours.png")
    texture = picture_texture(tmp_path / "colours.png", transform, side)
    # The middle of the assembled shape's disc is where the warp says that the input's middle goes.
    at = unbent.points[np.abs(warp.images).sum(axis=1).argmin()][None]
    assert texture.colours(0, at, 0.001)[0].tolist() == [40, 40, 200]


def test_pins_hold_on_the_bent_outline(transform: Transform, inputs: tuple[Shape, Shape]) -> None:
    points = bend_of(transform, "p").bent.points
    from_outline = shapely.distance(shapely.points(points), shapely.LinearRing(transform.outline_p()))
    from_hinges = np.hypot(*(points[:, None] - transform.trunk_p).T).min(axis=0)
    # Where cutting moves the outline most, away from the hinges, which it meets straight.
    worst = int(np.where(from_hinges > 4.0 * LEAF_RADIUS * L_C, from_outline, 0.0).argmax())
    assert from_outline[worst] > 10.0 * PIN_TOLERANCE
    pinned = construct(*inputs, bend=BEND, pins=Pins(p=(keep(inputs[0].points[worst]),)))
    kept = bend_of(pinned, "p").bent.points[worst]
    assert shapely.distance(shapely.points(kept), shapely.LinearRing(pinned.outline_p())) < PIN_TOLERANCE
    assert pinned.certificate().passed


def stiff_file(path: Path, **changes: Any) -> Path:
    body = [[40, 210], [40, 110], [200, 110], [200, 210]]
    document = {"format": "riot-stiff", "version": 1, "frame": "source", "p": [{"polygon": body, "factor": 50}]}
    path.write_text(json.dumps(document | changes))
    return path


def test_stiff_regions_bend_less(
    transform: Transform, inputs: tuple[Shape, Shape], pictures: tuple[Path, Path], tmp_path: Path
) -> None:
    file = stiff_file(tmp_path / "stiff.json")
    regions = load_stiff(file, *inputs)
    (body, factor), house = regions.p[0], inputs[0]
    assert factor == 50.0 and house.source(body).round(6).tolist() == [[40, 210], [40, 110], [200, 110], [200, 210]]
    stiff = construct(*inputs, bend=BEND, stiff=regions)
    inside = bend_of(transform, "p").field.nodes
    inside = inside[(house.source(inside)[:, 1] > 110) & (np.abs(house.source(inside)[:, 0] - 120) < 80)]
    rms = [np.sqrt((bend_of(made, "p").field.strain(inside) ** 2).mean()) for made in (stiff, transform)]
    assert rms[0] < 0.7 * rms[1]
    make = ["make", *map(str, pictures), "-o", str(tmp_path), "--min-iou", "0", "--stiff", str(file)]
    assert main([*make, "--bend"]) == 0
    made = Transform.load(tmp_path / "house--fish.riot")
    assert made.history is not None and made.history.steps[-1].parameters["stiff"] == file_digest(file)
    assert np.array_equal(bend_of(made, "p").field.moved, bend_of(stiff, "p").field.moved)
    assert main(make) == 2


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"format": "riot-pins"}, "riot-stiff"),
        ({"frame": "inches"}, "frame"),
        ({"p": 5}, "not a list"),
        ({"q": [{"polygon": [[0, 0], [1, 0]], "factor": 2}]}, "region 0 of q: give a list of at least 3"),
        ({"q": [{"polygon": [[0, 0], [1, 0], [1, 1]], "factor": 0}]}, "factor"),
        ({"q": [{"polygon": [[0, 0], [1, 0], [1, 1]], "factor": "much"}]}, "factor"),
        ({"q": [{"polygon": [[0, 0], [1, 0], [1, 1]]}]}, "region 0 of q is not"),
    ],
)
def test_other_files_of_stiff_regions_are_refused(
    changes: dict[str, Any], words: str, inputs: tuple[Shape, Shape], tmp_path: Path
) -> None:
    with pytest.raises(FormatError, match=words):
        load_stiff(stiff_file(tmp_path / "stiff.json", **changes), *inputs)
