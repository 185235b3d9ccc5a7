"""The type of the fixture ``once``, which makes a folder once a session for all workers."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

Once = Callable[[str, Callable[[Path], object]], Path]
