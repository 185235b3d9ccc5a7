"""Code digests: a change of meaning changes them, a change of words does not, and neither does a cache."""

from __future__ import annotations

import ast
import threading
from collections.abc import Callable, Mapping
from importlib import metadata
from pathlib import Path

import pytest

from pipeline.plan.closure import Project
from pipeline.plan.code_digest import DISTRIBUTIONS, PROJECT, code_digests, library_versions
from pipeline.plan.sources import ROOT, edited, read_sources
from pipeline.plan.syntax_digest import syntax_digest
from pipeline.stages.all import STAGES
from pipeline.stages.stage import Stage

SOURCE = '''"""About the module."""
import numpy as np

LIMIT = 3
"""What it is."""

def area(x: float) -> float:
    """About the function."""
    # a comment
    return x * LIMIT
'''

FACE = "import lazy_loader\n__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)\n"

FILES = {
    "ours/__init__.py": "from ours.other import everything",
    "ours/start.py": "import json\nfrom ours import late\nfrom ours.sub.deep import f\nimport numpy.linalg",
    "ours/late.py": "def g():\n    from .hidden import h\n    return h",
    "ours/hidden.py": "h = 1",
    "ours/other.py": "everything = 1",
    "ours/sub/__init__.py": "",
    "ours/sub/deep.py": "import typing\nif typing.TYPE_CHECKING:\n    from ours.typing_only import T\nf = 1",
    "ours/typing_only.py": "T = int",
}

LAZY = {
    "lib/__init__.py": FACE + "SETTING = 1\n",
    "lib/__init__.pyi": "from . import motion as motion\nfrom . import scores as scores\n"
    "from .scores.crs import crs as crs\n",
    "lib/scores/__init__.py": FACE,
    "lib/scores/__init__.pyi": "from . import qcrs as qcrs\nfrom .crs import Best as Best, crs as crs\n",
    "lib/scores/crs.py": "from lib.units import L\ncrs = Best = 1",
    "lib/scores/qcrs.py": "qcrs = 1",
    "lib/scores/extra.py": "extra = 1",
    "lib/motion/__init__.py": FACE,
    "lib/motion/__init__.pyi": "from .planner import plan_motion as plan_motion\n",
    "lib/motion/planner.py": "from lib import scores\ndef plan_motion():\n    return scores.qcrs.qcrs",
    "lib/units.py": "L = 1",
    "app/__init__.py": "",
    "app/again.py": "from lib import scores\nscores",
}


def write(root: Path, files: Mapping[str, str]) -> Path:
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return root


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("About the module.", "Other words."),
        ("About the function.", "Other words entirely."),
        ("What it is.", "Something."),
        ("    # a comment\n", ""),
        ("return x * LIMIT", "return (x  *\n        LIMIT)"),
        ('    """About the function."""\n', ""),
    ],
)
def test_words_and_layout_do_not_count(old: str, new: str) -> None:
    assert old in SOURCE
    assert syntax_digest(ast.parse(SOURCE.replace(old, new))) == syntax_digest(ast.parse(SOURCE))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("x * LIMIT", "x + LIMIT"),
        ("LIMIT = 3", "LIMIT = 4"),
        ("LIMIT = 3", "LIMIT = 3.0"),
        ("LIMIT = 3", "LIMIT = None"),
        ("x: float", "x: int"),
        ("area", "volume"),
        ("return x * LIMIT", "return LIMIT * x"),
    ],
)
def test_meaning_counts(old: str, new: str) -> None:
    assert syntax_digest(ast.parse(SOURCE.replace(old, new))) != syntax_digest(ast.parse(SOURCE))


def test_the_closure_follows_what_runs(tmp_path: Path) -> None:
    closure = Project.read(write(tmp_path, FILES), ["ours"]).closure("ours.start")
    assert closure.modules == ("ours.hidden", "ours.late", "ours.start", "ours.sub.deep")
    assert {"json", "numpy"} <= set(closure.libraries) and "ours" not in closure.libraries


