"""What is edited and what is done again: for every kind of edit, the stages whose keys change, and no others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from integration.small_runs import draw, pictures

from pipeline import closure
from pipeline.accept import accept
from pipeline.artifact import Artifact
from pipeline.config import Config
from pipeline.datasets import DatasetConfig, collect
from pipeline.causes import reasons
from pipeline.plan import (
    WorkItem,
    make_plan,
    plan_construct,
    plan_crs,
    plan_full_trunks,
    plan_motions,
    plan_refine,
    plan_select,
    plan_shortlist,
)
from pipeline.sources import AT_START, Source
from pipeline.store import State, Store

Keys = dict[tuple[str, tuple[int, ...]], str]
"""Key of every work item, by stage and the shapes that it concerns."""

PAIRS = [(0, 3), (2, 5), (4, 6)]
"""Pairs that somebody selected: which they are is known only when a run goes on, and an edit may leave them."""

TRUNKS_ON = {"qcrs", "select"}
CROSS_ON = {"crs", "refine", "shortlist", "construct", "motion"}
ALL = {"ingest", "reversibility", "trunks", "trunks_full"} | TRUNKS_ON | CROSS_ON


@dataclass(frozen=True)
class Project:
    """The code as this process has it, which may be edited, pictures that may be, and a configuration."""

    root: Path
    config: Config
    sources: dict[str, Source]

    def plan(self) -> list[WorkItem]:
        """Every work item of a run, if those pairs were selected and all went well."""
        plan = make_plan(self.config, collect(self.config.dataset))
        static = [*plan.ingest, *plan.reversibility, *plan.trunks, *plan.qcrs.values()]
        full = plan_full_trunks(plan, PAIRS)
        crs = plan_crs(plan, PAIRS, full)
        refine = plan_refine(plan, crs)
        made = plan_construct(plan, refine)
        select = plan_select(plan, {item.reference for item in static})
        later = [*full.values(), *crs, *refine, plan_shortlist(plan, refine), *made, *plan_motions(plan, made)]
        return [*static, select, *later]

    def keys(self) -> Keys:
        return {(item.stage, item.members): item.key for item in self.plan()}

    def edit(self, module: str, old: str, new: str) -> None:
        source = self.sources[module]
        text = source.content.decode()
        assert old in text, f"{module} no longer holds {old!r}"
        self.sources[module] = Source(source.path, text.replace(old, new, 1).encode())


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Project:
    sources = dict(AT_START)
    monkeypatch.setattr(closure, "AT_START", sources)
    dataset = DatasetConfig("folder", "folder", str(pictures(tmp_path / "pictures", range(8))))
    return Project(tmp_path, Config(dataset, batch=2), sources)


def changed(before: Keys, after: Keys) -> set[str]:
    assert before.keys() == after.keys()
    stages_of = {name for name, _ in before}
    found = {name for name in stages_of if any(before[one] != after[one] for one in before if one[0] == name)}
    # An edit of code, versions or parameters concerns a whole stage or nothing of it.
    assert all(before[one] != after[one] for one in before if one[0] in found)
    return found


CODE = [
    ("riot.trunks", '"""', '"""Other words. ', set()),
    ("riot.polyline", "def signed_area(", "# a comment\ndef signed_area(", set()),
    ("pipeline.store", "def put(", "def new(self) -> None: ...\n\n    def put(", set()),
    ("pipeline.cluster", "MAX_ATTEMPTS = ", "MAX_ATTEMPTS = 1 + ", set()),
    ("riot.parameters", "tau_s: float = ", "tau_s: float = 2 * ", set()),
    ("riot.polyline", "def signed_area(", "def other_area(", ALL),
    ("riot.trunks", "def quick_trunks(", "LIMIT = 1\n\n\ndef quick_trunks(", ALL - {"ingest", "reversibility"}),
    ("riot.cross", "AREA_SLACK = 2e-3", "AREA_SLACK = 3e-3", CROSS_ON),
    ("pipeline.work.qcrs", "def run(", "EDITED = 1\n\n\ndef run(", {"qcrs", "select"}),
    ("pipeline.work.motion", "def run(", "EDITED = 1\n\n\ndef run(", {"motion"}),
    ("pipeline.work.construct", "def run(", "EDITED = 1\n\n\ndef run(", {"construct", "motion"}),
]


@pytest.mark.parametrize(("module", "old", "new", "again"), CODE)
def test_an_edit_of_code(project: Project, module: str, old: str, new: str, again: set[str]) -> None:
    before = project.keys()
    project.edit(module, old, new)
    assert changed(before, project.keys()) == again


PARAMETERS: list[tuple[Callable[[Config], Config], set[str]]] = [
    (lambda c: replace(c, trunks=replace(c.trunks, tau_s=0.11)), ALL - {"ingest", "reversibility"}),
    (lambda c: replace(c, qcrs=replace(c.qcrs, sigma_e=0.11)), {"qcrs", "select"}),
    (lambda c: replace(c, crs=replace(c.crs, sigma_area=0.31)), CROSS_ON),
    (lambda c: replace(c, select=replace(c.select, top=7)), {"select", "shortlist"}),
    (lambda c: replace(c, shape=replace(c.shape, spacing=99.0)), ALL),
    (lambda c: replace(c, outputs=Path("elsewhere"), store=Path("there")), set()),
    (lambda c: replace(c, cluster=replace(c.cluster, kind="sync", workers=3)), set()),
]


@pytest.mark.parametrize(("edit", "again"), PARAMETERS)
def test_an_edit_of_a_parameter(project: Project, edit: Callable[[Config], Config], again: set[str]) -> None:
    assert changed(project.keys(), replace(project, config=edit(project.config)).keys()) == again


@pytest.mark.parametrize(
    ("library", "again"), [("pillow", ALL), ("numba", ALL), ("pyarrow", set()), ("dask", set()), ("rich", set())]
)
def test_another_version_of_a_library(
    project: Project, library: str, again: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    before, version = project.keys(), closure._version
    monkeypatch.setattr(closure, "_version", lambda name: "0.0" if name == library else version(name))
    assert changed(before, project.keys()) == again


def test_another_picture_concerns_what_it_is_in(project: Project) -> None:
    before = project.keys()
    plan = make_plan(project.config, collect(project.config.dataset))
    number = 2
    draw(next((project.root / "pictures").glob(plan.items[number].name + ".png")), 77)
    after = project.keys()
    whole = {"select", "shortlist"}
    for (stage, members), key in after.items():
        if stage not in whole and (stage, members) in before:
            assert (key != before[stage, members]) == (number in members)
    assert all(before[one] != after[one] for one in before.keys() & after.keys() if one[0] in whole)


def stored(store: Store, items: list[WorkItem]) -> list[str]:
    """Put something for every item; the run's list of keys."""
    for number, item in enumerate(items):
        store.put(item.parts, Artifact({}, {"number": number}), {"seconds": 1.0})
    return [item.key for item in items]


