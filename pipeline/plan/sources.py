"""The project's source files as they were when this process began: its modules were, or will be, loaded from them.

`pipeline` reads them before it imports anything else. A key may promise only what the loaded code computes, and the
files may be edited after they were loaded: keys are made of the bytes kept here, and work is refused once a file
differs.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("riot", "pipeline")


@dataclass(frozen=True)
class Source:
    """A module's file and its bytes; for a package also the bytes of the stub ``__init__.pyi``, if it has one."""

    path: Path
    content: bytes
    stub: bytes | None = None


def read_sources(root: Path = ROOT, packages: Iterable[str] = PACKAGES) -> dict[str, Source]:
    """Every module of the packages below ``root``, by its full name."""
    sources: dict[str, Source] = {}
    for package in packages:
        for module, path in _modules(str(root / package), package):
            # As Python does, prefer a package to a module of the same name.
            if module not in sources or path.name == "__init__.py":
                with contextlib.suppress(FileNotFoundError):  # an editor is replacing it: nobody can import it now
                    sources[module] = _read(path)
    return sources


def edited(names: Iterable[str], known: Mapping[str, Source]) -> list[str]:
    """Which of the modules' files differ by now from what is known of them, or are gone."""

    def differs(source: Source) -> bool:
        try:
            return _read(source.path) != source
        except OSError:
            return True

    return [name for name in names if differs(known[name])]


def _read(path: Path) -> Source:
    stub = None
    if path.name == "__init__.py":
        with contextlib.suppress(FileNotFoundError):
            stub = path.with_suffix(".pyi").read_bytes()
    return Source(path, path.read_bytes(), stub)


def _modules(folder: str, package: str) -> Iterator[tuple[str, Path]]:
    """Every module in a package's folder and below, by its full name."""
    try:
        entries = sorted(os.scandir(folder), key=lambda entry: entry.name)
    except FileNotFoundError:
        return
    for entry in entries:
        name = entry.name.removesuffix(".py")
        if name == "__init__" != entry.name:
            yield package, Path(entry.path)
        elif name != entry.name:
            yield f"{package}.{name}", Path(entry.path)
        elif name.isidentifier() and name != "__pycache__" and entry.is_dir():
            yield from _modules(entry.path, f"{package}.{name}")


AT_START: Mapping[str, Source] = read_sources()
"""The sources that this process was started with."""
