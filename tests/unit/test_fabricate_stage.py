"""The stage that makes puzzles: files by name, a row of numbers, a reason where there is no puzzle."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from colour_pictures import picture, placed
from plans import planned

from pipeline.config.build import make_config
from pipeline.config.schema import FabricateConfig
from pipeline.datasets.collection import Collection
from pipeline.datasets.item import Item
from pipeline.errors import ConfigError
from pipeline.plan.work_item import WorkItem
from pipeline.report.environment import render
from pipeline.report.rows import PuzzleRow, typed_row
from pipeline.stages.all import BY_NAME
from pipeline.stages.fabricate import run
from pipeline.store.artifact import Artifact, decode, encode
from pipeline.tables.messages import sentences
from pipeline.tables.puzzles import SHARED
from pipeline.tables.schemas import SCHEMAS
from riot.fabricate import FabricationParameters
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.motion import with_motion
from riot.transform.riot_file import from_json, to_json

PLANNED = Artifact({}, {"riot": to_json(with_motion(exact_transform(exact_pair(3, 1))))})
SAMPLE = {"dataset": {"name": "sample", "kind": "sample"}}
CROWDED = Artifact({}, {"riot": to_json(with_motion(exact_transform(exact_pair(6, 2))))})
OWN = set(SCHEMAS["fabrications"].names) - {*SHARED, "folder"}
"""What a puzzle's artifact says of it."""
TINY = FabricationParameters(size_mm=30.0, pin_mm=8.0)
"""Knuckles too large for the six pieces of the crowded one."""


@pytest.fixture(scope="module")
def made() -> Artifact:
    return run([PLANNED], [FabricationParameters(), False, False], None)


def test_files_are_the_solids_that_the_row_counts(made: Artifact) -> None:
    row = made.document
    assert (row["status"], row["reason"], row["changes"]) == ("certified", "", [])
    listed = json.loads(made.arrays["parts.json"].tobytes())
    assert row["parts"] == sum(part["count"] for part in listed["parts"])
    assert row["pin_hinges"] == sum(pin["count"] for pin in listed["pins"]) and row["telescopic_hinges"] == 0
    meshes = [
        trimesh.load_mesh(io.BytesIO(data.tobytes()), file_type="stl")
        for name, data in made.arrays.items()
        if name.startswith("piece") and name.endswith(".stl")
    ]
    assert len(meshes) == 3 and all(mesh.is_watertight for mesh in meshes)
    assert sum(mesh.volume for mesh in meshes) == pytest.approx(row["volume"], rel=1e-6)
    assert 0.0 < row["proven_gap"] <= row["least_gap"] and row["overlap"] == 0.0 and row["components"] == 1


def test_the_same_transform_gives_the_same_bytes(made: Artifact) -> None:
    again = run([PLANNED], [FabricationParameters(), False, False], None)
    assert encode(again) == encode(made)
    assert decode(encode(made)).arrays["plate-1.3mf"].tobytes() == made.arrays["plate-1.3mf"].tobytes()


def test_paperwork_comes_when_asked_for(made: Artifact) -> None:
    with_paper = run([PLANNED], [FabricationParameters(), False, True], None).arrays
    assert {"assembly.pdf", "laser-strips.svg", "puzzle-p.png"} <= with_paper.keys() - made.arrays.keys()
    assert all(np.array_equal(with_paper[name], data) for name, data in made.arrays.items())


def test_paperwork_has_texture_sheets_of_colour_pictures(tmp_path: Path) -> None:
    transform = placed(from_json(PLANNED.document["riot"]))
    planned = Artifact({}, {"riot": to_json(transform)})
    coloured = picture(tmp_path / "p.png", transform.p)
    sheets = {"texture-front.pdf", "texture-back.pdf"}
    both = run([planned], [FabricationParameters(), False, True], (coloured, picture(tmp_path / "q.png", transform.q)))
    assert both.document["status"] == "certified" and sheets <= both.arrays.keys()
    opaque = picture(tmp_path / "opaque.png", transform.q, opaque=True)
    one = run([planned], [FabricationParameters(), False, True], (coloured, opaque))
    assert one.document["status"] == "certified" and sheets & one.arrays.keys() == {"texture-front.pdf"}
    assert np.array_equal(one.arrays["texture-front.pdf"], both.arrays["texture-front.pdf"])
    told = set(one.document["warnings"]) - set(both.document["warnings"])
    assert len(told) == 1
    assert told.pop().startswith("no texture-back.pdf: opaque: the picture has no transparent part")
    bare = run([planned], [FabricationParameters(), False, False], (coloured, opaque))
    assert not sheets & bare.arrays.keys() and bare.document["warnings"] == both.document["warnings"]


