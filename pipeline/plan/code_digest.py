"""Code digests: which of our modules a stage runs, what they say, and which libraries they stand on.

A module's digest is taken over its syntax tree without docstrings, comments and layout, so that only a change of
meaning changes it. The closure follows every import inside the project, also those inside functions, but not those
under ``if TYPE_CHECKING``.

A package may be a *face*: ``lazy_loader.attach_stub`` offers the names in its ``__init__.pyi``. Of a face the closure
holds what is used: for ``from riot import scores`` and ``scores.crs.best_trunk_pairs(…)`` that is the module
``riot.scores.crs``. A face that is used in any other way than by attribute counts with everything that it offers. The
``__init__`` of a package counts only when something is taken from it that is neither a module nor in its stub.

Of a module that defines a stage counts what its ``run``, ``prepare`` and ``join`` reach, and what others take from it:
how its work is planned, and what tables show of it, changes no result.

The project's own modules are taken as they were when this process began (`pipeline.plan.sources`).
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from pathlib import Path

from pipeline.plan.module_facts import FactsCache, ModuleFacts, cache_file
from pipeline.plan.reached_code import is_stage
from pipeline.plan.sources import AT_START, PACKAGES, Source, edited, read_sources

DECLARATIONS = frozenset(
    {
        *(f"riot.parameters.{group}" for group in ("shape", "reversibility", "trunks", "qcrs", "crs", "refine")),
        *("riot.parameters.construct", "riot.parameters.motion", "riot.parameters.field"),
        *("riot.errors", "pipeline.errors", "pipeline.stages.specs"),
    }
)
"""Modules that compute nothing: the values of parameters and specs enter a key by themselves, so that a new parameter
or another default of one stage leaves the other stages' keys alone."""

DISTRIBUTIONS = {"PIL": "pillow", "skimage": "scikit-image", "imageio_ffmpeg": "imageio-ffmpeg"}
"""Distributions whose name differs from that of the package which they install."""

CODE_GENERATORS = {"numba": "llvmlite"}
"""Distributions and the one that generates their machine code."""


WORK = ("run", "prepare", "join")
"""The functions of a stage's module that do its work."""


@dataclass(frozen=True)
class Closure:
    """All that a module imports, directly or not; every part is sorted.

    ``leads`` tells for each module which names it takes from faces and where they lead: ``riot:qcrs=riot.…``; ``names``
    for each module of a stage which of its names are used, none for all of it.
    """

    modules: tuple[str, ...]
    libraries: tuple[str, ...]
    leads: Mapping[str, tuple[str, ...]]
    names: Mapping[str, tuple[str, ...]]

    @property
    def files(self) -> list[str]:
        """The modules whose files decide what the code does: also the faces, whose stubs do."""
        faces = {lead.partition(":")[0] for leads in self.leads.values() for lead in leads}
        return sorted({*self.modules, *faces})


