"""A small project for tests of edits: code, pictures and configuration that may be edited, and a run of it, made up."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from integration.small_runs import draw, pictures
from plans import planned

from pipeline.config.schema import Config
from pipeline.datasets.collection import DatasetConfig, collect
from pipeline.explain.forecast import Forecast, forecast
from pipeline.plan import code_digest
from pipeline.plan.closure import Project as Code
from pipeline.plan.module_facts import FactsCache
from pipeline.plan.sources import AT_START, PACKAGES, Source
from pipeline.plan.work_item import WorkItem
from pipeline.stages.all import STAGES
from pipeline.store.artifact import Artifact
from pipeline.store.store import State, Store
from pipeline.tables import schemas as tables
from pipeline.tables.outputs import from_rows, write_table
from pipeline.tables.record import ARTIFACTS

PAIRS = [(0, 3), (2, 5), (4, 6)]
"""Pairs that somebody selected: which they are is known only when a run goes on, and an edit may leave them."""

PARSED = FactsCache(PACKAGES)

SHAPES = 8
TOP = len(PAIRS)


@dataclass(frozen=True)
class Project:
    """The code as this process has it, which may be edited, pictures that may be, and a configuration."""

    root: Path
    config: Config
    sources: dict[str, Source]
    patch: pytest.MonkeyPatch

    @classmethod
    def begin(cls, root: Path, patch: pytest.MonkeyPatch) -> Project:
        """A project below ``root``, with some pictures if it has none; nothing is edited yet."""
        sources = dict(AT_START)
        if not (root / "pictures").exists():
            pictures(root / "pictures", range(SHAPES))
        dataset = DatasetConfig("folder", "folder", str(root / "pictures"))
        config = Config(dataset, outputs=root / "outputs", store=root / "store", batch=4)
        return cls(root, config, sources, patch).loaded()

    @classmethod
    def copy(cls, finished: Project, root: Path, patch: pytest.MonkeyPatch) -> Project:
        """A project with everything that a finished one has on the disk."""
        shutil.copytree(finished.root, root, dirs_exist_ok=True)
        return cls.begin(root, patch)

    @property
    def store(self) -> Store:
        return Store(self.config.store)

    @property
    def folder(self) -> Path:
        return self.config.outputs / self.config.dataset.name

    def edit(self, module: str, old: str, new: str) -> Project:
        """Edit a module's source."""
        source = self.sources[module]
        text = source.content.decode()
        assert old in text, f"{module} no longer holds {old!r}"
        self.sources[module] = Source(source.path, text.replace(old, new, 1).encode())
        return self.loaded()

    def loaded(self) -> Project:
        """Have this process go on as if it had begun with the code as it is edited."""
        self.patch.setattr(code_digest, "PROJECT", Code(self.sources, PARSED))
        return self

    def library(self, name: str) -> Project:
        """Install version 0.0 of a library."""
        version = code_digest.installed_version
        self.patch.setattr(code_digest, "installed_version", lambda asked: "0.0" if asked == name else version(asked))
        return self

    def picture(self, name: str, number: int | None) -> Project:
        """Draw a picture, anew if it is there; remove it with ``number`` None."""
        path = self.root / "pictures" / name
        if number is None:
            path.unlink()
        else:
            draw(path, number)
        return self

    def configured(self, change: Callable[[Config], Config]) -> Project:
        """With another configuration."""
        return replace(self, config=change(self.config))

    def look(self) -> Forecast:
        """What a run would do."""
        return forecast(self.config, self.store)

    def plan(self) -> list[WorkItem]:
        """Every work item of a run, if those pairs were selected and all went well."""
        progress = planned(self.config, "motion", read=made_up)
        return [item for items in progress.work.values() for item in items]

    def missing(self) -> list[WorkItem]:
        """What of it is not in the store."""
        return [item for item in self.plan() if self.store.state(*item.reference) is not State.PRESENT]

    def finish(self) -> list[WorkItem]:
        """Do what is missing, with made-up results; returns it."""
        missing = self.missing()
        for item in missing:
            self.store.put(item.parts, made_up(item), {"seconds": 1.0})
        return missing

    def record(self, items: Iterable[WorkItem]) -> None:
        """Write what a finished run leaves that stands on these items, as far as the cache and explanations read it."""
        keys: dict[str, list[str]] = {}
        for item in items:
            keys.setdefault(item.stage, []).append(item.key)
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        (self.folder / ARTIFACTS).write_text(json.dumps(keys))
        collected = collect(self.config.dataset).items
        rows = [{"shape": number, "name": item.name, "digest": item.digest} for number, item in enumerate(collected)]
        write_table(self.folder, "shapes", [from_rows(tables.SCHEMAS["shapes"], rows)])
        write_table(self.folder, "errors", [from_rows(tables.ERRORS, [])])


