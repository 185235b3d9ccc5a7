"""One session while the server runs: its history, the tabs that look at it, and what is being computed for it."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable

from msgspec import Raw, Struct, json, structs

from riot.errors import PinError, RiotError
from studio.live import news
from studio.live.drafts import Latest
from studio.messages import Choose, EditRequest, Pieces, RequestError, Side, Swap
from studio.session.folder import SessionFolder
from studio.session.history import History
from studio.session.state import State
from studio.work.answer import Answer
from studio.work.change import change
from studio.work.marks import marks, scene
from studio.work.moving import plan_swing
from studio.work.reading import ShapeFile, is_transform, open_transform, read_shape
from studio.work.search import best_transform, first_transform
from studio.work.workers import Workers

Send = Callable[[bytes], Awaitable[None]]
"""Sends a message to one tab."""

NO_MARKS = Raw(b'{"p":[],"q":[]}')


class _Words(Struct):
    words: str


class _ShapeDocument(Struct):
    name: str
    points: list[tuple[float, float]]


class LiveSession:
    """A session; every method runs in the event loop, every computation in a worker."""

    def __init__(self, folder: SessionFolder, workers: Workers, collection: bool) -> None:
        """Open the session in a folder; raises `FormatError` if it cannot be read."""
        self.folder, self.workers, self.collection = folder, workers, collection
        self.history = folder.load()
        self.tabs: set[Send] = set()
        self.revision = 0
        self.jobs: dict[str, asyncio.Task[None]] = {}
        self._lock = asyncio.Lock()
        self._drafts: Latest[EditRequest] = Latest(self._draft)
        self._scenes: dict[str, bytes] = {}
        self._searching: State | None = None
        self._requests: set[asyncio.Task[None]] = set()

    # Tabs

    async def join(self, send: Send) -> None:
        """Tell a new tab what there is, and all news from now on."""
        self.tabs.add(send)
        await send(news.encoded(await self._session()))
        shown = self.history.now.shown
        if shown is not None:
            await send(news.encoded(news.TransformNews(0, False, 0.0, Raw(await self.scene(shown)))))
            self._plan_motion(shown)
        elif self._can_search(self.history.now) and self._searching is None:
            self._search(self.history.now, 0)

    def leave(self, send: Send) -> None:
        """A tab is gone."""
        self.tabs.discard(send)

    async def tell(self, message: news._News) -> None:
        """Send news to all tabs."""
        data = news.encoded(message)
        for send in list(self.tabs):
            try:
                await send(data)
            except (RuntimeError, OSError):
                self.leave(send)

    # Edits

    def move(self, request: EditRequest) -> None:
        """Answer with a draft, unless something newer comes first."""
        self._drafts.put(request)

    async def release(self, request: EditRequest) -> None:
        """Do an edit: a new step, answered exactly, or told why it cannot be."""
        self._drafts.drop()
        async with self._lock:
            self._drafts.drop()
            if isinstance(request.edit, Pieces | Swap):
                await self._search_again(request)
                return
            started = time.perf_counter()
            answer = await self._change(request, quick=False)
            if answer is None:
                return
            for made in (answer.shown, *answer.others):
                if made.text:
                    self.folder.put_transform(made.text)
            self._scenes[answer.shown.digest] = answer.shown.scene
            await self._commit(self.history.step(answer.state))
            await self._tell_transform(request.seq, started, answer, draft=False)
            self._plan_motion(answer.shown.digest)

    async def _draft(self, request: EditRequest) -> None:
        if isinstance(request.edit, Pieces | Swap):
            return
        async with self._lock:
            started = time.perf_counter()
            answer = await self._change(request, quick=True)
            if answer is not None:
                await self._tell_transform(request.seq, started, answer, draft=True)

    async def _change(self, request: EditRequest, quick: bool) -> Answer | None:
        state = self.history.now
        try:
            files = self.files(state)
            if isinstance(request.edit, Choose):
                files[request.edit.transform] = self.folder.transform(request.edit.transform)
            return await self.workers.live.run(change, state, request.edit, files, quick)
        except RequestError as error:
            await self.tell(news.Refused(request.seq, str(error)))
        except KeyError as error:
            await self.tell(news.Refused(request.seq, str(error.args[0])))
        except RiotError as error:
            await self.tell(problem(request.seq, quick, error, getattr(request.edit, "side", None)))
        return None

    async def _tell_transform(self, seq: int, started: float, answer: Answer, draft: bool) -> None:
        milliseconds = round(1e3 * (time.perf_counter() - started), 1)
        await self.tell(news.TransformNews(seq, draft, milliseconds, Raw(answer.shown.scene)))

    # History

    async def go(self, seq: int, move: Callable[[History], History]) -> None:
        """Undo, redo, or another step that computes nothing."""
        async with self._lock:
            self._drafts.drop()
            before = self.history.now.shown
            try:
                after = move(self.history)
            except KeyError as error:
                await self.tell(news.Refused(seq, f"there is no snapshot {error.args[0]!r}"))
                return
            await self._commit(after)
            shown = self.history.now.shown
            if shown is not None and shown != before:
                await self.tell(news.TransformNews(seq, False, 0.0, Raw(await self.scene(shown))))
                self._plan_motion(shown)

    async def _commit(self, history: History) -> None:
        """Make a history the present one, on disk first."""
        await asyncio.to_thread(self.folder.save, history)
        self.history = history
        self.revision += 1
        await self.tell(await self._session())

    # Inputs and search

    async def put_input(self, side: Side, data: bytes, name: str) -> None:
        """Read a file that was given; raises `riot.errors.RiotError` in words for the person."""
        if is_transform(data):
            answer, inputs = await self.workers.live.run(open_transform, data, name)
            async with self._lock:
                for shape in inputs:
                    self.folder.put_shape(shape.text)
                self.folder.put_transform(answer.shown.text)
                self._scenes[answer.shown.digest] = answer.shown.scene
                await self._commit(self.history.step(answer.state))
                await self._tell_transform(0, time.perf_counter(), answer, draft=False)
                self._plan_motion(answer.shown.digest)
            return
        await self.put_shape(side, await self.workers.live.run(read_shape, data, name))

    async def put_shape(self, side: Side, shape: ShapeFile) -> None:
        """Take a shape as an input, and look for transforms if there are two."""
        async with self._lock:
            self.folder.put_shape(shape.text)
            now = self.history.now
            p, q = (shape.digest, now.q) if side == "p" else (now.p, shape.digest)
            state = State(f"choose {shape.name}", p, q, now.pieces, now.weight)
            await self._begin_search(state, 0)

    async def _search_again(self, request: EditRequest) -> None:
        now, edit = self.history.now, request.edit
        if isinstance(edit, Swap):
            state = State("swap", now.q, now.p, now.pieces, now.weight)
        else:
            assert isinstance(edit, Pieces)
            counts = None if edit.least is None or edit.most is None else (edit.least, edit.most)
            if counts is not None and counts[0] > counts[1]:
                await self.tell(news.Refused(request.seq, "the least number of pieces is greater than the most"))
                return
            state = structs.replace(now, step="number of pieces", pieces=counts, root=None, base=None, shown=None)
            state = structs.replace(state, pins_p=(), pins_q=())
        await self._begin_search(state, request.seq)

    async def _begin_search(self, state: State, seq: int) -> None:
        await self._commit(self.history.step(state))
        if self._can_search(state):
            self._search(state, seq)

    def _can_search(self, state: State) -> bool:
        return state.p is not None and state.q is not None and state.shown is None

    def _search(self, state: State, seq: int) -> None:
        self._searching = state
        self.start("transform", self._found(state, seq))

    async def _found(self, state: State, seq: int) -> None:
        """Show a transform soon, and then the best one."""
        started = time.perf_counter()
        await self.tell(news.Progress(seq, "transform", "looking for a transform", 0, 2))
        current = state
        failure: RiotError | None = None
        for done, find in enumerate((first_transform, best_transform), start=1):
            try:
                answer = await self.workers.live.run(find, state, self.files(state))
            except RiotError as error:
                failure = error
                continue
            failure = None
            async with self._lock:
                if self.history.now is not current:
                    break
                self.folder.put_transform(answer.shown.text)
                self._scenes[answer.shown.digest] = answer.shown.scene
                await self._commit(self.history.settled(current, answer.state))
                current = answer.state
                await self._tell_transform(seq, started, answer, draft=done == 1 and state.weight is not None)
            await self.tell(news.Progress(seq, "transform", "bending both shapes a little", done, 2))
            if state.weight is None:
                break
        self._searching = None
        if failure is not None and current is state:
            await self.tell(problem(seq, False, failure, None))
        elif current.shown is not None:
            self._plan_motion(current.shown)

    # What is computed besides

    def start(self, name: str, work: Awaitable[None]) -> None:
        """Begin a job; an older one of that name ends."""
        self.stop(name)

        async def run() -> None:
            await work

        self.jobs[name] = asyncio.create_task(run())

    def spawn(self, work: Awaitable[None]) -> None:
        """Do something in its turn, while the caller goes on."""

        async def run() -> None:
            await work

        task = asyncio.create_task(run())
        self._requests.add(task)
        task.add_done_callback(self._requests.discard)

    def stop(self, *names: str) -> None:
        """End jobs; without names all but the search for a transform."""
        for name in names or tuple(name for name in self.jobs if name != "transform"):
            job = self.jobs.pop(name, None)
            if job is not None:
                job.cancel()

    def _plan_motion(self, digest: str) -> None:
        if b'"planned":true' not in self._scenes.get(digest, b""):
            self.start("motion", self._motion(digest))

    async def _motion(self, digest: str) -> None:
        files = {digest: self.folder.transform(digest)}
        made = await self.workers.background.run(plan_swing, files, digest)
        self.folder.put_transform(made.text, digest)
        self._scenes.pop(digest, None)
        await self.tell(news.MotionNews(digest, Raw(made.scene)))

    @property
    def input_names(self) -> tuple[str | None, str | None]:
        """The names of the two inputs."""
        p, q = self._shape(self.history.now.p), self._shape(self.history.now.q)
        return None if p is None else p.name, None if q is None else q.name

    async def scene(self, digest: str) -> bytes:
        """The scene of a transform of the session; KeyError if there is none of this digest."""
        if digest not in self._scenes:
            files = {digest: self.folder.transform(digest)}
            self._scenes[digest] = await self.workers.live.run(scene, files, digest)
        return self._scenes[digest]

    def files(self, state: State) -> dict[str, bytes]:
        """The documents that a state names."""
        files = {name: self.folder.shape(name) for name in (state.p, state.q) if name is not None}
        return files | {name: self.folder.transform(name) for name in (state.root, state.base) if name is not None}

    async def _session(self) -> news.Session:
        state, history = self.history.now, self.history
        pins = stiff = NO_MARKS
        if state.pins_p or state.pins_q or state.stiff_p or state.stiff_q:
            pins, stiff = map(Raw, await self.workers.live.run(marks, state, self.files(state)))
        return news.Session(
            id=self.folder.name,
            revision=self.revision,
            undo=history.undo,
            redo=history.redo,
            p=self._shape(state.p),
            q=self._shape(state.q),
            pieces=state.pieces,
            weight=state.weight,
            pins=pins,
            stiff=stiff,
            transform=state.shown,
            snapshots=[
                news.SnapshotNews(name, kept.shown, await self._words(kept)) for name, kept in history.snapshots
            ],
            collection=self.collection,
        )

    async def _words(self, state: State) -> str:
        return "" if state.shown is None else json.decode(await self.scene(state.shown), type=_Words).words

    def _shape(self, digest: str | None) -> news.ShapeNews | None:
        if digest is None:
            return None
        document = json.decode(self.folder.shape(digest), type=_ShapeDocument)
        return news.ShapeNews(document.name, [round(value, 5) for point in document.points for value in point])


def problem(seq: int, draft: bool, error: RiotError, side: str | None) -> news.Problem:
    """What cannot be, and where, if the error knows."""
    where, pin = [], None
    if isinstance(error, PinError):
        side, pin = error.side or side, error.pin
        where = [round(value, 5) for point in error.points for value in point]
    return news.Problem(seq, draft, str(error), side, where, pin)