class Project:
    """Packages of modules that import each other, as their files were when they were read."""

    def __init__(self, sources: Mapping[str, Source], cache: FactsCache) -> None:
        """``cache`` keeps what was parsed; no digest depends on it."""
        self._sources = dict(sources)
        self._cache = cache
        self._facts_of: dict[tuple[str, tuple[str, ...]], ModuleFacts] = {}
        self._taken_by: dict[tuple[str, str], _Taken] = {}
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
            name: _join(self._facts(name, closure.names.get(name, ())).digest, closure.leads[name])
            for name in closure.modules
            if name not in DECLARATIONS
        }

    def file_digest(self, module: str) -> str:
        """The digest of all of a module's code, whatever it imports."""
        return self._facts(module).digest

    def _follow(self, start: str) -> Closure:
        taken_by: dict[tuple[str, str], _Taken] = {}
        libraries: set[str] = set()
        pending = [(start, name) for name in WORK] if self._is_stage(start) else [(start, "")]
        while pending:
            module, name = node = pending.pop()
            if node not in taken_by:
                taken_by[node] = self._taken(module, name)
                libraries.update(self._facts(module, (name,) if name else ()).libraries)
                pending += [(other, used if self._is_stage(other) else "") for other, used in taken_by[node].modules]
        modules = sorted({module for module, _ in taken_by})
        leads = {
            module: sorted({lead for node in taken_by if node[0] == module for lead in taken_by[node].leads})
            for module in modules
        }
        names = {
            module: sorted(name for other, name in taken_by if other == module)
            for module in modules
            if self._is_stage(module)
        }
        return Closure(
            tuple(modules),
            tuple(sorted(libraries)),
            {module: tuple(of) for module, of in leads.items()},
            {module: () if "" in of else tuple(of) for module, of in names.items()},
        )

    def _is_stage(self, module: str) -> bool:
        return is_stage(self._sources[module].content)

    def _facts(self, module: str, names: tuple[str, ...] = ()) -> ModuleFacts:
        if (module, names) not in self._facts_of:
            self._facts_of[module, names] = self._cache.facts(self._sources[module].content, names)
        return self._facts_of[module, names]

    def _taken(self, module: str, name: str) -> _Taken:
        if (module, name) not in self._taken_by:
            facts = self._facts(module, (name,) if name else ())
            names = [(self._absolute(imported, module), False) for imported in facts.imported]
            names += [(self._absolute(used, module), True) for used in facts.used]
            self._taken_by[module, name] = self._resolve(names)
        return self._taken_by[module, name]

    def _resolve(self, names: list[tuple[str, bool]]) -> _Taken:
        """Follow names to modules. With each name comes whether the code uses it, or only imports it."""
        modules: set[tuple[str, str]] = set()
        leads: set[str] = set()
        followed: set[tuple[str, bool]] = set()
        while names:
            name, is_used = names.pop()
            if (name, is_used) in followed:
                continue
            followed.add((name, is_used))
            module, attributes = self._split(name)
            if module not in self._sources:
                continue
            offers = self._offers(module)
            if attributes and attributes[0] in offers:
                target = offers[attributes[0]]
                leads.add(f"{module}:{attributes[0]}={target}")
                names.append((_below(target, attributes[1:]), is_used))
                continue
            if offers and not attributes and not is_used:
                continue  # to import a face loads nothing
            modules.add((module, attributes[0] if attributes else ""))
            bindings = offers or self._bindings(module, self._facts(module))
            if attributes == ["*"] or (offers and not attributes):
                names += [(target, True) for target in bindings.values()]
            elif attributes and attributes[0] in bindings:  # a name that the module itself imports
                names.append((_below(bindings[attributes[0]], attributes[1:]), is_used))
        return _Taken(tuple(sorted(modules)), tuple(sorted(leads)))

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

    def _offers(self, module: str) -> dict[str, str]:
        """The names that a face offers, with what they stand for; none for other modules."""
        source = self._sources.get(module)
        if source is None or source.stub is None or not self._facts(module).attaches_stub:
            return {}
        bindings = self._bindings(module, self._cache.facts(source.stub))
        # In a stub ``from . import name`` is the module of that name, whatever else the face offers.
        return {
            name: f"{module}.{target.removeprefix(f'{module}:')}:" if target.startswith(f"{module}:") else target
            for name, target in bindings.items()
        }

    def _bindings(self, module: str, facts: ModuleFacts) -> dict[str, str]:
        return {local: self._absolute(name, module) for local, name in facts.bindings.items()}

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
    """What one module takes from others: of each module a name, or all of it."""

    modules: tuple[tuple[str, str], ...]
    leads: tuple[str, ...]


PROJECT = Project(AT_START, FactsCache(PACKAGES, cache_file()))
"""This project, as it was when this process began."""


def code_digests(module: str) -> dict[str, str]:
    """The digest of each module of this project that ``module`` imports, directly or not, itself included."""
    return PROJECT.digests(module)


def file_digest(module: str) -> str:
    """The digest of all of a module's code, whatever it imports."""
    return PROJECT.file_digest(module)


def edited_since_start(module: str) -> list[str]:
    """Modules that ``module`` imports, directly or not, whose files are no longer what this process began with."""
    return edited(PROJECT.closure(module).files, AT_START)


def library_versions(module: str) -> dict[str, str]:
    """The version of each installed distribution that ``module`` imports, directly or not."""
    tops = set(PROJECT.closure(module).libraries) - sys.stdlib_module_names
    names = {DISTRIBUTIONS.get(top, top) for top in tops}
    names |= {CODE_GENERATORS[name] for name in names & CODE_GENERATORS.keys()}
    versions = {name: installed_version(name) for name in sorted(names)}
    return {name: version for name, version in versions.items() if version is not None}


@cache
def installed_version(distribution: str) -> str | None:
    """The version of a distribution; None when it is not installed."""
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return None


def _join(digest: str, leads: Sequence[str]) -> str:
    return hashlib.sha256("\0".join([digest, *leads]).encode()).hexdigest()[:32] if leads else digest


def _contents(source: Source) -> Iterator[bytes]:
    yield source.content
    if source.stub is not None:
        yield source.stub


def _below(name: str, attributes: Sequence[str]) -> str:
    return ".".join([name, *attributes]).replace(":.", ":")
