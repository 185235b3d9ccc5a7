"""Code digests: a change of meaning changes them, a change of words does not."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.plan.code_digest import closure, code_digests, library_versions, module_digest
from pipeline.stages.registry import STAGES

SOURCE = '''"""About the module."""
import numpy as np

LIMIT = 3
"""What it is."""

def area(x: float) -> float:
    """About the function."""
    # a comment
    return x * LIMIT
'''


def digest(tmp_path: Path, text: str) -> str:
    file = tmp_path / "module.py"
    file.write_text(text)
    return module_digest(file)


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
def test_words_and_layout_do_not_count(tmp_path: Path, old: str, new: str) -> None:
    assert old in SOURCE
    assert digest(tmp_path, SOURCE.replace(old, new)) == digest(tmp_path, SOURCE)


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
def test_meaning_counts(tmp_path: Path, old: str, new: str) -> None:
    assert digest(tmp_path, SOURCE.replace(old, new)) != digest(tmp_path, SOURCE)


@pytest.fixture
def project(tmp_path: Path) -> Path:
    files = {
        "ours/__init__.py": "from ours.other import everything",
        "ours/start.py": "import json\nfrom ours import late\nfrom ours.sub.deep import f\nimport numpy.linalg",
        "ours/late.py": "def g():\n    from .hidden import h\n    return h",
        "ours/hidden.py": "h = 1",
        "ours/other.py": "everything = 1",
        "ours/sub/__init__.py": "",
        "ours/sub/deep.py": (
            "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from ours.typing_only import T\nf = 1"
        ),
        "ours/typing_only.py": "T = int",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def test_the_closure_follows_what_runs(project: Path) -> None:
    ours, others = closure("ours.start", project, ("ours",))
    assert ours == ["ours.hidden", "ours.late", "ours.start", "ours.sub.deep"]
    assert {"json", "numpy"} <= set(others) and "ours" not in others


def test_an_edit_changes_only_the_digests_of_those_who_run_it(project: Path) -> None:
    before = code_digests("ours.start", project, ("ours",))
    (project / "ours/hidden.py").write_text("h = 2  # edited")
    after = code_digests("ours.start", project, ("ours",))
    assert {name for name in before if before[name] != after[name]} == {"ours.hidden"}
    (project / "ours/typing_only.py").write_text("T = str")
    assert code_digests("ours.start", project, ("ours",)) == after


def test_a_missing_module_is_an_error(project: Path) -> None:
    with pytest.raises(ModuleNotFoundError):
        closure("ours.nowhere", project, ("ours",))


def test_stages_know_their_code_and_libraries() -> None:
    for stage in STAGES:
        code = code_digests(stage.module)
        assert stage.module in code
        assert (
            "pipeline.store.store" not in code
            and "pipeline.config.schema" not in code
            and "pipeline.runtime.cluster" not in code
        )
        assert "riot.parameters.method" not in code
        assert "numpy" in library_versions(stage.module)
    qcrs = library_versions("pipeline.stages.qcrs")
    assert {"numba", "llvmlite"} <= qcrs.keys() and not {"dask", "hydra-core", "pyarrow"} & qcrs.keys()
    assert "riot.scores.qcrs" in code_digests("pipeline.stages.qcrs")
    assert "riot.scores.qcrs" not in code_digests("pipeline.stages.ingest")