EXPLAINED: list[tuple[str, Callable[[Project], Any], str]] = [
    ("crs", lambda p: p.edit("riot.cross", "AREA_SLACK = 2e-3", "AREA_SLACK = 3e-3"), "code.riot.cross "),
    ("trunks", lambda p: p.edit("riot.polyline", "def signed_area(", "def x("), "code.riot.polyline "),
]


@pytest.mark.parametrize(("stage", "edit", "words"), EXPLAINED)
def test_every_rerun_names_its_cause(
    project: Project, tmp_path: Path, stage: str, edit: Callable[[Project], Any], words: str
) -> None:
    store = Store(tmp_path / "store")
    stored(store, project.plan())
    edit(project)
    missing = [item for item in project.plan() if item.stage == stage]
    found = reasons(missing, store)
    assert sum(found.values()) == len(missing) and all(words in text for text in found)


def test_an_accepted_edit_redoes_nothing(project: Project, tmp_path: Path) -> None:
    store = Store(tmp_path / "store")
    items = project.plan()
    stored(store, items)
    listed: dict[str, list[str]] = {}
    for item in items:
        listed.setdefault(item.stage, []).append(item.key)
    assert accept(store, listed).accepted == {}
    project.edit("riot.polyline", "def signed_area(", "def same_area(points):\n    return 0\n\n\ndef signed_area(")
    renewed = project.plan()
    assert {store.state(*item.reference) for item in renewed} == {State.ABSENT}
    tried = accept(store, listed, dry_run=True)
    assert {store.state(*item.reference) for item in renewed} == {State.ABSENT}
    found = accept(store, listed)
    assert found == tried and found.accepted == {name: len(keys) for name, keys in listed.items()}
    assert any("code.riot.polyline" in text for text in found.changes)
    # Every item of the new plan has the very artifact of its own item of the old one.
    for number, item in enumerate(renewed):
        assert store.get(*item.reference).document == {"number": number}
    assert accept(store, listed).accepted == {}


def test_only_what_is_whole_is_accepted(project: Project, tmp_path: Path) -> None:
    store = Store(tmp_path / "store")
    items = project.plan()
    stored(store, items)
    project.edit("pipeline.work.motion", "def run(", "EDITED = 1\n\n\ndef run(")
    store.files.remove(f"motion/{items[-1].key[:2]}/{items[-1].key}")
    with pytest.raises(KeyError):
        accept(store, {"motion": [items[-1].key]})
