"""The contact sheet: every outline on its picture, upright, the doubtful ones first; names stand as they are."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from arrow import ARROW, OUTLINE, SIDE
from PIL import Image

from pipeline.cli.main import main

HALVES = np.zeros((SIDE, SIDE), dtype=bool)
HALVES[40:100, 40:100] = HALVES[100:160, 100:160] = True


def corners(page: str, name: str) -> np.ndarray:
    figure = page.index(f'aria-label="outline of {name}"')
    path = re.search(r' d="M([^Z]*)Z"', page[figure:])
    assert path is not None
    return np.array([[float(value) for value in point.split(",")] for point in path[1].split()])


def test_a_sheet_shows_every_outline_on_its_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "pictures"
    folder.mkdir()
    exif = Image.Exif()
    exif[0x0112] = 6
    turned = Image.fromarray(np.where(ARROW, 0, 255).astype(np.uint8)).transpose(Image.Transpose.ROTATE_90)
    turned.save(folder / "[bold]arrow[v2].jpg", exif=exif, quality=95)
    Image.fromarray(HALVES).save(folder / "halves.png")
    (folder / "bad.png").write_text("no picture")
    (folder / "square.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0H9V9H0z"/></svg>')
    target = tmp_path / "sheets" / "page.html"
    assert main(["check", str(folder), "-o", str(target), "--json"]) == 4
    facts = json.loads(capsys.readouterr().out)
    assert [shape["name"] for shape in facts["shapes"]] == ["[bold]arrow[v2]", "halves", "square"]
    assert [error["name"] for error in facts["refused"]] == ["bad"]
    page = target.read_text(encoding="utf-8")
    outline = corners(page, "[bold]arrow[v2]")
    for corner in OUTLINE:
        assert np.hypot(*(outline - corner).T).min() < 4.0, corner
    assert page.index("outline of halves") < page.index("outline of [bold]")
    assert "only 50% of the object is kept" in page and "the content is none of" in page
    assert main(["check", str(folder), "-o", str(target)]) == 2  # it is there already
    assert "--force" in capsys.readouterr().err


def test_a_clear_folder_is_done(tmp_path: Path) -> None:
    Image.fromarray(ARROW).save(tmp_path / "arrow.png")
    assert main(["check", str(tmp_path), "-o", str(tmp_path / "check.html"), "-q"]) == 0
