"""What the fixtures of all tests are made of."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path

Once = Callable[[str, Callable[[Path], object]], Path]
"""The fixture ``once``: makes a folder once a session, for all workers."""


def warm(name: str) -> None:
    """Compile the kernels of a module into Numba's cache; done in processes of their own, several at a time."""
    import_module(f"riot.kernels.{name}").warm()
