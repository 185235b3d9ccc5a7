"""What is shown of a session: its state in words, and the scenes of its transforms."""

from __future__ import annotations

from collections import OrderedDict
from pathlib import Path

from msgspec import Raw, Struct, json

from studio.live import news
from studio.session.folder import SessionFolder
from studio.session.history import History
from studio.session.state import State
from studio.work.answer import Made
from studio.work.marks import marks, scene
from studio.work.workers import Worker

NO_MARKS = Raw(b'{"p":[],"q":[]}')

KEPT_SCENES = 64
"""Scenes that are kept in memory, some 40 kB each."""


class _Words(Struct):
    words: str


class _ShapeDocument(Struct):
    name: str
    points: list[tuple[float, float]]


def documents(folder: SessionFolder, state: State) -> dict[str, bytes]:
    """The documents that a state names, by digest."""
    files = {name: folder.shape(name) for name in (state.p, state.q) if name is not None}
    return files | {name: folder.transform(name) for name in (state.root, state.base) if name is not None}


class View:
    """Scenes of one session, and news of its state."""

    def __init__(self, folder: SessionFolder, worker: Worker, collection: Path | None) -> None:
        """Nothing is shown yet."""
        self._folder, self._worker, self._collection = folder, worker, collection
        self._scenes: OrderedDict[str, bytes] = OrderedDict()

    def keep(self, made: Made) -> None:
        """Keep a transform that was made, and its scene."""
        if made.text:
            self._folder.put_transform(made.text)
            self._put(made.digest, made.scene)

    def forget(self, digest: str) -> None:
        """Have a scene made anew."""
        self._scenes.pop(digest, None)

    async def scene(self, digest: str) -> bytes:
        """The scene of a transform of the session; KeyError if there is none of this digest."""
        if digest not in self._scenes:
            files = {digest: self._folder.transform(digest)}
            self._put(digest, await self._worker.run(scene, files, digest))
        self._scenes.move_to_end(digest)
        return self._scenes[digest]

    async def session(self, history: History, revision: int, seq: int) -> news.Session:
        """News of a state."""
        state = history.now
        pins = stiff = NO_MARKS
        if state.pins_p or state.pins_q or state.stiff_p or state.stiff_q:
            pins, stiff = map(Raw, await self._worker.run(marks, state, documents(self._folder, state)))
        return news.Session(
            id=self._folder.name,
            seq=seq,
            revision=revision,
            undo=history.undo,
            redo=history.redo,
            p=self.shape(state.p, state.number_p),
            q=self.shape(state.q, state.number_q),
            pieces=state.pieces,
            weight=state.weight,
            pins=pins,
            stiff=stiff,
            transform=state.shown,
            snapshots=[
                news.SnapshotNews(name, kept.shown, await self._words(kept)) for name, kept in history.snapshots
            ],
            collection=self._collection is not None,
        )

    def shape(self, digest: str | None, number: int | None = None) -> news.ShapeNews | None:
        """News of an input."""
        if digest is None:
            return None
        document = json.decode(self._folder.shape(digest), type=_ShapeDocument)
        outline = [round(value, 5) for point in document.points for value in point]
        return news.ShapeNews(document.name, outline, number, self._folder.has_picture(digest))

    def _put(self, digest: str, data: bytes) -> None:
        self._scenes[digest] = data
        while len(self._scenes) > KEPT_SCENES:
            self._scenes.popitem(last=False)

    async def _words(self, state: State) -> str:
        return "" if state.shown is None else json.decode(await self.scene(state.shown), type=_Words).words
