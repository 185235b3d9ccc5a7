"""Code digests: which of our modules a stage runs, what they say, and which libraries they stand on.

A module's digest is taken over its syntax tree without docstrings, comments and layout, so that only a change of
meaning makes a miss. The closure follows every import inside the project, also those inside functions, but not those
under ``if TYPE_CHECKING``. A package's ``__init__`` counts only when something is imported from it by name: what it
re-exports does not change what a submodule computes.

The project's own modules are taken as they were when this process began (`pipeline.plan.sources`).
"""

from __future__ import annotations

import ast
import hashlib
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from pathlib import Path

from pipeline.plan.sources import AT_START, PACKAGES, ROOT, Source, edited, read_sources

DECLARATIONS = frozenset(
    {"riot.parameters.method", "riot.parameters.motion", "riot.errors", "pipeline.errors", "pipeline.stages.specs"}
)
"""Modules that compute nothing: the values of parameters and specs enter a key by themselves, so that a new parameter
or another default of one stage leaves the other stages' keys alone."""


def code_digests(module: str, root: Path = ROOT, packages: tuple[str, ...] = PACKAGES) -> dict[str, str]:
    """Digest of every project module that ``module`` imports, directly or not, itself included."""
    sources = _sources(root, packages)
    names = _closure(module, root, packages, sources)[0]
    return {name: _facts(name, sources[name]).digest for name in names if name not in DECLARATIONS}


def edited_since_start(module: str) -> list[str]:
    """Modules that ``module`` imports, directly or not, whose files are no longer what this process began with."""
    return edited(closure(module)[0], AT_START)


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
    return _closure(module, root, packages, _sources(root, packages))


def module_digest(path: Path) -> str:
    """Digest of a module's syntax tree; docstrings, comments, layout and the Python version do not count."""
    return _facts("", Source(path, path.read_bytes())).digest


def _sources(root: Path, packages: tuple[str, ...]) -> Mapping[str, Source]:
    return AT_START if (root, packages) == (ROOT, PACKAGES) else read_sources(root, packages)


def _closure(
    module: str, root: Path, packages: tuple[str, ...], sources: Mapping[str, Source]
) -> tuple[list[str], list[str]]:
    if module not in sources:
        raise ModuleNotFoundError(f"no module {module} below {root}")
    ours: set[str] = set()
    others: set[str] = set()
    pending = [module]
    while pending:
        name = pending.pop()
        if name in ours:
            continue
        ours.add(name)
        for target in _facts(name, sources[name]).imports:
            top = target.split(".")[0]
            if top not in packages:
                others.add(top)
                continue
            found = _resolve(target, sources)
            if found is not None:
                pending.append(found)
    return sorted(ours), sorted(others)


@dataclass(frozen=True)
class _Facts:
    digest: str
    imports: tuple[str, ...]


@cache
def _facts(module: str, source: Source) -> _Facts:
    # Most modules are in the closures of most stages: each version of a file is parsed once.
    tree = ast.parse(source.content, filename=str(source.path))
    digest = hashlib.sha256(_text(tree).encode()).hexdigest()
    return _Facts(digest[:32], tuple(dict.fromkeys(_imports(module, source.path, tree))))


_MEANINGLESS = frozenset({"type_comment", "kind", "type_ignores", "ctx"})
"""Fields that say nothing; of the last, what a name is there for, its place tells."""
_DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def _text(tree: ast.Module) -> str:
    """What a syntax tree says, with no two trees of different meaning saying the same."""
    # ast.dump is slower, and differs between Python versions (fields come and go): what is absent or empty is left out.
    said: list[str] = []

    def add(node: ast.AST) -> None:
        said.append(type(node).__name__)
        for name in node._fields:
            if name in _MEANINGLESS:
                continue
            value = getattr(node, name, None)
            if isinstance(value, list):
                if name == "body" and isinstance(node, _DOCUMENTED):
                    value = _without_docstring(value)
                if value:
                    said.append(f"{name} {len(value)}")
                    for one in value:
                        if isinstance(one, ast.AST):
                            add(one)
                        else:
                            said.append(repr(one))
            elif isinstance(value, ast.AST):
                said.append(name)
                add(value)
            elif value is not None:  # as a constant's value it is meant, but no other constant is without one
                said.append(f"{name} {value!r}")
        said.append(")")

    add(tree)
    return "\0".join(said)  # no name has this character, nor has what repr says


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
        elif not isinstance(child, ast.expr):  # most of a tree, and without any import
            yield from _walk(child)


def _is_type_checking(test: ast.expr) -> bool:
    return (isinstance(test, ast.Name) and test.id == "TYPE_CHECKING") or (
        isinstance(test, ast.Attribute) and test.attr == "TYPE_CHECKING"
    )


def _resolve(target: str, sources: Mapping[str, Source]) -> str | None:
    # "riot.scores.trunks.Trunks" is a name in the module riot.scores.trunks, "riot.scores.trunks" a module.
    while target:
        if target in sources:
            return target
        target = target.rpartition(".")[0]
    return None


@cache
def _distributions() -> dict[str, list[str]]:
    return dict(metadata.packages_distributions())


@cache
def _version(distribution: str) -> str:
    return metadata.version(distribution)
