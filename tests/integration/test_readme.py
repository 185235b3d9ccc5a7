"""The README is short, and what it shows works as it stands there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from fenced import ROOT, blocks

TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_readme_is_short_and_begins_with_picture_and_commands() -> None:
    lines = TEXT.splitlines()
    assert len(lines) <= 80
    first_screen = "\n".join(lines[:16])
    assert "docs/images/swing.svg" in first_screen and "make run" in first_screen and "make test" in first_screen


def test_the_picture_moves_and_is_small() -> None:
    picture = ROOT / "docs" / "images" / "swing.svg"
    assert picture.stat().st_size <= 60_000
    assert "<animateTransform" in picture.read_text(encoding="utf-8")


def test_library_example_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (example,) = blocks(ROOT / "README.md", "python")
    names: dict[str, object] = {}
    exec(compile(example.text, "README.md", "exec"), names)
    assert capsys.readouterr().out.splitlines()[-1].startswith("True 0.")
    assert {path.name for path in tmp_path.iterdir()} == {"house-kite.riot", "house-kite.svg"}


@pytest.mark.parametrize("name", ["README.md", "CONTRIBUTING.md"])
def test_files_that_a_page_leads_to_exist(name: str) -> None:
    text = (ROOT / name).read_text(encoding="utf-8")
    linked = re.findall(r"\]\(([^):]+)\)", text) + re.findall(r'src="([^":]+)"', text)
    named = re.findall(r"`((?:riot|pipeline|conf|tests|docs|benchmarks)/[\w/.]*)`", text)
    assert linked + named
    assert [path for path in linked + named if not (ROOT / path.partition("#")[0]).exists()] == []


@pytest.mark.parametrize("name", ["README.md", "CONTRIBUTING.md"])
def test_make_targets_that_a_page_names_exist(name: str) -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^(\w+):", makefile, flags=re.MULTILINE))
    named = set(re.findall(r"(?:^|`)make (\w+)", (ROOT / name).read_text(encoding="utf-8"), flags=re.MULTILINE))
    assert "test" in named and named <= targets
