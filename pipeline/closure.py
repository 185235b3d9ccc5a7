"""Code digests: which of our modules a stage runs, what they say, and which libraries they stand on.

A module's digest is taken over its syntax tree without docstrings, comments and layout, so that only a change of
meaning makes a miss. The closure follows every import inside the project, also those inside functions, but not those
under ``if TYPE_CHECKING``. A package's ``__init__`` counts only when something is imported from it by name: what it
re-exports does not change what a submodule computes.
"""

from __future__ import annotations

import ast
import hashlib
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("riot", "pipeline")

DECLARATIONS = frozenset({"riot.parameters", "riot.motion.parameters", "riot.errors", "pipeline.errors"})
"""Modules that compute nothing: the values of parameters enter a key by themselves, so that a new parameter or another
default of one stage leaves the other stages' keys alone."""


def code_digests(module: str, root: Path = ROOT, packages: tuple[str, ...] = PACKAGES) -> dict[str, str]:
    """Digest of every project module that ``module`` imports, directly or not, itself included."""
    names = closure(module, root, packages)[0]
    paths = {name: _path(name, root) for name in names if name not in DECLARATIONS}
    return {name: _facts(name, path).digest for name, path in paths.items() if path is not None}


def library_versions(module: str, root: Path = ROOT, packages: tuple[str, ...] = PACKAGES) -> dict[str, str]:
    """Version of every installed distribution that the closure of ``module`` imports."""
    tops = set(closure(module, root, packages)[1])
    if "numba" in tops:
        tops.add("llvmlite")  # numba leaves code generation to it
    return {
        name: _version(name)
        for top in sorted(tops - set(sys.stdlib_module_names))
        for name in sorted(set(_distributions().get(top, ())))
    }


def closure(module: str, root: Path = ROOT, packages: tuple[str, ...] = PACKAGES) -> tuple[list[str], list[str]]:
    """Project modules, and top-level names of other packages, that ``module`` imports directly or not (sorted).

    Raises ModuleNotFoundError when ``module`` itself is not in the project.
    """
    if _path(module, root) is None:
        raise ModuleNotFoundError(f"no module {module} below {root}")
    ours: set[str] = set()
    others: set[str] = set()
    pending = [module]
    while pending:
        name = pending.pop()
        if name in ours:
            continue
        ours.add(name)
        path = _path(name, root)
        assert path is not None  # only names that have a file are put on the list
        for target in _facts(name, path).imports:
            top = target.split(".")[0]
            if top not in packages:
                others.add(top)
                continue
            found = _resolve(target, root)
            if found is not None:
                pending.append(found)
    return sorted(ours), sorted(others)


def module_digest(path: Path) -> str:
    """Digest of a module's syntax tree; docstrings, comments, layout and the Python version do not count."""
    return _facts("", path).digest


@dataclass(frozen=True)
class _Facts:
    digest: str
    imports: tuple[str, ...]


def _facts(module: str, path: Path) -> _Facts:
    stat = path.stat()
    return _facts_of_version(module, path, stat.st_mtime_ns, stat.st_size)


@cache
def _facts_of_version(module: str, path: Path, _modified: int, _size: int) -> _Facts:
    # Most modules are in the closures of most stages: each version of a file is parsed once.
    tree = ast.parse(path.read_bytes(), filename=str(path))
    state = hashlib.sha256()
    _feed(tree, state)
    return _Facts(state.hexdigest()[:32], tuple(dict.fromkeys(_imports(module, path, tree))))


def _feed(node: object, state: hashlib._Hash) -> None:
    # ast.dump differs between Python versions (fields come and go); absent and empty fields are left out here.
    if isinstance(node, ast.AST):
        state.update(b"(" + type(node).__name__.encode())
        for name, value in ast.iter_fields(node):
            if name in ("type_comment", "kind", "type_ignores"):
                continue
            if name == "body" and isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                value = _without_docstring(value)
            absent = value is None or value == []
            if absent and not (isinstance(node, ast.Constant) and name == "value"):
                continue
            state.update(b"," + name.encode() + b"=")
            _feed(value, state)
        state.update(b")")
    elif isinstance(node, list):
        state.update(b"[")
        for item in node:
            _feed(item, state)
            state.update(b";")
        state.update(b"]")
    else:
        text = f"{type(node).__name__}:{node!r}".encode()
        state.update(len(text).to_bytes(8, "little") + text)


def _without_docstring(body: list[ast.stmt]) -> list[ast.stmt]:
    # Every bare string statement is documentation: of the module, class, function, or of the field above it.
    return [
        statement
        for statement in body
        if not (
            isinstance(statement, ast.Expr)
            and isinstance(statement.value, ast.Constant)
            and isinstance(statement.value.value, str)
        )
    ]


def _imports(module: str, path: Path, tree: ast.Module) -> Iterator[str]:
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    for node in _walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parents = package.split(".")
                parents = parents[: len(parents) - (node.level - 1)]
                base = ".".join([*parents, base] if base else parents)
            yield from (f"{base}.{alias.name}" for alias in node.names)


def _walk(node: ast.AST) -> Iterator[ast.AST]:
    yield node
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.If) and _is_type_checking(child.test):
            for statement in child.orelse:
                yield from _walk(statement)
        else:
            yield from _walk(child)


def _is_type_checking(test: ast.expr) -> bool:
    return (isinstance(test, ast.Name) and test.id == "TYPE_CHECKING") or (
        isinstance(test, ast.Attribute) and test.attr == "TYPE_CHECKING"
    )


def _path(module: str, root: Path) -> Path | None:
    base = root.joinpath(*module.split("."))
    for candidate in (base / "__init__.py", base.with_suffix(".py")):
        if candidate.is_file():
            return candidate
    return None


def _resolve(target: str, root: Path) -> str | None:
    # "riot.trunks.Trunks" is a name in the module riot.trunks; "riot.trunks" a module of the package riot.
    while target:
        if _path(target, root) is not None:
            return target
        target = target.rpartition(".")[0]
    return None


@cache
def _distributions() -> dict[str, list[str]]:
    return dict(metadata.packages_distributions())


@cache
def _version(distribution: str) -> str:
    return metadata.version(distribution)
