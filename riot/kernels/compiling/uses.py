"""Which modules of kernels a module of the project uses, directly or not: read from the import lines of the sources.

An import that counts stands at the beginning of a line: those under ``if TYPE_CHECKING`` are indented, and functions
import nothing of the project (tests/unit/test_layers.py). To import a face, a package with a stub, loads nothing: what
counts is which of its names are used. Ours.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[3]
KERNELS = "riot.kernels."

_IMPORT = re.compile(r"^from ([\w.]+) import (\([^)]*\)|[^\n]+)|^import ([\w.]+)", re.MULTILINE)
_NAME = re.compile(r"(\w+)(?: as (\w+))?")
_COMMENT = re.compile(r"#.*")


def kernels_used_by(*modules: str) -> list[str]:
    """The modules of `riot.kernels` that ``modules`` use, sorted, such as ``search``; each by its full name.

    >>> kernels_used_by("riot.geometry.polyline")
    ['simplify']
    """
    pending, reached = list(modules), set(modules)
    while pending:
        for name in _imported(pending.pop()) - reached:
            reached.add(name)
            pending.append(name)
    names = {name.removeprefix(KERNELS) for name in reached if name.startswith(KERNELS)}
    return sorted(name for name in names if has_kernels(name))


def kernel_modules() -> list[str]:
    """The names of all modules of kernels."""
    folder = Path(__file__).parents[1]
    return sorted(path.stem for path in folder.glob("*.py") if has_kernels(path.stem))


def has_kernels(name: str) -> bool:
    """Whether a module of `riot.kernels` has kernels: a function ``warm`` compiles them."""
    return "\ndef warm() -> None:" in (_source(KERNELS + name) or "")


@cache
def _imported(module: str) -> set[str]:
    """The modules of the project that a module loads, or uses through a face."""
    text = _source(module)
    if text is None:
        return set()
    imported = set(_parents(module))
    for match in _IMPORT.finditer(text):
        origin, names, alone = match.groups()
        if alone:
            imported |= {alone, *_parents(alone)}
            continue
        imported |= {origin, *_parents(origin)}
        for name, alias in _NAME.findall(_COMMENT.sub("", names)):
            if _stub(f"{origin}.{name}") is not None:  # a face: what the code takes from it
                uses = re.findall(rf"(?<![\w.]){alias or name}((?:\.\w+)+)", text)
                imported |= {target for use in set(uses) for target in _targets(f"{origin}.{name}{use}")}
            else:
                imported |= set(_targets(f"{origin}.{name}"))
    return {name for name in imported if _source(name) is not None}


def _targets(name: str) -> Iterator[str]:
    """The modules that a dotted name leads through."""
    top, _, rest = name.partition(".")
    while rest:
        first, _, rest = rest.partition(".")
        stub = _stub(top)
        home = None if stub is None else re.search(rf"^from \.([\w.]+) import .*\b{first}\b", stub, re.MULTILINE)
        if home is not None:
            yield f"{top}.{home[1]}"
            return
        top = f"{top}.{first}"
        if _source(top) is None:
            return
        yield top


def _parents(module: str) -> Iterator[str]:
    while "." in module:
        module = module.rpartition(".")[0]
        yield module


@cache
def _source(module: str) -> str | None:
    """The text of a module or of a package's ``__init__``; None of what is not in the project."""
    path = ROOT.joinpath(*module.split("."))
    for file in (path / "__init__.py", path.with_name(f"{path.name}.py")):
        try:
            return file.read_text(encoding="utf-8")
        except OSError:
            continue
    return None


@cache
def _stub(package: str) -> str | None:
    try:
        return ROOT.joinpath(*package.split("."), "__init__.pyi").read_text(encoding="utf-8")
    except OSError:
        return None
