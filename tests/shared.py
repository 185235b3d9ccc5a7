"""What the fixtures of all tests are made of."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

Once = Callable[[str, Callable[[Path], object]], Path]
"""The fixture ``once``: makes a folder once a session, for all workers."""