def test_pictures_are_part_of_a_puzzles_key_where_their_sheets_are_made(tmp_path: Path) -> None:
    transform = placed(from_json(PLANNED.document["riot"]))
    items = (picture(tmp_path / "p.png", transform.p), picture(tmp_path / "q.png", transform.q, opaque=True))

    def puzzle(paper: bool, items: tuple[Item, Item]) -> WorkItem:
        folder = {"dataset": {"name": "folder", "kind": "folder", "root": str(tmp_path)}}
        config = make_config({**folder, "fabricate": {"top": 1, "paper": paper}})
        certified = Artifact({}, {"status": "certified", "iou_p": 1.0, "iou_q": 1.0})
        progress = planned(config, "ingest", Collection("folder", items), lambda item: certified)
        (ingest,) = progress.work["ingest"]
        for stage in ("construct", "motion"):  # as if the two pictures were a pair
            item = progress.recipes[stage].after(replace(ingest, members=(0, 1)))
            progress = progress.with_work(stage, [item], progress.done | {item.reference})
        (puzzle,) = BY_NAME["fabricate"].items(progress)
        return puzzle

    changed = (items[0], replace(items[1], digest="0" * 64))
    assert puzzle(False, items).spec is None and puzzle(True, items).spec == items
    assert len({puzzle(False, items).key, puzzle(True, items).key, puzzle(True, changed).key}) == 3


def test_what_cannot_be_made_is_a_row_with_the_reason_and_no_error() -> None:
    found = run([CROWDED], [TINY, False, False], None)
    assert not found.arrays and "errors" not in found.document
    assert found.document["status"] == "refused" and found.document["reason"] == "hinges-meet"
    assert "enlarge size_mm (30)" in found.document["message"] and found.document["size"] == 30.0
    mended = run([CROWDED], [TINY, True, False], None)
    assert mended.document["status"] == "certified" and mended.arrays
    assert "pin_mm: 1.75 instead of 8" in mended.document["changes"]


def test_a_part_larger_than_the_bed_is_refused() -> None:
    bed = FabricationParameters(size_mm=300.0, bed_width_mm=80.0, bed_depth_mm=80.0)
    found = run([PLANNED], [bed, False, False], None)
    assert (found.document["status"], found.document["reason"]) == ("refused", "bed")
    assert not found.arrays


def test_columns_are_in_the_table_with_meaning_and_unit(made: Artifact) -> None:
    assert set(made.document) == OWN
    units = {
        name: SCHEMAS["fabrications"].field(name).metadata[b"unit"]
        for name in ("size", "least_wall", "volume", "overlap")
    }
    assert units == {"size": b"mm", "least_wall": b"mm", "volume": b"mm3", "overlap": b"mm3"}


def test_how_many_are_made_is_no_part_of_their_key() -> None:
    def key(**values: Any) -> str:
        return BY_NAME["fabricate"].recipe(make_config({**SAMPLE, "fabricate": values})).parts(["x"]).key()

    assert key(top=3) == key(top=5) == key()
    assert len({key(), key(size_mm=90.0), key(fix=True), key(paper=True)}) == 4


def test_parameters_are_the_librarys_and_are_checked() -> None:
    found = make_config({**SAMPLE, "fabricate": {"top": 4, "pin_mm": 1.75}}).fabricate
    assert found.top == 4 and found.sizes == FabricationParameters(pin_mm=1.75)
    assert FabricateConfig().sizes == FabricationParameters()
    for values, words in (
        ({"top": -1}, "fabricate.top: must be 0 or more"),
        ({"size_mm": 5.0}, "fabricate.size_mm: must be 30 to 1000 mm, got 5.0"),
        ({"glue_mm": 1.0}, "fabricate.glue_mm: no such parameter"),
    ):
        with pytest.raises(ConfigError, match=words):
            make_config({**SAMPLE, "fabricate": values})


def test_the_report_tells_what_became_of_every_puzzle(made: Artifact) -> None:
    refused = run([CROWDED], [TINY, False, False], None)
    pair = {"i": 0, "j": 1, "name_i": "<a>", "name_j": "b", "class_i": "", "class_j": ""}
    none = dict.fromkeys(OWN)
    rows = [
        {**none, **pair, "rank": 1, "folder": "print/0001_a_b", **made.document},
        {**none, **pair, "rank": 2, "folder": "", **refused.document},
    ]
    puzzles = [typed_row(PuzzleRow, row) for row in rows]
    text = render("puzzles.html", puzzles=puzzles, links={1: "#t1"})
    assert 'href="print/0001_a_b/"' in text and 'href="#t1"' in text and 'href="#t2"' not in text
    assert "&lt;a&gt;" in text and "<a>" not in text and "enlarge size_mm" in text
    assert text.count('href="print/') == 1


def test_a_run_says_how_many_puzzles_it_made() -> None:
    counts = {"selected": 4, "puzzles": 2}
    assert sentences({**counts, "no_puzzles": 0}, "global") == ["2 of 2 puzzles certified, in print/."]
    (said,) = sentences({**counts, "no_puzzles": 1}, "global")
    assert said.startswith("2 of 3 puzzles certified") and "why the others cannot be made" in said
