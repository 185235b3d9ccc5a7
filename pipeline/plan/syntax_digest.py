"""The digest of a module's syntax tree: docstrings, comments, layout and the Python version do not count."""

from __future__ import annotations

import ast
import hashlib

_MEANINGLESS = frozenset({"type_comment", "kind", "type_ignores", "ctx"})
"""Fields without meaning of their own: the position of a name, for example, already tells its context."""
_DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def syntax_digest(tree: ast.Module) -> str:
    """The first 32 hexadecimal digits of the SHA-256 of a tree.

    >>> first, second = ast.parse("x = 1  # one"), ast.parse("'''About x.'''\\nx = (1)")
    >>> syntax_digest(first) == syntax_digest(second)
    True
    """
    return hashlib.sha256(_text(tree).encode()).hexdigest()[:32]


def _text(tree: ast.Module) -> str:
    """A text of the tree; trees of different meaning have different texts."""
    # ast.dump is slower and differs between Python versions, which add and drop fields: empty fields are left out here.
    words: list[str] = []

    def add(node: ast.AST) -> None:
        words.append(type(node).__name__)
        for name in node._fields:
            if name in _MEANINGLESS:
                continue
            value = getattr(node, name, None)
            if isinstance(value, list):
                if name == "body" and isinstance(node, _DOCUMENTED):
                    value = _without_docstrings(value)
                if value:
                    words.append(f"{name} {len(value)}")
                    for child in value:
                        if isinstance(child, ast.AST):
                            add(child)
                        else:
                            words.append(repr(child))
            elif isinstance(value, ast.AST):
                words.append(name)
                add(value)
            elif value is not None:  # the constant None is the one constant without a value
                words.append(f"{name} {value!r}")
        words.append(")")

    add(tree)
    return "\0".join(words)  # neither a name nor a repr has this character


def _without_docstrings(body: list[ast.stmt]) -> list[ast.stmt]:
    # Every bare string is documentation: of the module, class or function, or of the field above it.
    return [
        statement
        for statement in body
        if not (
            isinstance(statement, ast.Expr)
            and isinstance(statement.value, ast.Constant)
            and isinstance(statement.value.value, str)
        )
    ]
