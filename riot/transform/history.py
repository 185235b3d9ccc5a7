"""Where a transform comes from: pictures, parameters, code and libraries, by content; no path, no time, no host. Ours.

Equal inputs give an equal history on any machine with the same code and libraries, so that files stay the same.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

LIBRARIES = ("numpy", "scipy", "numba", "llvmlite", "shapely", "scikit-image", "pillow", "svgelements")
"""What computes a transform beside this library."""

_DIGEST = re.compile("[0-9a-f]{64}")


@dataclass(frozen=True)
class Step:
    """One step: its name, the parameters that it read (JSON values), a digest of its code, and its content keys.

    ``keys`` name the step's results in a store: one, or P's and Q's; none where there is no store.
    """

    name: str
    parameters: Mapping[str, Any]
    code: str
    keys: tuple[str, ...] = ()


@dataclass(frozen=True)
class History:
    """What made a transform: ``maker``, the SHA-256 of P's and of Q's file, the steps in order, library versions."""

    maker: str
    pictures: tuple[str, str]
    steps: tuple[Step, ...]
    versions: Mapping[str, str]


def to_document(history: History) -> dict[str, Any]:
    """A history as JSON values."""
    return asdict(history)


def from_document(found: Any) -> History:
    """What `to_document` wrote; KeyError, TypeError or ValueError if it is damaged."""
    pictures, steps, versions = found["pictures"], found["steps"], found["versions"]
    if len(pictures) != 2 or not all(isinstance(one, str) and _DIGEST.fullmatch(one) for one in pictures):
        raise ValueError("the history's pictures are not two SHA-256 digests")
    if not isinstance(versions, dict) or not isinstance(steps, list):
        raise TypeError("the history's versions are no mapping, or its steps no list")
    return History(
        maker=_text(found["maker"]),
        pictures=(pictures[0], pictures[1]),
        steps=tuple(_step(step) for step in steps),
        versions={_text(name): _text(version) for name, version in versions.items()},
    )


def made_here(maker: str, pictures: tuple[Path, Path], steps: Mapping[str, Mapping[str, Any]]) -> History:
    """The history of what this process makes of two files, by steps with the parameters that each reads, JSON values.

    OSError when a file cannot be read.
    """
    code = code_digest(Path(__file__).parents[1])
    first, second = (file_digest(path) for path in pictures)
    return History(
        maker=maker,
        pictures=(first, second),
        steps=tuple(Step(name, parameters, code) for name, parameters in steps.items()),
        versions={name: metadata.version(name) for name in LIBRARIES},
    )


def file_digest(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def code_digest(package: Path) -> str:
    """SHA-256 of the names and bytes of all Python files below a folder."""
    state = hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        name, code = path.relative_to(package).as_posix().encode(), path.read_bytes()
        state.update(len(name).to_bytes(8, "little") + name + len(code).to_bytes(8, "little") + code)
    return state.hexdigest()


def told(history: History) -> Iterator[str]:
    """A history line by line, for people."""
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


def _step(found: Any) -> Step:
    if not isinstance(found["parameters"], dict):
        raise TypeError("the parameters of a step of the history are no mapping")
    keys = tuple(_text(key) for key in found["keys"])
    return Step(_text(found["name"]), found["parameters"], _text(found["code"]), keys)


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r} where text belongs")
    return value
