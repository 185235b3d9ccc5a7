"""What is edited and what is done again: for every kind of edit, the stages whose keys change, and no others."""

from __future__ import annotations

from pathlib import Path

import pytest
from edited_project import CODE, LIBRARIES, PARAMETERS, Edit, Project
from integration.small_runs import draw
from plans import planned

from pipeline.cli.accept import accept
from pipeline.plan.work_item import WorkItem
from pipeline.store.artifact import Artifact
from pipeline.store.store import State, Store

Keys = dict[tuple[str, tuple[int, ...]], str]
"""Key of every work item, by stage and the shapes that it concerns."""


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Project:
    return Project.begin(tmp_path, monkeypatch)


def keys_of(project: Project) -> Keys:
    return {(item.stage, item.members): item.key for item in project.plan()}


def changed(before: Keys, after: Keys) -> set[str]:
    assert before.keys() == after.keys()
    stages_of = {name for name, _ in before}
    stages = {
        name
        for name in stages_of
        if any(before[reference] != after[reference] for reference in before if reference[0] == name)
    }
    # An edit of code, versions or parameters concerns a whole stage or nothing of it.
    assert all(before[reference] != after[reference] for reference in before if reference[0] in stages)
    return stages


@pytest.mark.parametrize("edit", [*CODE, *PARAMETERS, *LIBRARIES], ids=lambda edit: edit.name)
def test_an_edit_changes_the_keys_of_what_it_concerns(project: Project, edit: Edit) -> None:
    before = keys_of(project)
    assert changed(before, keys_of(edit.do(project))) == edit.again


def test_another_picture_concerns_what_it_is_in(project: Project) -> None:
    before = keys_of(project)
    plan = planned(project.config, "ingest")
    number = 2
    draw(next((project.root / "pictures").glob(plan.items[number].name + ".png")), 77)
    after = keys_of(project)
    whole = {"select", "shortlist", "choose", "near_duplicates"}
    for (stage, members), key in after.items():
        if stage not in whole and (stage, members) in before:
            assert (key != before[stage, members]) == (number in members)
    assert all(
        before[reference] != after[reference] for reference in before.keys() & after.keys() if reference[0] in whole
    )


def stored(store: Store, items: list[WorkItem]) -> list[str]:
    """Put something for every item; the run's list of keys."""
    for number, item in enumerate(items):
        store.put(item.parts, Artifact({}, {"number": number}), {"seconds": 1.0})
    return [item.key for item in items]


def test_an_accepted_edit_redoes_nothing(project: Project, tmp_path: Path) -> None:
    store = Store(tmp_path / "store")
    items = project.plan()
    stored(store, items)
    listed: dict[str, list[str]] = {}
    for item in items:
        listed.setdefault(item.stage, []).append(item.key)
    assert accept(store, listed).accepted == {}
    project.edit(
        "riot.geometry.polyline", "def signed_area(", "def same_area(points):\n    return 0\n\n\ndef signed_area("
    )
    renewed = project.plan()
    assert {store.state(*item.reference) for item in renewed} == {State.ABSENT}
    tried = accept(store, listed, dry_run=True)
    assert {store.state(*item.reference) for item in renewed} == {State.ABSENT}
    acceptance = accept(store, listed)
    assert acceptance == tried and acceptance.accepted == {name: len(keys) for name, keys in listed.items()}
    assert any("code.riot.geometry.polyline" in text for text in acceptance.changes)
    # Every item of the new plan has the very artifact of its own item of the old one.
    for number, item in enumerate(renewed):
        assert store.get(*item.reference).document == {"number": number}
    assert accept(store, listed).accepted == {}


def test_only_what_is_whole_is_accepted(project: Project, tmp_path: Path) -> None:
    store = Store(tmp_path / "store")
    items = project.plan()
    stored(store, items)
    project.edit("pipeline.stages.motion", "def run(", "@staticmethod\ndef run(")
    store.files.remove(f"motion/{items[-1].key[:2]}/{items[-1].key}")
    with pytest.raises(KeyError):
        accept(store, {"motion": [items[-1].key]})
