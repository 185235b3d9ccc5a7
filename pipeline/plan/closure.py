"""The closure of a module: which modules of the project it imports, directly or not, and what their digests are.

A package may be a *face*: ``lazy_loader.attach_stub`` offers the names in its ``__init__.pyi``. Of a face the closure
holds what is used: for ``from riot import scores`` and ``scores.crs.best_trunk_pairs(…)`` that is the module
``riot.scores.crs``. A face that is used in any other way than by attribute counts with everything that it offers. The
``__init__`` of a package counts only when something is taken from it that is neither a module nor in its stub.

Of a stage's module the closure holds only the definitions that are used, as ``pipeline.stages.qcrs:prepare``, each with
a digest of its own (`pipeline.plan.stage_parts`): a stage is one file, and how it is planned and shown changes no
artifact.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pipeline.plan.module_facts import FactsCache, ModuleFacts
from pipeline.plan.sources import Source, read_sources
from pipeline.plan.stage_parts import STAGE, Part

ERRORS = frozenset({"riot.errors", "pipeline.errors"})

COMPUTING_PARAMETERS = frozenset({"riot.parameters.fabrication"})
"""Modules of parameters that derive sizes from them."""


def is_declaration(module: str) -> bool:
    """Whether a module computes nothing: the values of parameters enter a key by themselves.

    A new parameter, or another default of one stage, therefore leaves the keys of the other stages alone.
    """
    return module in ERRORS or (module.startswith("riot.parameters.") and module not in COMPUTING_PARAMETERS)


@dataclass(frozen=True)
class Closure:
    """All that a module imports, directly or not; every part is sorted.

    A stage's module is there by the definitions that are used of it, and by its own name for which these are. ``leads``
    tells for each module which names it takes from faces and where they lead: ``riot:qcrs=riot.…``.
    """

    modules: tuple[str, ...]
    libraries: tuple[str, ...]
    leads: Mapping[str, tuple[str, ...]]

    @property
    def files(self) -> list[str]:
        """The modules whose files decide what the code does: also the faces, whose stubs do."""
        faces = {lead.partition(":")[0] for leads in self.leads.values() for lead in leads}
        return sorted({name.partition(":")[0] for name in self.modules} | faces)


class Project:
    """Packages of modules that import each other, as their files were when they were read."""

    def __init__(self, sources: Mapping[str, Source], cache: FactsCache) -> None:
        """``cache`` keeps what was parsed; no digest depends on it."""
        self._sources = dict(sources)
        self._cache = cache
        self._facts_of: dict[str, ModuleFacts] = {}
        self._taken_by: dict[str, _Taken] = {}
        self._offered_by: dict[str, Mapping[str, str]] = {}
        self._closures: dict[str, Closure] = {}

    @classmethod
    def read(cls, root: Path, packages: Sequence[str], cache: Path | None = None) -> Project:
        """The project of these packages below ``root``, as its files are now; ``cache``: a file for what was parsed."""
        return cls(read_sources(root, packages), FactsCache(packages, cache))

    def closure(self, module: str) -> Closure:
        """What a module imports. Raises ModuleNotFoundError when it is not in the project."""
        if module not in self._sources:
            raise ModuleNotFoundError(f"no module {module} in the project")
        if module not in self._closures:
            self._closures[module] = self._follow(module)
            self._cache.save(content for source in self._sources.values() for content in _contents(source))
        return self._closures[module]

    def digests(self, module: str) -> dict[str, str]:
        """The digest of each module that ``module`` imports: of its code, and of where the names of faces lead."""
        closure = self.closure(module)
        return {
            name: _join(part.digest if (part := self._part(name)) else self._facts(name).digest, closure.leads[name])
            for name in closure.modules
            if not is_declaration(name)
        }

    def file_digest(self, module: str) -> str:
        """The digest of all of a module's code, whatever it imports."""
        return self._facts(module).digest

    def _follow(self, start: str) -> Closure:
        leads: dict[str, tuple[str, ...]] = {}
        libraries: set[str] = set()
        pending = [start]
        while pending:
            module = pending.pop()
            if module not in leads:
                taken = self._taken(module)
                leads[module] = taken.leads
                libraries.update(taken.libraries)
                pending += taken.modules
        return Closure(tuple(sorted(leads)), tuple(sorted(libraries)), leads)

    def _facts(self, module: str) -> ModuleFacts:
        if module not in self._facts_of:
            self._facts_of[module] = self._cache.facts(self._sources[module].content)
        return self._facts_of[module]

    def _taken(self, module: str) -> _Taken:
        if module not in self._taken_by:
            path = module.partition(":")[0]
            part = self._part(module)
            if part is None:
                facts = self._facts(module)
                names = [(name, False) for name in facts.imported] + [(name, True) for name in facts.used]
                taken = self._resolve([(self._absolute(name, path), is_used) for name, is_used in names])
                taken = replace(taken, libraries=facts.libraries)
            else:
                taken = self._resolve([(self._absolute(name, path), True) for name in part.used])
                taken = replace(taken, modules=(*taken.modules, *(f"{path}:{name}" for name in part.parts)))
            self._taken_by[module] = taken
        return self._taken_by[module]

    def _part(self, name: str) -> Part | None:
        """A definition of a stage's module, or of that module itself what its work is; None of other modules."""
        module, separator, local = name.partition(":")
        return self._facts(module).parts.get(local if separator else STAGE)

    def _resolve(self, names: list[tuple[str, bool]]) -> _Taken:
        """Follow names to modules. With each name comes whether the code uses it, or only imports it."""
        modules: set[str] = set()
        leads: set[str] = set()
        libraries: set[str] = set()
        followed: set[tuple[str, bool]] = set()
        while names:
            name, is_used = names.pop()
            if (name, is_used) in followed:
                continue
            followed.add((name, is_used))
            module, attributes = self._split(name)
            if module not in self._sources:
                libraries.add(module.partition(".")[0])
                continue
            offers = self._offers(module)
            if attributes and attributes[0] in offers:
                target = offers[attributes[0]]
                leads.add(f"{module}:{attributes[0]}={target}")
                names.append((_below(target, attributes[1:]), is_used))
                continue
            if offers and not attributes and not is_used:
                continue  # to import a face loads nothing
            imported, parts = self._facts(module).bindings, self._facts(module).parts
            if not parts:
                modules.add(module)
            elif attributes and attributes[0] in parts:
                modules.add(f"{module}:{attributes[0]}")
            elif (is_used and not attributes) or attributes == ["*"]:
                modules.update(f"{module}:{part}" for part in parts)
            if attributes == ["*"] or (offers and not attributes):
                everything = offers.values() or [self._absolute(target, module) for target in imported.values()]
                names += [(target, True) for target in everything]
            elif attributes and attributes[0] in imported:  # a name that the module itself imports
                target = self._absolute(imported[attributes[0]], module)
                names.append((_below(target, attributes[1:]), is_used))
        return _Taken(tuple(sorted(modules)), tuple(sorted(leads)), tuple(sorted(libraries)))

    def _split(self, name: str) -> tuple[str, list[str]]:
        """The module that a name stands in, which may be none of the project's, and its attributes there."""
        module, _, rest = name.partition(":")
        attributes = rest.split(".") if rest else []
        while module not in self._sources and "." in module:
            module, attributes = module.rpartition(".")[0], []
        while attributes and attributes[0] not in self._offers(module):
            if f"{module}.{attributes[0]}" not in self._sources:
                break
            module = f"{module}.{attributes.pop(0)}"
        return module, attributes

    def _offers(self, module: str) -> Mapping[str, str]:
        """The names that a face offers, with what they stand for; none for other modules."""
        source = self._sources.get(module)
        if source is None or source.stub is None or not self._facts(module).attaches_stub:
            return {}
        if module not in self._offered_by:
            own = f"{module}:"  # in a stub ``from . import name`` is the module of that name, whatever else is offered
            bindings = self._cache.facts(source.stub).bindings.items()
            targets = {local: self._absolute(name, module) for local, name in bindings}
            self._offered_by[module] = {
                local: f"{module}.{target.removeprefix(own)}:" if target.startswith(own) else target
                for local, target in targets.items()
            }
        return self._offered_by[module]

    def _absolute(self, name: str, module: str) -> str:
        """A name with the full name of its module; ``module`` may write that relative to its package."""
        path, _, rest = name.partition(":")
        relative = path.lstrip(".")
        if relative == path:
            return name
        levels = len(path) - len(relative) - (self._sources[module].path.name == "__init__.py")
        parents = module.split(".")[: -levels or None]
        return f"{'.'.join([*parents, relative] if relative else parents)}:{rest}"


@dataclass(frozen=True)
class _Taken:
    """What one module, or one definition of a stage's module, takes from others."""

    modules: tuple[str, ...]
    leads: tuple[str, ...]
    libraries: tuple[str, ...]


def _join(digest: str, leads: Sequence[str]) -> str:
    return hashlib.sha256("\0".join([digest, *leads]).encode()).hexdigest()[:32] if leads else digest


def _contents(source: Source) -> Iterator[bytes]:
    yield source.content
    if source.stub is not None:
        yield source.stub


def _below(name: str, attributes: Sequence[str]) -> str:
    return ".".join([name, *attributes]).replace(":.", ":")
