"""Imports inside the project: no circle of files, none inside functions, and no pictures in what makes a result.

import-linter holds the layers of packages (``make check``); these tests look at single files, also at imports that only
type checkers follow, and at names that faces offer.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from pipeline.plan.code_digest import code_digests
from pipeline.stages.all import STAGES

ROOT = Path(__file__).parents[2]
PACKAGES = ("riot", "pipeline", "studio")
LATE = ("pipeline.runtime.admission",)
"""A module with a function that is sent to other processes by itself."""

COMPUTING = [stage.name for stage in STAGES if stage.name not in ("paint", "fabricate")]
"""Stages before pictures are made."""


@dataclass(frozen=True)
class Import:
    """An import of ``target``, a module of the project or a name in one, by ``module``."""

    module: str
    target: str
    in_function: bool


@cache
def files() -> dict[str, Path]:
    modules = {}
    for package in PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            parts = path.relative_to(ROOT).with_suffix("").parts
            modules[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    # Benchmarks are scripts of one folder, which import each other by their bare names.
    return modules | {path.stem: path for path in (ROOT / "benchmarks").glob("*.py")}


@cache
def offers() -> dict[str, str]:
    """Where each name that a face offers is defined: ``riot.qcrs`` in ``riot.scores.qcrs.qcrs``."""
    targets = {}
    for face, path in files().items():
        stub = path.with_suffix(".pyi")
        if stub.name == "__init__.pyi" and stub.exists():
            for node in ast.parse(stub.read_text(encoding="utf-8")).body:
                assert isinstance(node, ast.ImportFrom)
                home = f"{face}.{node.module}" if node.module else face
                targets.update({f"{face}.{alias.name}": f"{home}.{alias.name}" for alias in node.names})
    return targets


def imports_in(node: ast.AST, *, in_function: bool = False) -> Iterator[tuple[str, bool]]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import):
            yield from ((alias.name, in_function) for alias in child.names)
        elif isinstance(child, ast.ImportFrom):
            assert child.level == 0, "modules are imported by their full names"
            yield from ((f"{child.module}.{alias.name}", in_function) for alias in child.names)
        else:
            is_function = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef)
            yield from imports_in(child, in_function=in_function or is_function)


@cache
def project_imports() -> tuple[Import, ...]:
    return tuple(
        Import(module, target, in_function)
        for module, path in files().items()
        for target, in_function in imports_in(ast.parse(path.read_text(encoding="utf-8")))
        if target.partition(".")[0] in {name.partition(".")[0] for name in files()}
    )


def module_of(name: str) -> str:
    """The module that a name is in, or is; a name that a face offers counts where it is defined."""
    while name in offers() and offers()[name] != name:
        name = offers()[name]
    while name not in files():
        name = name.rpartition(".")[0]
    return name


def test_no_files_import_each_other_in_a_circle() -> None:
    graph: dict[str, set[str]] = {module: set() for module in files()}
    for each in project_imports():
        graph[each.module] |= {module_of(each.target)} - {each.module}
    assert sum(map(len, graph.values())) > 2 * len(graph)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(f"these files import each other in a circle: {' → '.join(error.args[1])}")


def test_no_function_imports_the_project() -> None:
    inside = [each for each in project_imports() if each.in_function and each.module not in LATE]
    assert [f"{each.module} imports {each.target}" for each in inside] == []


@pytest.mark.parametrize("stage", COMPUTING)
def test_no_result_depends_on_pictures_pages_or_commands(stage: str) -> None:
    code = code_digests(f"pipeline.stages.{stage}")
    assert f"pipeline.stages.{stage}" in code
    assert [
        name for name in code if name.startswith(("riot.draw", "pipeline.report", "riot.cli", "pipeline.cli"))
    ] == []
