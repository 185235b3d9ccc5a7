"""The project's source files as they were when this process began: what its modules were, or will be, loaded from.

`pipeline` reads them before it imports anything else. A key may promise only what the loaded code computes, and the
files may be edited after they were loaded: keys are made of what is kept here, and work is refused once a file differs.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("riot", "pipeline")


@dataclass(frozen=True)
class Source:
    """A module's file and what it says."""

    path: Path
    content: bytes


def read_sources(root: Path = ROOT, packages: Iterable[str] = PACKAGES) -> dict[str, Source]:
    """Every module of the packages below ``root``, by its full name."""
    found: dict[str, Source] = {}
    for package in packages:
        for path in sorted((root / package).rglob("*.py")):
            parts = path.relative_to(root).with_suffix("").parts
            name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
            # As Python does, prefer a package to a module of the same name.
            if name not in found or path.name == "__init__.py":
                with contextlib.suppress(FileNotFoundError):  # an editor is replacing it: it cannot be imported either
                    found[name] = Source(path, path.read_bytes())
    return found


def edited(names: Iterable[str], known: Mapping[str, Source]) -> list[str]:
    """Which of the modules' files differ by now from what is known of them, or are gone."""

    def differs(source: Source) -> bool:
        try:
            return source.path.read_bytes() != source.content
        except OSError:
            return True

    return [name for name in names if differs(known[name])]


AT_START: Mapping[str, Source] = read_sources()
"""What this process was started with."""
