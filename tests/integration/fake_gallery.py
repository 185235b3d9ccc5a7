"""An invented run with its gallery, and a gallery of a thousand transforms, for tests of pages."""

import math
import shutil
from dataclasses import replace

import fake_run
import numpy as np
import pytest

from pipeline.report import gallery, write_report
from pipeline.report.gallery import INDEX, index
from pipeline.report.run import read_run
from pipeline.study.contents import write_contents
from pipeline.tables.record import GALLERY
from riot.transform.history import History, HistoryStep

MANY = 1000


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("outputs") / "fake"
    folder.mkdir()
    transforms = fake_run.transforms()
    history = History(
        "riot make", ("ab" * 32, "cd" * 32), (HistoryStep("trunks", {"spacing": 15.0}, "ef" * 32),), {"numpy": "2"}
    )
    transforms[0] = replace(transforms[0], history=history)
    names = {"name_i": "a", "name_j": "b", "class_i": "", "class_j": ""}
    puzzle = names | {
        "rank": 1,
        "status": "certified",
        "folder": "print/0001",
        "size": 120.0,
        "parts": 9,
        "message": "",
    }
    refused = names | {"rank": 2, "status": "refused", "folder": "", "message": "the neck of piece 2 is <thin>"}
    fake_run.write_fake_run(folder, exact=transforms, fabrications=[puzzle, refused])
    (folder / "print" / "0001").mkdir(parents=True)
    (folder / "print" / "0001" / "plate.3mf").write_bytes(b"solid")
    write_contents(folder)
    write_report(folder)
    return folder


@pytest.fixture(scope="module")
def rows(run):
    """A thousand rows of transforms that are not there."""
    rng, known = np.random.default_rng(5), read_run(run).constructed
    return [
        replace(
            known[k % len(known)],
            rank=k + 1,
            name_p=f"<shape> {k}",
            class_p=f"class & {k % 7}",
            class_q=f"kind {k % 3}",
            file=f"transforms/{k + 1:04d}.riot",
            n=3 + k % 4,
            iou=1.0 - 0.0002 * k,
            crs=float(rng.random()),
            qcrs=math.nan if k % 100 == 0 else float(rng.random()),
            swings_flat=k % 5 != 0,
        )
        for k in range(MANY)
    ]


@pytest.fixture(scope="module")
def many(rows, run, tmp_path_factory):
    """The gallery of those rows, as files."""
    folder = tmp_path_factory.mktemp("many")
    (folder / INDEX).write_text(index("many", rows, frozenset({2, 9})), encoding="utf-8")
    for name, text in gallery.files().items():
        (folder / name).write_text(text, encoding="utf-8")
    pictures = sorted((run / GALLERY).glob("*.svg"))
    for k, row in enumerate(rows):
        shutil.copy(pictures[k % len(pictures)], folder / row.thumb)
    single = (run / GALLERY / read_run(run).constructed[0].page).read_text(encoding="utf-8")
    (folder / rows[0].page).write_text(single, encoding="utf-8")
    return folder