@pytest.fixture(scope="module")
def finished_once(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Project]:
    """A project whose run is finished, to be copied."""
    with pytest.MonkeyPatch.context() as patch:
        project = Project.begin(tmp_path_factory.mktemp("finished"), patch)
        project.record(project.finish())
        yield project


def made_up(item: WorkItem) -> Artifact:
    """An artifact of its own for each item, with what the plan of later stages reads of it."""
    document = {"of": [item.stage, *item.members], "status": "certified", "iou_p": 0.9, "iou_q": 0.9}
    pairs = np.array(PAIRS if item.stage == "select" else np.empty((0, 2)), dtype=np.int64)
    positions = np.arange(TOP if item.stage in ("shortlist", "choose") else 0)
    return Artifact({"pairs": pairs, "score": np.ones(len(pairs)), "positions": positions}, document)


@dataclass(frozen=True)
class Edit:
    """An edit, the stages whose keys it changes (of `ALL`), and words of the cause."""

    name: str
    do: Callable[[Project], Project]
    again: frozenset[str]
    cause: str = ""

    @property
    def of_code(self) -> bool:
        """Whether it is of the code or the libraries, and not of what is mined or how."""
        return self.cause.startswith(("code.", "versions."))


ALL = frozenset(stage.name for stage in STAGES) - {
    "shards", "partners", "partners_beyond", "pairs", "paper", "paint", "fabricate", "margin", "swing", "preselect",
}  # fmt: skip
"""The stages of a usual small run without pictures; what is made up has no transform of which a margin could be."""
OF_SHAPES = frozenset(stage.name for stage in STAGES if stage.scope == "batch")
RATED = OF_SHAPES - {"trunks"} | {"near_duplicates", "modes"}
"""Stages that look for no trunks."""
STATIC = OF_SHAPES | {"qcrs", "qcrs_rare"}
TRUNKS_ON = frozenset({"qcrs", "qcrs_rare", "select"})
CROSS_ON = frozenset({"crs", "refine", "shortlist", "bend", "construct", "choose", "motion"})


def _code(module: str, old: str, new: str, again: Iterable[str], changed: str = "") -> Edit:
    cause = f"code.{module}{changed}" if again else ""
    return Edit(f"{module}: {new[:20]!r}", lambda p: p.edit(module, old, new), frozenset(again), cause)


def _parameter(cause: str, change: Callable[[Config], Config], again: Iterable[str]) -> Edit:
    return Edit(cause or "no result", lambda p: p.configured(change), frozenset(again), cause)


def _library(name: str, again: Iterable[str]) -> Edit:
    return Edit(name, lambda p: p.library(name), frozenset(again), f"versions.{name}" if again else "")


FUTURE = "from __future__ import annotations\n"

SHOWN = (
    "riot.draw.palette",
    "riot.draw.svg",
    "riot.draw.scene",
    "pipeline.report.page",
    "pipeline.config.schema",
    "pipeline.plan.progress",
)
"""Code that plans results or shows them, and makes none."""

