"""The stage that paints pieces: skins where the inputs have colours, plain pieces else."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely
from colour_pictures import picture, placed
from PIL import Image

from pipeline.datasets.colours import may_be_coloured
from pipeline.stages.paint import run, unpack_images
from pipeline.store.artifact import Artifact, decode, encode
from pipeline.tables.messages import sentences
from pipeline.tables.textures import FOLDER, read_textures
from riot import Transform
from riot.draw.piece_image import NO_IMAGES
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.transform.riot_file import to_json


@pytest.fixture(scope="module")
def transform() -> Transform:
    return placed(exact_transform(exact_pair(4, 3)).planned())


@pytest.fixture(scope="module")
def planned(transform: Transform) -> Artifact:
    return Artifact({}, {"riot": to_json(transform)})


def test_pieces_get_the_colours_of_their_pictures(tmp_path: Path, transform: Transform, planned: Artifact) -> None:
    spec = picture(tmp_path / "p.png", transform.p), picture(tmp_path / "q.png", transform.q)
    found = run([planned], [], spec)
    assert found.document == {"sides": ["p", "q"], "refused": []}
    skins = unpack_images(decode(encode(found)).arrays, len(transform))
    for t, side in ((0.0, "p"), (1.0, "q")):
        shape = transform.p if side == "p" else transform.q
        for i, skin in enumerate(skins[side]):
            x0, y0, x1, y1 = skin.box
            rows, columns = skin.pixels.shape[:2]
            middle = np.array(shapely.maximum_inscribed_circle(shapely.Polygon(transform.pieces[i].polygon)).coords[:1])
            column, row = (middle[0] - [x0, y1]) / [x1 - x0, y0 - y1] * [columns, rows]
            at = shape.source(transform.pose(t).place(i, middle))[0]
            assert skin.pixels[int(row), int(column), :2].astype(float) == pytest.approx(at, abs=2.0)
    assert encode(run([planned], [], spec)) == encode(found)


def test_silhouettes_leave_the_pieces_plain(tmp_path: Path, transform: Transform, planned: Artifact) -> None:
    black = picture(tmp_path / "black.png", transform.p, (0, 0, 0))
    found = run([planned], [], (black, None))
    assert not found.arrays and found.document == {"sides": [], "refused": []}
    one = run([planned], [], (None, picture(tmp_path / "q.png", transform.q)))
    assert one.document == {"sides": ["q"], "refused": []}


def test_a_picture_that_can_be_no_texture_is_told_and_stops_no_other_side(
    tmp_path: Path, transform: Transform, planned: Artifact
) -> None:
    opaque = picture(tmp_path / "opaque.png", transform.q, opaque=True)
    found = run([planned], [], (picture(tmp_path / "p.png", transform.p), opaque))
    assert found.document["sides"] == ["p"] and "errors" not in found.document
    (refused,) = found.document["refused"]
    assert (refused["side"], refused["reason"]) == ("q", "no-alpha")
    # Where the pictures lie is no part of what is kept.
    assert refused["message"].startswith("opaque: the picture has no transparent part")
    assert str(tmp_path) not in refused["message"]
    turned = picture(tmp_path / "other.png", replace(transform.p, to_source=transform.p.to_source[:, [1, 0, 2]]))
    (other,) = run([planned], [], (turned, None)).document["refused"]
    assert other["reason"] == "other-shape"


def test_a_run_tells_how_many_pictures_can_be_no_texture() -> None:
    assert sentences({"selected": 1, "refused_textures": 0}, "global") == []
    (one,) = sentences({"selected": 1, "refused_textures": 1}, "global")
    (two,) = sentences({"selected": 1, "refused_textures": 2}, "global")
    assert one.startswith("1 picture that") and two.startswith("2 pictures that")


def test_a_picture_that_changed_is_refused(tmp_path: Path, transform: Transform, planned: Artifact) -> None:
    item = picture(tmp_path / "p.png", transform.p)
    picture(tmp_path / "p.png", transform.p, (1, 2, 3))
    with pytest.raises(RuntimeError, match="the file changed"):
        run([planned], [], (item, None))


def test_headers_tell_what_may_have_colours(tmp_path: Path, transform: Transform) -> None:
    item = picture(tmp_path / "p.png", transform.p)
    with Image.open(item.source) as image:
        image.convert("RGB").save(tmp_path / "photo.jpg")
        image.getchannel("A").save(tmp_path / "mask.png")
    (tmp_path / "words.png").write_text("no picture")
    assert may_be_coloured(item)
    for name in ("photo.jpg", "mask.png", "words.png", "gone.png"):
        assert not may_be_coloured(replace(item, source=str(tmp_path / name)))
    assert not may_be_coloured(replace(item, source="sample:card-heart"))


def test_skins_are_read_from_a_runs_folder_if_they_are_whole(
    tmp_path: Path, transform: Transform, planned: Artifact
) -> None:
    found = run([planned], [], (picture(tmp_path / "p.png", transform.p), None))
    (tmp_path / FOLDER).mkdir()
    target = tmp_path / FOLDER / "0001_a_b.skins"
    assert read_textures(tmp_path, "transforms/0001_a_b.riot", 4) is NO_IMAGES
    target.write_bytes(encode(Artifact(found.arrays)))
    skins = read_textures(tmp_path, "transforms/0001_a_b.riot", 4)
    assert set(skins) == {"p"} and len(skins["p"]) == 4
    target.write_bytes(target.read_bytes()[:-100])
    assert read_textures(tmp_path, "transforms/0001_a_b.riot", 4) is NO_IMAGES