def test_an_edit_changes_only_the_digests_of_those_who_run_it(tmp_path: Path) -> None:
    def digests() -> dict[str, str]:
        return Project.read(tmp_path, ["ours"]).digests("ours.start")

    write(tmp_path, FILES)
    before = digests()
    write(tmp_path, {"ours/hidden.py": "h = 2  # edited"})
    after = digests()
    assert {name for name in before if before[name] != after[name]} == {"ours.hidden"}
    write(tmp_path, {"ours/typing_only.py": "T = str"})
    assert digests() == after


def test_a_missing_module_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(ModuleNotFoundError):
        Project.read(write(tmp_path, FILES), ["ours"]).closure("ours.nowhere")


SCORES = {"lib.scores.crs", "lib.scores.qcrs", "lib.units"}
MOTION = {"lib.motion.planner", "lib.scores.qcrs"}


@pytest.mark.parametrize(
    ("code", "modules"),
    [
        ("from lib import scores", set()),
        ("from lib import scores\nscores.crs()", {"lib.scores.crs", "lib.units"}),
        ("from lib import scores\nscores.qcrs.qcrs()", {"lib.scores.qcrs"}),
        ("from lib import scores as s\ndef f():\n    return [s.qcrs.qcrs for _ in s.Best]", SCORES),
        ("import lib\nlib.crs()", {"lib.scores.crs", "lib.units"}),
        ("import lib\nlib.motion.plan_motion().__name__", MOTION),
        ("import lib.scores.qcrs", {"lib.scores.qcrs"}),
        ("import lib.scores.extra\nlib.scores.extra.extra", {"lib.scores.extra"}),
        ("from lib.scores import extra", {"lib.scores.extra"}),
        ("from lib.scores.crs import Best", {"lib.scores.crs", "lib.units"}),
        ("from lib.motion import plan_motion", MOTION),
        ("from lib import SETTING", {"lib"}),
        ("import lib\nlib.SETTING", {"lib"}),
        ("from lib import scores\nuse(scores)", SCORES | {"lib.scores"}),
        ("from lib import scores\ngetattr(scores, 'qcrs')", SCORES | {"lib.scores"}),
        ("from lib.scores import *", SCORES | {"lib.scores"}),
        ("import lib\nuse(lib)", SCORES | MOTION | {"lib", "lib.scores", "lib.motion"}),
        ("from app.again import scores\nscores.crs", {"app.again"} | SCORES | {"lib.scores"}),
        ("from lib import scores\ndef f(scores):\n    return scores", set()),
        ("from lib import scores\nf = [scores for scores in x]", set()),
        ("from lib import scores\nf = [s for scores in scores.qcrs]", {"lib.scores.qcrs"}),
        ("from lib import scores\ndef f():\n    scores = 1\n    return scores", set()),
        ("from lib import scores\ndef f():\n    global scores\n    scores = scores.qcrs", {"lib.scores.qcrs"}),
        ("from lib import scores\nclass C:\n    scores: int = 1\n    def f(self):\n        return scores.qcrs",
         {"lib.scores.qcrs"}),
        ("def f():\n    from lib import scores\n    return scores.qcrs\nscores", {"lib.scores.qcrs"}),
        ("from lib import scores\ndef f(x: scores.qcrs = 1): ...", {"lib.scores.qcrs"}),
    ],
)  # fmt: skip
def test_of_a_face_counts_what_is_used(tmp_path: Path, code: str, modules: set[str]) -> None:
    write(tmp_path, {**LAZY, "app/start.py": code})
    closure = Project.read(tmp_path, ["lib", "app"]).closure("app.start")
    assert set(closure.modules) == modules | {"app.start"}


def test_a_stub_counts_for_those_whose_names_it_leads_elsewhere(tmp_path: Path) -> None:
    def digests() -> dict[str, str]:
        return Project.read(tmp_path, ["lib", "app"]).digests("app.start")

    write(tmp_path, {**LAZY, "app/start.py": "from lib.scores import Best, qcrs"})
    before = digests()
    stub = LAZY["lib/scores/__init__.pyi"]
    write(tmp_path, {"lib/scores/__init__.pyi": f"{stub}from . import extra as extra\n"})
    assert digests() == before, "another name is offered, too"
    write(
        tmp_path,
        {"lib/scores/__init__.pyi": stub.replace("from .crs", "from .qcrs")},
    )
    after = digests()
    assert before["app.start"] != after["app.start"]
    assert before["lib.scores.qcrs"] == after["lib.scores.qcrs"]