CODE = [
    _code("riot.scores.trunks", '"""', '"""Other words. ', ()),
    _code("riot.geometry.polyline", "def signed_area(", "# a comment\ndef signed_area(", ()),
    _code("pipeline.store.store", "def put(", "def new(self) -> None: ...\n\n    def put(", ()),
    _code("pipeline.runtime.retries", "WORKER_TRIES = ", "WORKER_TRIES = 1 + ", ()),
    _code("riot.parameters.trunks", "tau_s: float = ", "tau_s: float = 2 * ", ()),
    _code("riot.units", "L_C = 2.0", "L_C = 2.1", ALL),
    _code("riot.geometry.polyline", "def signed_area(", "def other_area(", ALL),
    _code("riot.scores.trunks", "def quick_trunks(", "LIMIT = 1\n\n\ndef quick_trunks(", ALL - RATED),
    _code("riot.scores.crs", "AREA_SLACK = 2e-3", "AREA_SLACK = 3e-3", CROSS_ON),
    _code("pipeline.stages.qcrs", "def run(", "@staticmethod\ndef run(", {"qcrs", "select"}, ":run"),
    _code("pipeline.stages.motion", "def run(", "@staticmethod\ndef run(", {"motion"}, ":run"),
    _code(
        "pipeline.stages.construct", "def run(", "@staticmethod\ndef run(", {"construct", "choose", "motion"}, ":run"
    ),
    *(_code(module, FUTURE, f"{FUTURE}EDITED = 1\n", ()) for module in SHOWN),
    *(_code(f"pipeline.stages.{stage}", "def items(", "@staticmethod\ndef items(", ()) for stage in ("qcrs", "motion")),
    _code("pipeline.stages.crs", '"area terms evaluated"', '"area terms"', ()),
]

PARAMETERS = [
    _parameter(
        "parameters.trunks.tau_s 0.1 → 0.11",
        lambda c: replace(c, trunks=replace(c.trunks, tau_s=0.11)),
        ALL - RATED,
    ),
    _parameter(
        "parameters.qcrs.sigma_e 0.1 → 0.11", lambda c: replace(c, qcrs=replace(c.qcrs, sigma_e=0.11)), TRUNKS_ON
    ),
    _parameter(
        "parameters.crs.sigma_area 0.3 → 0.31", lambda c: replace(c, crs=replace(c.crs, sigma_area=0.31)), CROSS_ON
    ),
    _parameter(
        "parameters.select.top 100 → 7",
        lambda c: replace(c, select=replace(c.select, top=7)),
        {"select", "shortlist", "choose"},
    ),
    _parameter(
        "parameters.shape.spacing 100.0 → 99.0", lambda c: replace(c, shape=replace(c.shape, spacing=99.0)), ALL
    ),
    _parameter("", lambda c: replace(c, cluster=replace(c.cluster, kind="sync", workers=3)), ()),
]

LIBRARIES = [
    _library("pillow", ALL),
    _library("numba", ALL),
    _library("pyarrow", ()),
    _library("dask", ()),
    _library("rich", ()),
]

PICTURES = [
    Edit("replaced", lambda p: p.picture("kind2-2.png", 77), ALL, "picture replaced: kind2-2.png"),
    Edit("added", lambda p: p.picture("kind1-99.png", 99), ALL, "picture added: kind1-99.png"),
    Edit("removed", lambda p: p.picture("kind2-2.png", None), ALL, "picture removed: kind2-2"),
    # Alone in its batch: the blocks of the others stay, but for the rare ones, which have several batches on a side.
    Edit(
        "removed alone",
        lambda p: p.picture("kind0-0.png", None),
        ALL - STATIC | {"qcrs_rare"},
        "picture removed: kind0-0",
    ),
]

EDITS = [*CODE, *PARAMETERS, *LIBRARIES, *PICTURES]

OF_EACH_KIND = [CODE[1], CODE[4], CODE[5], CODE[6], CODE[9], PARAMETERS[0], PARAMETERS[3], *LIBRARIES[1:3], *PICTURES]
"""A comment, a default, a constant, a helper, a stage, parameters, libraries, pictures."""
