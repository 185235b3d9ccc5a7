"""Recording where a transform comes from, and describing it (ours)."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from importlib import metadata
from pathlib import Path
from typing import Any

from riot.transform.history import History, HistoryStep

LIBRARIES = ("numpy", "scipy", "numba", "llvmlite", "shapely", "scikit-image", "pillow", "resvg-py")
"""What computes a transform beside this library."""


def record_history(maker: str, pictures: tuple[Path, Path], steps: Mapping[str, Mapping[str, Any]]) -> History:
    """Record what this process makes of two files: ``steps`` gives the parameters that each step reads, as JSON values.

    Raises OSError when a file cannot be read.
    """
    code = code_digest(Path(__file__).parents[1])
    first, second = (file_digest(path) for path in pictures)
    return History(
        maker=maker,
        pictures=(first, second),
        steps=tuple(HistoryStep(name, parameters, code) for name, parameters in steps.items()),
        versions={name: metadata.version(name) for name in LIBRARIES},
    )


def file_digest(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal.

    >>> path = Path("empty")
    >>> path.touch()
    >>> file_digest(path)[:8]
    'e3b0c442'
    """
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def code_digest(package: Path) -> str:
    """SHA-256 of the names and bytes of all Python files below a folder."""
    state = hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        name, code = path.relative_to(package).as_posix().encode(), path.read_bytes()
        state.update(len(name).to_bytes(8, "little") + name + len(code).to_bytes(8, "little") + code)
    return state.hexdigest()


def describe_history(history: History) -> Iterator[str]:
    """Describe a history line by line, for people.

    >>> for line in describe_history(History("riot make", ("0" * 64, "1" * 64), (), {"numpy": "2.4.6"})):
    ...     print(line[:24])
    made by: riot make
    picture P: sha256 000000
    picture Q: sha256 111111
    libraries: numpy 2.4.6
    """
    yield f"made by: {history.maker}"
    for side, digest in zip("PQ", history.pictures, strict=True):
        yield f"picture {side}: sha256 {digest}"
    for step in history.steps:
        yield f"{step.name}: code {step.code}"
        yield from (f"  key {key}" for key in step.keys)
        yield from (f"  {name} = {value}" for name, value in _flat(step.parameters))
    yield "libraries: " + ", ".join(f"{name} {version}" for name, version in history.versions.items())


def _flat(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value