def test_an_edited_stub_is_noticed(tmp_path: Path) -> None:
    write(tmp_path, {**LAZY, "app/start.py": "from lib.scores import Best"})
    known = read_sources(tmp_path, ["lib", "app"])
    files = Project.read(tmp_path, ["lib", "app"]).closure("app.start").files
    assert edited(files, known) == []
    write(tmp_path, {"lib/scores/__init__.pyi": "from .qcrs import Best as Best\n"})
    assert edited(files, known) == ["lib.scores"]


def _truncated(data: bytes) -> bytes:
    return data[: len(data) // 2]


def _of_other_rules(data: bytes) -> bytes:
    return data.replace(b"[", b" [", 1)


@pytest.mark.parametrize("damage", [_truncated, _of_other_rules, lambda data: b"", lambda data: b"\xff\n{}"])
def test_no_digest_depends_on_the_cache(tmp_path: Path, damage: Callable[[bytes], bytes]) -> None:
    write(tmp_path / "code", {**FILES, **LAZY, "app/start.py": "import lib\nfrom ours import start\nlib.crs"})
    cache = tmp_path / "cache" / "facts.json"

    def digests(cache: Path | None) -> dict[str, str]:
        return Project.read(tmp_path / "code", ["ours", "lib", "app"], cache).digests("app.start")

    expected = digests(None)
    assert digests(cache) == expected and cache.is_file()
    assert digests(cache) == expected, "from the cache"
    cache.write_bytes(damage(cache.read_bytes()))
    assert digests(cache) == expected
    assert digests(cache / "below a file") == expected, "a cache that cannot be written"
    other = tmp_path / "code" / "ours" / "hidden.py"
    other.write_text("h = 2")
    assert digests(cache) == digests(None) != expected


def test_a_cache_of_other_packages_is_foreign(tmp_path: Path) -> None:
    write(tmp_path, {"lib/__init__.py": "", "lib/a.py": "import ours.b", "ours/b.py": ""})
    cache = tmp_path / "facts.json"
    assert Project.read(tmp_path, ["lib"], cache).closure("lib.a").libraries == ("ours",)
    assert Project.read(tmp_path, ["lib", "ours"], cache).closure("lib.a").modules == ("lib.a", "ours.b")


def test_any_number_of_writers_leave_a_whole_cache(tmp_path: Path) -> None:
    write(tmp_path / "code", FILES)
    cache = tmp_path / "facts.json"
    expected = Project.read(tmp_path / "code", ["ours"]).digests("ours.start")
    digests: list[dict[str, str]] = []

    def start() -> None:
        for _ in range(10):
            cache.unlink(missing_ok=True)
            digests.append(Project.read(tmp_path / "code", ["ours"], cache).digests("ours.start"))

    threads = [threading.Thread(target=start) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert digests == [expected] * 40
    assert [path.name for path in tmp_path.glob("facts*")] in ([cache.name], [])


STAGE_FILE = """
import os  # for what it does
from lib.plan import Stage, planned
from lib.compute import work, helper, shown

LIMIT = 3

def inner():
    return helper(LIMIT)

def run(inputs):
    return work(inner())

def other():
    return 1

def items(progress):
    return planned(other())

def columns(artifact):
    return shown(artifact)

STAGE = Stage(name="one", run=run, items=items, tables=(columns,), wanted=lambda config: LIMIT > 2)
"""

STAGED = {
    "lib/__init__.py": "",
    "lib/plan.py": "Stage = planned = 1",
    "lib/compute.py": "work = helper = shown = 1",
    "lib/one.py": STAGE_FILE,
    "lib/two.py": "from lib.one import other, inner\n"
    "def run():\n    return other()\nSTAGE = object(run=run, items=inner)",
}


def staged(root: Path, text: str = STAGE_FILE, module: str = "lib.one") -> dict[str, str]:
    write(root, {**STAGED, "lib/one.py": text})
    return Project.read(root, ["lib"]).digests(module)


def test_of_a_stage_counts_what_its_work_reaches(tmp_path: Path) -> None:
    one = staged(tmp_path)
    assert one.keys() == {"lib.compute", "lib.one", "lib.one:", "lib.one:LIMIT", "lib.one:inner", "lib.one:run"}
    assert staged(tmp_path, module="lib.two").keys() == {"lib.two", "lib.two:run", "lib.one:other", "lib.one:"}


@pytest.mark.parametrize(
    ("old", "new", "changed"),
    [
        ("planned(other())", "planned(2)", set()),
        ('name="one"', 'name="two"', set()),
        ("config: LIMIT > 2", "config: False", set()),
        ("shown(artifact)", "artifact", set()),
        ("LIMIT = 3", "LIMIT = 4", {"lib.one:LIMIT"}),
        ("work(inner())", "work(LIMIT)", {"lib.one:run", "lib.one:inner"}),
        ("run=run", "run=inner", {"lib.one", "lib.one:run"}),
        ("helper(LIMIT)", "planned(LIMIT)", {"lib.one:inner", "lib.plan"}),
        ("LIMIT = 3", "LIMIT = 3\nif LIMIT:\n    LIMIT = planned", {"lib.one:", "lib.plan"}),
    ],
)
def test_an_edit_of_a_stage_changes_what_it_reaches(tmp_path: Path, old: str, new: str, changed: set[str]) -> None:
    before = staged(tmp_path)
    assert old in STAGE_FILE
    after = staged(tmp_path, STAGE_FILE.replace(old, new))
    assert {name for name in before.keys() | after.keys() if before.get(name) != after.get(name)} == changed


PLANS_AND_SHOWS = (
    "pipeline.config",
    "pipeline.plan.progress",
    "pipeline.plan.code_digest",
    "pipeline.stages.stage",
    "pipeline.runtime",
    "pipeline.tables",
    "pipeline.report",
    "pipeline.study",
    "pipeline.cli",
    "riot.cli",
)
PAINTS = {"paint": ("riot.draw.texture", "riot.draw.piece_image", "riot.draw.palette"), "fabricate": ("riot.draw",)}
"""Stages whose results are pictures, or files with pictures, and what of `riot.draw` makes those."""


@pytest.mark.parametrize("stage", STAGES, ids=lambda stage: stage.name)
def test_no_result_depends_on_how_it_is_planned_or_shown(stage: Stage) -> None:
    modules = PROJECT.closure(stage.module).modules
    assert [name for name in modules if name.startswith(PLANS_AND_SHOWS)] == []
    drawn = [name for name in modules if name.startswith("riot.draw")]
    assert [name for name in drawn if not name.startswith(PAINTS.get(stage.name, ()))] == []


def test_stages_know_their_code_and_libraries() -> None:
    for stage in STAGES:
        code = code_digests(stage.module)
        assert {stage.module, f"{stage.module}:run"} <= code.keys()
        assert "pipeline.store.store" not in code
        assert not any(name.startswith("riot.parameters") for name in code.keys() - {"riot.parameters.fabrication"})
        assert "numpy" in library_versions(stage.module)
    qcrs = library_versions("pipeline.stages.qcrs")
    assert {"numba", "llvmlite"} <= qcrs.keys() and not {"dask", "hydra-core", "pyarrow"} & qcrs.keys()
    assert "riot.scores.qcrs" in code_digests("pipeline.stages.qcrs")
    assert "riot.scores.qcrs" not in code_digests("pipeline.stages.ingest")


def test_digests_of_this_project_are_the_same_without_a_cache() -> None:
    fresh = Project.read(ROOT, ["riot", "pipeline"])
    for stage in STAGES:
        assert fresh.digests(stage.module) == code_digests(stage.module)


def test_libraries_are_called_as_their_distributions() -> None:
    known = metadata.packages_distributions()
    libraries = {name for stage in STAGES for name in PROJECT.closure(stage.module).libraries}
    for library in sorted(libraries & known.keys()):
        assert known[library] == [DISTRIBUTIONS.get(library, library)]
