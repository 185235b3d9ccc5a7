"""What the server tells browsers."""

from __future__ import annotations

from msgspec import Raw, Struct, json


class _News(Struct, frozen=True, tag_field="type", tag=lambda name: name.lower()):
    """A message to all tabs of a session."""


class ShapeNews(Struct, frozen=True):
    """An input."""

    name: str
    outline: list[float]


class SnapshotNews(Struct, frozen=True):
    """A snapshot; ``transform`` is what it shows."""

    name: str
    transform: str | None
    words: str


class Session(_News, frozen=True):
    """The state of a session, after every step."""

    id: str
    revision: int
    undo: str | None
    redo: str | None
    p: ShapeNews | None
    q: ShapeNews | None
    pieces: tuple[int, int] | None
    weight: float | None
    pins: Raw
    stiff: Raw
    transform: str | None
    snapshots: list[SnapshotNews]
    collection: bool
    saved: bool = True


class TransformNews(_News, frozen=True, tag="transform"):
    """A transform that answers a request, or is there when a tab is opened."""

    seq: int
    draft: bool
    milliseconds: float
    scene: Raw


class MotionNews(_News, frozen=True, tag="motion"):
    """How a transform swings, planned after it was shown."""

    transform: str
    motion: Raw


class Problem(_News, frozen=True):
    """What cannot be, where, and why; what is shown stays."""

    seq: int
    draft: bool
    words: str
    side: str | None = None
    where: list[float] = []
    pin: int | None = None


class Refused(_News, frozen=True):
    """A request that is not understood, or cannot be followed now."""

    seq: int
    words: str


class Progress(_News, frozen=True):
    """What is being done."""

    seq: int
    work: str
    words: str
    done: int = 0
    of: int | None = None


class AlternativeNews(_News, frozen=True, tag="alternative"):
    """Another transform of the two shapes."""

    seq: int
    rank: int
    transform: str
    pieces: int
    worth: float
    words: str
    scene: Raw


class AlternativesEnd(_News, frozen=True, tag="alternatives_end"):
    """No more alternatives come."""

    seq: int
    count: int
    words: str = ""


def encoded(news: _News) -> bytes:
    """A message as JSON.

    >>> encoded(Refused(1, "no"))
    b'{"type":"refused","seq":1,"words":"no"}'
    """
    return json.encode(news)
