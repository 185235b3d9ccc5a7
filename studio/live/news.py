"""What the server tells browsers."""

from __future__ import annotations

from msgspec import Raw, Struct, json

from studio.work.making import Finding, PartFacts


class News(Struct, frozen=True, tag_field="type", tag=lambda name: name.lower()):
    """A message to all tabs of a session."""


class ShapeNews(Struct, frozen=True):
    """An input; ``shape`` is its number in the collection, if it is of it; ``colours``: its picture has several."""

    name: str
    outline: list[float]
    shape: int | None = None
    colours: bool = False


class SnapshotNews(Struct, frozen=True):
    """A snapshot; ``transform`` is what it shows."""

    name: str
    transform: str | None
    words: str


class Session(News, frozen=True):
    """The state of a session, after every step."""

    id: str
    seq: int
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


class TransformNews(News, frozen=True, tag="transform"):
    """A transform that answers a request, or is there when a tab is opened.

    ``milliseconds`` is how long the answer took since its turn came, ``cpu`` how much of a processor.
    """

    seq: int
    draft: bool
    milliseconds: float
    cpu: float
    scene: Raw


class MotionNews(News, frozen=True, tag="motion"):
    """How a transform swings, planned after it was shown."""

    transform: str
    motion: Raw


class Problem(News, frozen=True):
    """What cannot be, where, and why; what is shown stays."""

    seq: int
    draft: bool
    words: str
    side: str | None = None
    where: list[float] = []
    pin: int | None = None


class Refused(News, frozen=True):
    """A request that is not understood, or cannot be followed now."""

    seq: int
    words: str


class Progress(News, frozen=True):
    """What is being done."""

    seq: int
    work: str
    words: str
    done: int = 0
    of: int | None = None


class AlternativeNews(News, frozen=True, tag="alternative"):
    """Another transform of the two shapes."""

    seq: int
    rank: int
    transform: str
    pieces: int
    worth: float
    words: str
    scene: Raw


class AlternativesEnd(News, frozen=True, tag="alternatives_end"):
    """No more alternatives come."""

    seq: int
    count: int
    words: str = ""


class PartnerRow(Struct, frozen=True):
    """A shape of the collection by number, and its QCRS."""

    shape: int
    qcrs: float


class PartnersNews(News, frozen=True, tag="partners"):
    """The best partners of a shape, best first."""

    seq: int
    shape: int | None
    milliseconds: float
    partners: list[PartnerRow]


class PartnerNews(News, frozen=True, tag="partner"):
    """A small transform with a partner."""

    seq: int
    shape: int
    scene: Raw


class PartnersEnd(News, frozen=True, tag="partners_end"):
    """No more partners come."""

    seq: int


class PartNews(PartFacts, frozen=True):
    """A part, and where its STL file is."""

    url: str = ""


class Made(News, frozen=True):
    """A puzzle that was made; ``passed``: its files can be downloaded."""

    seq: int
    transform: str
    key: str
    passed: bool
    changes: list[str]
    scale: float
    thickness: float
    findings: list[Finding]
    parts: list[PartNews]


class MadeNot(News, frozen=True, tag="made_not"):
    """Why a puzzle cannot be made, and which parameter would mend it."""

    seq: int
    words: str
    parameter: str | None
    value: float | None = None


def encoded(news: News) -> bytes:
    """A message as JSON.

    >>> encoded(Refused(1, "no"))
    b'{"type":"refused","seq":1,"words":"no"}'
    """
    return json.encode(news)
