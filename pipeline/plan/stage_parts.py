"""The parts of a stage's module. A stage is one file, but only what its work reaches is its code.

A module that defines ``STAGE = Stage(…)`` is taken apart into its top-level definitions. The work of the stage begins
at the arguments ``run``, ``prepare`` and ``sub_blocks``; the rest plans the work and shows it in tables, and changes no
artifact.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from pipeline.plan.module_uses import is_type_checking, uses_of
from pipeline.plan.syntax_digest import syntax_digest

STAGE = "STAGE"
WORK = frozenset({"run", "prepare", "sub_blocks"})
"""The arguments of a stage that decide what its work is."""

REST = ""
"""The part of all statements that define nothing: they run whichever part is used."""

_LOCAL = "="
"""Stands for the module itself in front of its own names."""


@dataclass(frozen=True)
class Part:
    """A definition: the digest of its syntax, the names of other modules that it uses, other parts that it uses."""

    digest: str
    used: tuple[str, ...]
    parts: tuple[str, ...]


def stage_parts(tree: ast.Module, bindings: Mapping[str, str]) -> dict[str, Part]:
    """The parts of a stage's module by name, none of another module; ``bindings``: its names of what it imports."""
    statements: dict[str, list[ast.stmt]] = {}
    for statement in tree.body:
        for name in _names(statement):
            statements.setdefault(name, []).append(statement)
    work = [value for statement in statements.get(STAGE, ()) for value in _work(statement)]
    if not work:
        return {}
    statements[STAGE] = list(work)
    loaded = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    unused = {name for local, name in bindings.items() if local not in loaded and not name.startswith("__future__:")}
    if unused:  # such an import was made for what it does
        statements.setdefault(REST, [])
    visible = {name: f"{_LOCAL}:{name}" for name in statements} | dict(bindings)
    parts: dict[str, Part] = {}
    for name, body in statements.items():
        used = {target for statement in body for target in uses_of(statement, visible)}
        local = {target.partition(":")[2].partition(".")[0] for target in used if target.startswith(_LOCAL)}
        others = {target for target in used if not target.startswith(_LOCAL)}
        if name == REST:
            others |= unused
        digest = syntax_digest(ast.Module(body=body, type_ignores=[]))
        parts[name] = Part(
            digest, tuple(sorted(others)), tuple(sorted((local | ({REST} & statements.keys())) - {name}))
        )
    return parts


def _names(statement: ast.stmt) -> Iterator[str]:
    """The names that a top-level statement defines; `REST` where it defines none and is no import."""
    match statement:
        case ast.FunctionDef() | ast.AsyncFunctionDef() | ast.ClassDef():
            yield statement.name
        case ast.Assign():
            names = [node.id for target in statement.targets for node in ast.walk(target) if isinstance(node, ast.Name)]
            yield from names or [REST]
        case ast.AnnAssign(target=ast.Name(id=name)) | ast.AugAssign(target=ast.Name(id=name)):
            yield name
        case ast.Import() | ast.ImportFrom() | ast.Expr(value=ast.Constant()):
            pass
        case ast.If(test=test, orelse=[]) if is_type_checking(test):
            pass
        case _:
            yield REST


def _work(statement: ast.stmt) -> Iterator[ast.stmt]:
    """The work of ``STAGE = Stage(…)`` as expressions; of a call only its arguments."""
    if isinstance(statement, ast.Assign | ast.AnnAssign) and isinstance(statement.value, ast.Call):
        for keyword in statement.value.keywords:
            if keyword.arg in WORK:
                value = keyword.value
                values = [*value.args, *(k.value for k in value.keywords)] if isinstance(value, ast.Call) else [value]
                yield from (ast.Expr(value) for value in values)
