"""``--explain`` under every kind of edit: every stage that has to run again names the edit, and no other cause."""

from __future__ import annotations

import io
import re
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from edited_project import ALL, EDITS, PICTURES, Edit, Project, finished_once
from rich.console import Console

from pipeline.explain.causes import NOT_DONE, Causes
from pipeline.explain.show import show_explanation
from pipeline.store.store import folder_name

CAUSE = re.compile(
    r"(?:code|versions)\.[\w.:-]+|parameters\.\S+ \S+ → \S+|picture [^;]+|inputs:.*|new:.*|pictures in.*"
)


__all__ = ["finished_once"]


@pytest.fixture
def finished(finished_once: Project, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Project:
    return Project.copy(finished_once, tmp_path, monkeypatch)


def causes(project: Project) -> dict[str, Counter[str]]:
    """Of every stage of which it is known what it has to do."""
    forecast = project.look()
    asked = Causes(project.store, forecast.pictures)
    return {row.stage.name: asked.count(row.missing) for row in forecast.stages if row.items is not None}


@pytest.mark.parametrize("edit", EDITS, ids=lambda edit: edit.name)
def test_every_stage_names_the_edit_and_nothing_else(finished: Project, edit: Edit) -> None:
    edited = edit.do(finished)
    texts_by_stage = causes(edited)
    assert {name for name, texts in texts_by_stage.items() if texts} == texts_by_stage.keys() & edit.again
    # Of what comes after something that is done again, some is not known yet.
    assert texts_by_stage.keys() & edit.again if edit.again else texts_by_stage.keys() == ALL | {"margin"}
    for texts in texts_by_stage.values():
        for text in texts:
            assert CAUSE.findall(text) == [edit.cause], text


def test_what_an_earlier_stage_hands_on_is_told_as_its(finished: Project) -> None:
    (edit,) = (edit for edit in EDITS if "shape.spacing" in edit.name)
    texts_by_stage = causes(edit.do(finished))
    assert set(texts_by_stage["ingest"]) == {edit.cause}
    for stage in ("reversibility", "trunks", "qcrs", "select"):
        assert set(texts_by_stage[stage]) == {f"after ingest: {edit.cause}"}


@pytest.mark.parametrize("stage", ["qcrs", "trunks_full", "crs", "construct"])
def test_what_a_stopped_run_left_undone_is_no_edit(finished: Project, stage: str) -> None:
    store = finished.store
    undone = [item for item in finished.plan() if item.stage == stage][1:]
    gone = {item.reference for item in undone}
    for item in finished.plan():  # chained: sources come before what reads them
        if item.reference in gone or not gone.isdisjoint(item.sources):
            gone.add(item.reference)
            store.files.remove(folder_name(*item.reference))
    texts_by_stage = {name: texts for name, texts in causes(finished).items() if texts}
    assert texts_by_stage.pop(stage) == {NOT_DONE: len(undone)}
    assert all(text.endswith(f"after {stage}: {NOT_DONE}") for texts in texts_by_stage.values() for text in texts)


def test_two_edits_are_both_named(finished: Project) -> None:
    finished.picture("kind2-2.png", 77).edit("pipeline.stages.qcrs", "def run(", "@staticmethod\ndef run(")
    texts_by_stage = causes(finished)
    with_both = {text for text in texts_by_stage["qcrs"] if "picture replaced: kind2-2.png" in text}
    assert with_both and all("code.pipeline.stages.qcrs" in text for text in texts_by_stage["qcrs"])
    assert set(texts_by_stage["qcrs"]) != with_both


def test_a_renamed_file_is_neither_added_nor_removed(finished: Project) -> None:
    folder = finished.root / "pictures"
    (folder / "kind3-7.png").rename(folder / "kind3-71.png")
    assert not any("added" in text or "removed" in text for texts in causes(finished).values() for text in texts)


def test_without_an_earlier_run_pictures_are_new(finished: Project) -> None:
    (finished.folder / "shapes.parquet").unlink()
    (finished.folder / "errors.parquet").unlink()
    texts_by_stage = causes(finished.picture("kind1-99.png", 99))
    assert set(texts_by_stage["ingest"]) == {"picture new to the store: kind1-99.png"}


def test_many_causes_are_cut_short(finished: Project) -> None:
    for number in range(8):
        finished.picture(f"kind{number % 4}-{number}.png", 50 + number)
    texts_by_stage = causes(finished.configured(lambda c: replace(c, batch=16)))
    assert any(re.search(r" and \d more", text) for texts in texts_by_stage.values() for text in texts)


@pytest.mark.parametrize("edit", [EDITS[0], PICTURES[0]], ids=lambda edit: edit.name)
def test_it_is_printed_by_stage(finished: Project, edit: Edit) -> None:
    edited = edit.do(finished)
    console = Console(file=io.StringIO(), width=60)
    show_explanation(edited.look(), edited.store, console)
    printed = console.file.getvalue()  # type: ignore[attr-defined]
    if edit.again:
        assert "ingest: 2 of 5 to do, because\n" in printed and f"  2 × {edit.cause}\n" in printed
        assert f"after ingest: {edit.cause}\n" in printed and "crs: known after select" in printed
    else:
        assert "motion: all 3 cached" in printed and "×" not in printed
