"""Code digests: which of our modules a stage runs, what they say, and which libraries they stand on.

A module's digest is taken over its syntax tree without docstrings, comments and layout, so that only a change of
meaning changes it. The closure follows every import inside the project, also those inside functions, but not those
under ``if TYPE_CHECKING`` (`pipeline.plan.closure`). The project's modules are taken as they were when this process
began (`pipeline.plan.sources`).
"""

from __future__ import annotations

import sys
from functools import cache
from importlib import metadata

from pipeline.plan.closure import Project
from pipeline.plan.module_facts import FactsCache, cache_file
from pipeline.plan.sources import AT_START, PACKAGES, edited

DISTRIBUTIONS = {"PIL": "pillow", "skimage": "scikit-image", "imageio_ffmpeg": "imageio-ffmpeg"}
"""Distributions whose name differs from that of the package which they install."""

CODE_GENERATORS = {"numba": "llvmlite"}
"""Distributions and the one that generates their machine code."""

PROJECT = Project(AT_START, FactsCache(PACKAGES, cache_file()))
"""This project, as it was when this process began."""


def code_digests(module: str) -> dict[str, str]:
    """The digest of each module of this project that ``module`` imports, directly or not, itself included."""
    return PROJECT.digests(module)


def modules_of(module: str) -> tuple[str, ...]:
    """The modules of this project that ``module`` imports, directly or not, itself included."""
    return PROJECT.closure(module).modules


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
