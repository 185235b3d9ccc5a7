"""What the code digests need of a file, and a cache of it: a file is parsed again only when its bytes are new.

The cache is one file in the ``__pycache__`` folder beside this module, or in the user's cache folder where Python may
not write there. Like compiled code it is derived from the sources: no digest depends on it, a damaged or foreign
cache is ignored, and it may be removed at any time.
"""

from __future__ import annotations

import ast
import contextlib
import hashlib
import importlib.util
import json
import os
import sys
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from pipeline.plan.module_uses import module_uses
from pipeline.plan.sources import AT_START, ROOT
from pipeline.plan.stage_parts import Part, stage_parts
from pipeline.plan.syntax_digest import syntax_digest
from riot.errors import needs_extra

_RULES = ("module_facts", "module_uses", "stage_parts", "syntax_digest")
"""The modules of this package that facts depend on."""


@dataclass(frozen=True)
class ModuleFacts:
    """What a file says; names are written as in `pipeline.plan.module_uses`, those of other projects left out."""

    digest: str
    imported: tuple[str, ...]
    used: tuple[str, ...]
    bindings: Mapping[str, str]
    libraries: tuple[str, ...]
    """Top-level names of the other packages that it imports."""
    attaches_stub: bool
    """Whether it calls ``lazy_loader.attach_stub``, so that its stub tells which names it offers."""
    parts: Mapping[str, Part]
    """Of a stage's module its definitions, with all names that they use; see `pipeline.plan.stage_parts`."""


def read_facts(content: bytes, packages: Iterable[str]) -> ModuleFacts:
    """The facts of a file in a project of these packages. Raises SyntaxError."""
    tree = ast.parse(content)
    uses = module_uses(tree)

    def ours(name: str) -> bool:
        return name.startswith(".") or _top(name) in packages

    return ModuleFacts(
        digest=syntax_digest(tree),
        imported=tuple(sorted(filter(ours, uses.imported))),
        used=tuple(sorted(filter(ours, uses.used))),
        bindings={local: name for local, name in sorted(uses.bindings.items()) if ours(name)},
        libraries=tuple(sorted({_top(name) for name in uses.imported if not ours(name)})),
        attaches_stub="lazy_loader:attach_stub" in uses.used,
        parts=stage_parts(tree, uses.bindings),
    )


class FactsCache:
    """Facts by the SHA-256 of a file's bytes, kept in memory, and for later processes in ``file``."""

    def __init__(self, packages: Iterable[str], file: Path | None = None) -> None:
        self._packages, self._file = tuple(packages), file
        self._facts: dict[str, ModuleFacts] | None = None
        self._is_new = False

    def facts(self, content: bytes) -> ModuleFacts:
        """See `read_facts`."""
        if self._facts is None:
            self._facts = self._load()
        name = hashlib.sha256(content).hexdigest()
        if name not in self._facts:
            self._facts[name] = read_facts(content, self._packages)
            self._is_new = True
        return self._facts[name]

    def save(self, contents: Iterable[bytes]) -> None:
        """Keep the facts of these files for later processes, if any is new; another writer's file is replaced whole."""
        if self._file is None or not self._facts or not self._is_new:
            return
        self._is_new = False
        names = {hashlib.sha256(content).hexdigest() for content in contents}
        facts = {name: asdict(facts) for name, facts in self._facts.items() if name in names}
        body = json.dumps([_version(), self._packages, facts]).encode()
        with contextlib.suppress(OSError):
            _replace(self._file, hashlib.sha256(body).hexdigest().encode() + b"\n" + body)

    def _load(self) -> dict[str, ModuleFacts]:
        with contextlib.suppress(OSError, ValueError, TypeError):  # whatever is wrong with it, it is only a cache
            digest, _, body = self._file.read_bytes().partition(b"\n") if self._file else (b"", b"", b"")
            if hashlib.sha256(body).hexdigest().encode() == digest:
                version, packages, facts = json.loads(body)
                if version == _version() and tuple(packages) == self._packages:
                    return {name: _read(values) for name, values in facts.items()}
        return {}


def cache_file() -> Path:
    """Where the cache is: beside the sources, or in the user's cache folder where Python may not write there."""
    beside = Path(importlib.util.cache_from_source(__file__)).with_suffix(".json")
    nearest = next(folder for folder in beside.parents if folder.is_dir())
    if os.access(nearest, os.W_OK) and not sys.dont_write_bytecode:
        return beside
    with needs_extra("mine"):
        import platformdirs

    installation = hashlib.sha256(os.fsencode(ROOT)).hexdigest()[:16]
    return Path(platformdirs.user_cache_dir("riot-shapes"), f"code-{installation}.json")


def _read(values: dict[str, Any]) -> ModuleFacts:
    parts = {name: Part(**part) for name, part in values["parts"].items()}
    return ModuleFacts(**{**values, "parts": parts})


def _version() -> str:
    """What facts depend on beside the file: the rules of this package and Python's grammar."""
    rules = b"".join(AT_START[f"pipeline.plan.{module}"].content for module in _RULES)
    return f"{hashlib.sha256(rules).hexdigest()} {sys.version_info.major}.{sys.version_info.minor}"


def _replace(file: Path, data: bytes) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    temporary = file.with_name(f"{file.name}.{os.urandom(8).hex()}")
    try:
        temporary.write_bytes(data)
        temporary.replace(file)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise


def _top(name: str) -> str:
    return name.partition(":")[0].partition(".")[0]
