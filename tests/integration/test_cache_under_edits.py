"""``python -m pipeline.cache`` under every kind of edit: it counts, keeps, deletes and accepts what it should."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import pytest
from edited_project import ALL, OF_EACH_KIND, Edit, Project, finished_once

import pipeline.stages.shards
from pipeline.cache import main
from pipeline.cli.cache import damaged, stale, usage
from pipeline.exit_codes import CLEAN
from pipeline.plan.work_item import Reference, WorkItem

__all__ = ["finished_once"]

of_each_kind = pytest.mark.parametrize("edit", OF_EACH_KIND, ids=[edit.name for edit in OF_EACH_KIND])


@pytest.fixture
def project(finished_once: Project, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Project:
    return Project.copy(finished_once, tmp_path, monkeypatch)


def held(project: Project) -> set[Reference]:
    return set(project.store.folders())


def references(items: Iterable[WorkItem]) -> set[Reference]:
    return {item.reference for item in items}


def call(project: Project, command: str, *more: str) -> int:
    places = ["--store", str(project.config.store)]
    places += ["--outputs", str(project.config.outputs)] if command == "gc" else []
    places += ["--run", str(project.folder)] if command == "accept" else []
    return main([command, *places, *more])


def bytes_on_disk(project: Project, stage: str) -> int:
    return sum(file.stat().st_size for file in (Path(str(project.config.store)) / stage).rglob("*") if file.is_file())


@of_each_kind
def test_what_is_counted_kept_and_deleted(project: Project, edit: Edit) -> None:
    before = held(project)
    edited = edit.do(project)
    # du: an edit of code or libraries makes its stages stale, an edit of anything else none.
    expected = {one for one in before if edit.of_code and one[0] in edit.again}
    assert stale(edited.store) == expected
    found = {one.stage: one for one in usage(edited.store)}
    assert found.keys() == ALL and all(one.size == bytes_on_disk(edited, name) for name, one in found.items())
    assert Counter(name for name, _ in expected) == +Counter({name: one.stale for name, one in found.items()})
    assert {name for name, one in found.items() if one.stale_size} == {name for name, _ in expected}
    assert call(edited, "verify") == CLEAN
    # gc: the finished run needs all that it made; what is stale goes only if that is wanted.
    assert call(edited, "gc") == CLEAN and held(edited) == before
    assert call(edited, "gc", "--stale", "--dry-run") == CLEAN and held(edited) == before
    again = references(edited.finish())
    if edit.of_code:
        assert {stage for stage, _ in again} == edit.again and len(again) == len(expected)
    # The next run needs what it found and what it made; gc deletes the rest, and the run after it has nothing to do.
    standing = edited.plan()
    needed = references(standing)
    assert again <= needed <= before | again
    edited.record(standing)
    assert call(edited, "gc") == CLEAN and held(edited) == needed
    assert not edited.missing() and not damaged(edited.store) and not stale(edited.store)


@pytest.mark.parametrize("edit", [one for one in OF_EACH_KIND if one.of_code], ids=lambda edit: edit.name)
def test_a_run_makes_again_exactly_what_was_deleted_as_stale(project: Project, edit: Edit) -> None:
    before = held(project)
    edited = edit.do(project)
    assert call(edited, "gc", "--stale") == CLEAN
    gone = before - held(edited)
    assert gone == {one for one in before if one[0] in edit.again}
    again = references(edited.finish())
    assert Counter(stage for stage, _ in again) == Counter(stage for stage, _ in gone)


@of_each_kind
def test_accept_makes_stale_items_current_and_nothing_else(project: Project, edit: Edit) -> None:
    before = held(project)
    edited = edit.do(project)
    left = set[Reference]() if edit.of_code else references(edited.missing())
    assert call(edited, "accept") == CLEAN
    assert references(edited.missing()) == left
    accepted = held(edited) - before
    assert before <= held(edited) and {stage for stage, _ in accepted} == (edit.again if edit.of_code else set())
    for stage, key in accepted:
        assert edited.store.get(stage, key).document["of"][0] == stage
    assert stale(edited.store) == {one for one in before if edit.of_code and one[0] in edit.again}
    assert call(edited, "verify") == CLEAN
    assert call(edited, "accept") == CLEAN and held(edited) == before | accepted


def test_accept_keeps_another_edit_s_work_to_do(project: Project) -> None:
    """Code that was edited without effect, and a parameter: what reads the parameter is done again."""
    edited = project.configured(lambda c: replace(c, qcrs=replace(c.qcrs, sigma_e=0.2)))
    edited = edited.edit("riot.geometry.polyline", "def signed_area(", "def other_area(")
    assert call(edited, "accept") == CLEAN
    assert {stage for stage, _ in references(edited.missing())} == {"qcrs", "qcrs_rare", "select"}


def test_accept_with_topk_redoes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pipeline.stages.shards, "SHAPES_PER_SHARD", 4)
    begun = Project.begin(tmp_path, monkeypatch)
    project = begun.configured(lambda c: replace(c, qcrs=replace(c.qcrs, mode="topk", k=3)))
    project.record(project.finish())
    assert len({key for stage, key in held(project) if stage == "shards"}) > 1
    project.edit("riot.geometry.polyline", "def signed_area(", "def other_area(")
    assert project.missing()
    assert call(project, "accept") == CLEAN
    assert not project.missing()
