"""Compile every kernel before it is needed."""

from __future__ import annotations

import importlib
import pkgutil
import time
from collections.abc import Callable
from pathlib import Path

import riot.kernels


def warm_all(report: Callable[[str], None]) -> None:
    """Make every kernel ready to run.

    ``report`` gets a message if kernels have to be compiled, which takes about a minute, once after installation or
    after a change: Numba keeps compiled kernels beside their modules.
    """
    missing = uncompiled()
    if missing:
        report(f"compiling the numeric kernels for this machine, once, about a minute: {', '.join(missing)}")
    start = time.perf_counter()
    for name in _modules():
        importlib.import_module(f"riot.kernels.{name}").warm()
    if missing:
        report(f"kernels compiled in {time.perf_counter() - start:.0f} s")


def uncompiled() -> list[str]:
    """Names of the modules none of whose kernels is in the cache."""
    cache = Path(riot.kernels.__path__[0]) / "__pycache__"
    return [name for name in _modules() if not list(cache.glob(f"{name}.*.nbi"))]


def _modules() -> list[str]:
    names = [module.name for module in pkgutil.iter_modules(riot.kernels.__path__)]
    return [name for name in names if _has_kernels(name)]


def _has_kernels(name: str) -> bool:
    return hasattr(importlib.import_module(f"riot.kernels.{name}"), "warm")
