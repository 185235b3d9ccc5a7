"""One session while the server runs: its history, the tabs that look at it, and what is being computed for it."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable
from pathlib import Path

from msgspec import Raw

from riot.errors import PinError, RiotError
from studio.live import news
from studio.live.drafts import Latest
from studio.live.jobs import Jobs, Work
from studio.live.tabs import Send, Tabs
from studio.live.view import View, documents
from studio.messages import Choose, EditRequest, Pieces, RequestError, Side, Swap
from studio.session.folder import SessionFolder
from studio.session.history import History
from studio.work.answer import Answer
from studio.work.change import change
from studio.work.moving import plan_swing
from studio.work.textures import textures
from studio.work.workers import Workers

LOG = logging.getLogger(__name__)


class LiveSession:
    """A session; every method runs in the event loop, every computation in a worker.

    ``turn`` is held while the history changes, so that edits follow one another.
    """

    def __init__(self, folder: SessionFolder, workers: Workers, collection: Path | None) -> None:
        """Open the session in a folder; raises `riot.errors.FormatError` if it cannot be read."""
        self.folder, self.workers, self.collection = folder, workers, collection
        self.history = folder.load()
        self.turn = asyncio.Lock()
        self.jobs, self.tabs = Jobs(), Tabs()
        self.view = View(folder, workers.live, collection)
        self._revision = 0
        self._drafts: Latest[EditRequest] = Latest(lambda request: self.told(request.seq, self._draft(request)))

    @property
    def input_names(self) -> tuple[str | None, str | None]:
        """The names of the two inputs."""
        p, q = self.view.shape(self.history.now.p), self.view.shape(self.history.now.q)
        return None if p is None else p.name, None if q is None else q.name

    async def join(self, send: Send) -> None:
        """Tell a new tab what there is, and all news from now on."""
        self.tabs.add(send)
        await send(news.encoded(await self.view.session(self.history, self._revision, 0)))
        shown = self.history.now.shown
        if shown is not None:
            await send(news.encoded(news.TransformNews(0, False, 0.0, 0.0, Raw(await self.view.scene(shown)))))
            await self.plan_motion(shown)

    def move(self, request: EditRequest) -> None:
        """Answer with a draft, unless something newer comes first."""
        if not isinstance(request.edit, Pieces | Swap):
            self._drafts.put(request)

    async def release(self, request: EditRequest) -> None:
        """Do an edit: a new step, answered exactly, or told why it cannot be."""
        self._drafts.drop()
        async with self.turn:
            self._drafts.drop()
            started = time.perf_counter()
            answer = await self._change(request, quick=False)
            if answer is None:
                return
            for made in (answer.shown, *answer.others):
                self.view.keep(made)
            await self.commit(self.history.step(answer.state), request.seq)
            await self.show(request.seq, started, answer, draft=False)
        await self.plan_motion(answer.shown.digest)

    async def go(self, seq: int, move: Callable[[History], History]) -> None:
        """Undo, redo, or another step that computes nothing."""
        self._drafts.drop()
        async with self.turn:
            before = self.history.now.shown
            try:
                after = move(self.history)
            except KeyError as error:
                await self.tabs.tell(news.Refused(seq, f"there is no snapshot {error.args[0]!r}"))
                return
            await self.commit(after, seq)
            shown = self.history.now.shown
            if shown is None or shown == before:
                return
            await self.tabs.tell(news.TransformNews(seq, False, 0.0, 0.0, Raw(await self.view.scene(shown))))
        await self.plan_motion(shown)

    async def commit(self, history: History, seq: int) -> None:
        """Make a history the present one, on disk first; ``turn`` is held."""
        await asyncio.to_thread(self.folder.save, history)
        self.history = history
        self._revision += 1
        await self.tabs.tell(await self.view.session(history, self._revision, seq))

    async def show(self, seq: int, started: float, answer: Answer, *, draft: bool) -> None:
        """Tell of a transform that was asked for when the clock was at ``started``."""
        milliseconds = round(1e3 * (time.perf_counter() - started), 1)
        await self.tabs.tell(news.TransformNews(seq, draft, milliseconds, answer.cpu, Raw(answer.shown.scene)))
        missing = answer.shortfall
        if missing is not None:
            await self.tabs.tell(news.Problem(seq, draft, missing.words, missing.side, list(missing.where)))

    async def plan_motion(self, digest: str) -> None:
        """Have the motion of a transform planned, if it is not."""
        if b'"planned":true' not in await self.view.scene(digest):
            self.jobs.start("motion", self.told(0, self._plan_motion(digest)))

    async def textures(self, digest: str) -> bytes:
        """`studio.work.textures.textures` of the transform that is shown; KeyError if it is not this one."""
        state = self.history.now
        if digest != state.shown:
            raise KeyError(digest)
        inputs: dict[Side, str | None] = {"p": state.p, "q": state.q}
        pictures = {side: self.folder.picture(shape) for side, shape in inputs.items() if shape is not None}
        given = {side: data for side, data in pictures.items() if data is not None}
        return await self.workers.workshop.run(textures, {digest: self.folder.transform(digest)}, digest, given)

    async def told(self, seq: int, work: Work) -> None:
        """Await work that was asked for; an error that nobody foresaw is told, too, and logged."""
        try:
            await work
        except Exception as error:
            LOG.exception("session %s, request %d", self.folder.name, seq)
            await self.tabs.tell(
                news.Refused(seq, f"this failed, which it should not ({type(error).__name__}: {error})")
            )

    async def _plan_motion(self, digest: str) -> None:
        made = await self.workers.background.run(plan_swing, {digest: self.folder.transform(digest)}, digest)
        self.folder.put_transform(made.text, digest)
        self.view.forget(digest)
        await self.tabs.tell(news.MotionNews(digest, Raw(made.scene)))

    async def _draft(self, request: EditRequest) -> None:
        async with self.turn:
            started = time.perf_counter()
            answer = await self._change(request, quick=True)
            if answer is not None:
                await self.show(request.seq, started, answer, draft=True)

    async def _change(self, request: EditRequest, quick: bool) -> Answer | None:
        state = self.history.now
        try:
            files = documents(self.folder, state)
            if isinstance(request.edit, Choose):
                files[request.edit.transform] = self.folder.transform(request.edit.transform)
            return await self.workers.live.run(change, state, request.edit, files, quick)
        except RequestError as error:
            await self.tabs.tell(news.Refused(request.seq, str(error)))
        except KeyError as error:
            await self.tabs.tell(news.Refused(request.seq, str(error.args[0])))
        except RiotError as error:
            await self.tabs.tell(problem(request.seq, quick, error, getattr(request.edit, "side", None)))
        return None


def problem(seq: int, draft: bool, error: RiotError, side: str | None) -> news.Problem:
    """What cannot be, and where, if the error knows."""
    if not isinstance(error, PinError):
        return news.Problem(seq, draft, str(error), side)
    where = [round(value, 5) for point in error.points for value in point]
    return news.Problem(seq, draft, str(error), error.side or side, where, error.pin)
