"""Packages that load what they offer when the first of it is used.

Importing a module imports its package first: without this, whoever wants `riot.errors` or the values of parameters
would load the numeric libraries of everything else.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib.util import find_spec
from types import ModuleType


def offer(package: str, load: Callable[[], ModuleType], namesakes: tuple[str, ...] = ()) -> None:
    """Have a package offer the names in ``__all__`` of the module that ``load`` imports.

    ``namesakes`` are those that are called as a module of the package is: they stay what is offered when that module
    is imported.
    """
    found = sys.modules[package]
    vars(found).update(_load=load, _namesakes=namesakes)
    found.__class__ = _Package


class _Package(ModuleType):
    _load: Callable[[], ModuleType]
    _namesakes: tuple[str, ...]

    def __getattr__(self, name: str) -> object:
        # Also asked for before a module of that name is imported, which need not load what is offered.
        is_module = name not in self._namesakes and find_spec(f"{self.__name__}.{name}") is not None
        if name == "__all__" or not (name.startswith("__") or is_module):
            offered = self._load()
            if name == "__all__":
                return offered.__all__
            if name in offered.__all__:
                return vars(offered)[name]
        raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in self._namesakes and isinstance(value, ModuleType)):
            super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self._load().__all__})
