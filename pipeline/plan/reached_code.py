"""The part of a module that some of its names reach: a stage's file also plans its work, which is not in its digest."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator

MARK = b"\nSTAGE = Stage("
"""What a module that defines a stage has, and no other."""


def is_stage(content: bytes) -> bool:
    """Whether a module defines a stage."""
    return MARK in content


def reached_code(content: bytes, names: Iterable[str]) -> bytes:
    """The statements of a module that ``names`` reach, in their order; names that it lacks reach nothing.

    Of an import those names stay that are reached. Statements that are no definitions, such as calls, all stay.

    >>> module = b"from math import e, pi\\nA = pi\\ndef run(): return A\\ndef plan(): return e\\n"
    >>> reached_code(module, ["run"]).decode()
    'from math import pi\\nA = pi\\n\\ndef run():\\n    return A'
    """
    statements = [statement for statement in ast.parse(content).body if not _is_for_types(statement)]
    defining: dict[str, list[ast.stmt]] = {}
    for statement in statements:
        for name in _defined(statement):
            defining.setdefault(name, []).append(statement)
    always = [statement for statement in statements if not any(_defined(statement)) and not _is_docstring(statement)]
    reached: set[str] = set()
    pending = [*names, *(name for statement in always for name in _loaded(statement))]
    while pending:
        name = pending.pop()
        if name not in reached and name in defining:
            reached.add(name)
            pending += [loaded for statement in defining[name] for loaded in _loaded(statement)]
    kept = [part for statement in statements if (part := _reached_part(statement, reached, always)) is not None]
    return ast.unparse(ast.Module(kept, type_ignores=[])).encode()


def _reached_part(statement: ast.stmt, reached: set[str], always: list[ast.stmt]) -> ast.stmt | None:
    if statement in always:
        return statement
    if isinstance(statement, ast.Import):
        names = [alias for alias in statement.names if _bound(alias) in reached]
        return ast.Import(names) if names else None
    if isinstance(statement, ast.ImportFrom) and statement.module != "__future__":
        names = [alias for alias in statement.names if _bound(alias) in reached]
        return ast.ImportFrom(statement.module, names, statement.level) if names else None
    return statement if reached.intersection(_defined(statement)) else None


def _defined(statement: ast.stmt) -> Iterator[str]:
    match statement:
        case ast.FunctionDef() | ast.AsyncFunctionDef() | ast.ClassDef():
            yield statement.name
        case ast.Import() | ast.ImportFrom():
            yield from map(_bound, statement.names)
        case ast.Assign() | ast.AnnAssign():
            yield from (node.id for node in ast.walk(statement) if isinstance(node, ast.Name) and _is_stored(node))


def _loaded(statement: ast.stmt) -> Iterator[str]:
    return (node.id for node in ast.walk(statement) if isinstance(node, ast.Name))


def _is_stored(node: ast.Name) -> bool:
    return isinstance(node.ctx, ast.Store)


def _bound(alias: ast.alias) -> str:
    return alias.asname or alias.name.partition(".")[0]


def _is_docstring(statement: ast.stmt) -> bool:
    return (
        isinstance(statement, ast.Expr)
        and isinstance(statement.value, ast.Constant)
        and isinstance(statement.value.value, str)
    )


def _is_for_types(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.If) and ast.unparse(statement.test) in ("TYPE_CHECKING", "typing.TYPE_CHECKING")
