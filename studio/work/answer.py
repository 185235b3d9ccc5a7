"""What a computation gives back: the state that follows, the files that are new, and the scene to be shown."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import wraps
from typing import ParamSpec

from msgspec import json

from riot.transform.riot_file import to_json
from riot.transform.transform import Transform
from studio.messages import Side
from studio.scene import scene_of, thumbnail_of
from studio.session.folder import digest_of
from studio.session.state import State


@dataclass(frozen=True)
class Made:
    """A transform: its digest, its text, and its scene as JSON; of a draft the text is empty."""

    digest: str
    text: bytes
    scene: bytes
    worth: float = 0.0


@dataclass(frozen=True)
class Shortfall:
    """What an edit asked for and did not get: where (flat list), on the shape of one side, and why, in words."""

    side: Side
    where: tuple[float, ...]
    words: str


@dataclass(frozen=True)
class Answer:
    """A state, what is shown of it, further transforms that it names, the CPU milliseconds that it took, and what is
    not as it was asked for."""

    state: State
    shown: Made
    others: tuple[Made, ...] = ()
    cpu: float = 0.0
    shortfall: Shortfall | None = None


def kept(transform: Transform, *, thumbnail: bool = False, worth: float = 0.0) -> Made:
    """A transform to be kept, with the scene that shows it."""
    text = to_json(transform).encode("utf-8")
    digest = digest_of(text)
    scene = thumbnail_of(transform, digest) if thumbnail else scene_of(transform, digest)
    return Made(digest, text, json.encode(scene), worth)


def draft(transform: Transform) -> Made:
    """A transform that is shown once, while something moves."""
    return Made("", b"", json.encode(scene_of(transform, "draft", quick=True)))


Arguments = ParamSpec("Arguments")


def timed(function: Callable[Arguments, Answer]) -> Callable[Arguments, Answer]:
    """A function whose answer says how much CPU time it took."""

    @wraps(function)
    def measured(*arguments: Arguments.args, **named: Arguments.kwargs) -> Answer:
        started = time.process_time()
        answer = function(*arguments, **named)
        return replace(answer, cpu=round(1e3 * (time.process_time() - started), 1))

    return measured
