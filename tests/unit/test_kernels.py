"""Rules that every compiled kernel keeps."""

from __future__ import annotations

import ast
import importlib
import inspect
from pathlib import Path

import pytest

import riot.kernels
from riot.kernels.compiling.cache import SHARED
from riot.kernels.compiling.uses import kernel_modules
from riot.kernels.warm import warm_all

MODULES = kernel_modules()


@pytest.mark.parametrize("name", MODULES)
def test_kernel_modules_call_only_what_renews_all_kernels(name: str) -> None:
    # Numba's cache of a kernel is renewed when its own file changes, or one of `SHARED`.
    tree = ast.parse((Path(riot.kernels.__path__[0]) / f"{name}.py").read_text(encoding="utf-8"))
    imported = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    kernels = {module for module in imported if module and module.startswith("riot.kernels")}
    assert "riot.kernels.options" in kernels
    assert {f"{module.removeprefix('riot.kernels.')}.py" for module in kernels} <= set(SHARED)


@pytest.mark.parametrize(("name", "modules"), [("_sort", ("congruency", "segments", "visibility"))])
def test_a_helper_that_stands_in_several_modules_is_the_same_in_each(name: str, modules: tuple[str, ...]) -> None:
    helpers = [getattr(importlib.import_module(f"riot.kernels.{module}"), name) for module in modules]
    assert len({inspect.getsource(helper.py_func) for helper in helpers}) == 1


def called_kernels() -> list[tuple[str, str]]:
    """(module, name) of every kernel that the library calls from outside the kernels."""
    root = Path(riot.kernels.__path__[0])
    called = set()
    for path in root.parent.rglob("*.py"):
        if path.parent == root:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("riot.kernels."):
                module = importlib.import_module(str(node.module))
                names = {alias.name for alias in node.names}
                called |= {(module.__name__, name) for name in names if hasattr(getattr(module, name), "py_func")}
    return sorted(called)


@pytest.mark.parametrize(("module", "name"), called_kernels())
def test_every_kernel_is_compiled_before_it_is_needed(module: str, name: str) -> None:
    imported = importlib.import_module(module)
    called = getattr(imported, name)
    imported.warm()
    assert called.signatures


def test_cached_kernels_are_ready_without_a_message() -> None:
    warm_all(lambda text: None)
    messages: list[str] = []
    warm_all(messages.append)
    assert messages == []
