"""Where a transform comes from: pictures, parameters, code and libraries, by content; no path, no time, no host. Ours.

Equal inputs give an equal history on any machine with the same code and libraries, so that files stay the same.
`riot.transform.provenance` records a history and describes it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

_DIGEST = re.compile("[0-9a-f]{64}")


@dataclass(frozen=True)
class HistoryStep:
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
    steps: tuple[HistoryStep, ...]
    versions: Mapping[str, str]


def to_document(history: History) -> dict[str, Any]:
    """A history as JSON values."""
    return asdict(history)


def from_document(document: Any) -> History:
    """Read what `to_document` wrote; KeyError, TypeError or ValueError if it is damaged."""
    pictures, steps, versions = document["pictures"], document["steps"], document["versions"]
    if len(pictures) != 2 or not all(isinstance(digest, str) and _DIGEST.fullmatch(digest) for digest in pictures):
        raise ValueError("the history's pictures are not two SHA-256 digests")
    if not isinstance(versions, dict) or not isinstance(steps, list):
        raise TypeError("the history's versions are no mapping, or its steps no list")
    return History(
        maker=_text(document["maker"]),
        pictures=(pictures[0], pictures[1]),
        steps=tuple(_step(step) for step in steps),
        versions={_text(name): _text(version) for name, version in versions.items()},
    )


def _step(document: Any) -> HistoryStep:
    if not isinstance(document["parameters"], dict):
        raise TypeError("the parameters of a step of the history are no mapping")
    keys = tuple(_text(key) for key in document["keys"])
    return HistoryStep(_text(document["name"]), document["parameters"], _text(document["code"]), keys)


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r} where text belongs")
    return value
