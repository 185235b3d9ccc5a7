"""How kernels get compiled: only those that are used and missing, in the order of need, wherever they can be kept."""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import riot
from pipeline.plan.code_digest import PROJECT
from pipeline.runtime.stage_kernels import in_order, stage_kernels
from pipeline.stages.all import STAGES
from riot.kernels.compiling.compilation import longest_first
from riot.kernels.compiling.uses import kernel_modules, kernels_used_by

ROOT = Path(riot.__file__).parents[1]
LIBRARY = sorted(
    ".".join(path.relative_to(ROOT).with_suffix("").parts)
    for path in (ROOT / "riot").rglob("*.py")
    if path.name != "__init__.py"
)

SMALL = "enumerate"
"""A small module."""

COMPILE = f"""
import sys
from riot.kernels.compiling.cache import cache_folder, uncompiled
from riot.kernels.warm import compile_used
compile_used(lambda text: print("says", text), "riot.kernels.{SMALL}")
print("loaded", "numba" in sys.modules)
from riot.kernels.{SMALL} import warm, enumerate_convex
warm()
print("folders", cache_folder(), enumerate_convex.stats.cache_path)
print("compiled", sum(enumerate_convex.stats.cache_misses.values()), uncompiled(["{SMALL}"]))
"""


class Copy:
    """A copy of the library, whose files a test may change."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.kernels = folder / "riot" / "kernels"
        self.environment = {**os.environ, "PYTHONPATH": str(folder), "NUMBA_CACHE_DIR": str(folder / "cache")}
        shutil.copytree(ROOT / "riot", folder / "riot", ignore=shutil.ignore_patterns("__pycache__"))

    def run(self, code: str = COMPILE) -> dict[str, list[str]]:
        """What a process prints that uses the copy, by the first word of a line; it complains of nothing."""
        done = subprocess.run(
            [sys.executable, "-P", "-c", code], env=self.environment, capture_output=True, text=True, check=True
        )
        assert done.stderr == ""
        printed: dict[str, list[str]] = {}
        for line in done.stdout.splitlines():
            printed.setdefault(line.partition(" ")[0], []).append(line.partition(" ")[2])
        return printed

    def edit(self, name: str) -> None:
        path = self.kernels / f"{name}.py"
        path.write_text(path.read_text(encoding="utf-8") + "\n# edited\n", encoding="utf-8")


@pytest.fixture
def copy(tmp_path: Path) -> Copy:
    return Copy(tmp_path)


def test_import_lines_tell_which_kernels_a_module_uses() -> None:
    kernels = {f"riot.kernels.{name}": name for name in kernel_modules()}
    closures = {module: PROJECT.closure(module).modules for module in LIBRARY}
    assert {module: kernels_used_by(module) for module in LIBRARY} == {
        module: [kernels[name] for name in reached if name in kernels] for module, reached in closures.items()
    }


def test_the_modules_with_kernels_are_those_that_can_be_warmed() -> None:
    assert all(callable(importlib.import_module(f"riot.kernels.{name}").warm) for name in kernel_modules())


def test_stages_get_their_kernels_in_the_order_of_a_run() -> None:
    ordered = in_order(STAGES, kernel_modules())
    assert len(set(ordered)) == len(ordered)
    first_needed = {name: next(k for k, stage in enumerate(STAGES) if name in stage_kernels(stage)) for name in ordered}
    assert [first_needed[name] for name in ordered] == sorted(first_needed.values())
    assert set(ordered) == {name for stage in STAGES for name in stage_kernels(stage)}
    assert in_order(STAGES, ordered[:2]) == ordered[:2] and in_order(STAGES[:1], ordered) == stage_kernels(STAGES[0])


def test_long_modules_are_compiled_first() -> None:
    sizes = [(ROOT / "riot" / "kernels" / f"{name}.py").stat().st_size for name in longest_first(kernel_modules())]
    assert sizes == sorted(sizes, reverse=True)


def test_kernels_are_compiled_once_until_their_code_changes(copy: Copy) -> None:
    printed = copy.run()
    assert printed["says"][0] == "compiling kernels for this machine, once: 0 of 1 modules"
    assert printed["says"][-1].startswith("kernels compiled in ")
    assert printed["compiled"] == ["0 []"] and printed["loaded"] == ["False"]
    again = copy.run()
    assert "says" not in again and again["compiled"] == ["0 []"] and again["loaded"] == ["False"]
    copy.edit("simplify")
    assert "says" not in copy.run()
    copy.edit(SMALL)
    assert copy.run()["says"][0] == printed["says"][0]
    assert "says" not in copy.run()


@pytest.mark.system
@pytest.mark.parametrize("change", ["options", "bounds", "index"])
def test_kernels_are_compiled_again_when_what_they_share_changes_or_they_are_gone(copy: Copy, change: str) -> None:
    copy.run()
    if change != "index":
        copy.edit(change)
    else:
        next((copy.folder / "cache").rglob("*.nbi")).unlink()
    assert len(copy.run()["says"]) >= 2
    assert "says" not in copy.run()


@pytest.mark.system
def test_kernels_stand_beside_their_modules_or_else_in_the_cache_folder_of_the_user(copy: Copy) -> None:
    del copy.environment["NUMBA_CACHE_DIR"]
    copy.environment["XDG_CACHE_HOME"] = str(copy.folder / "home")
    beside, numbas = copy.run()["folders"][0].split(" ")
    assert beside == numbas == str(copy.kernels / "__pycache__")
    shutil.rmtree(beside)
    (copy.kernels / "__pycache__").touch()  # also root cannot write there
    printed = copy.run()
    of_user, numbas = printed["folders"][0].split(" ")
    assert of_user == numbas and Path(of_user).is_relative_to(copy.folder / "home")
    assert printed["compiled"] == ["0 []"]
    (copy.folder / "other").touch()
    copy.environment["XDG_CACHE_HOME"] = str(copy.folder / "other")
    printed = copy.run()
    assert printed["folders"] == ["None None"]
    (message,) = printed["says"]
    assert "cannot be kept" in message and "NUMBA_CACHE_DIR=DIR" in message
    assert printed["compiled"] == [f"1 ['{SMALL}']"]


@pytest.mark.system
@pytest.mark.parametrize("pattern", ["*.nbi", "*.nbc"])
def test_a_damaged_kernel_is_compiled_again(copy: Copy, pattern: str) -> None:
    copy.run()
    for path in (copy.folder / "cache").rglob(pattern):
        path.write_bytes(b"damaged")
    assert copy.run()["compiled"] == ["1 []"]
    assert copy.run()["compiled"] == ["0 []"]
