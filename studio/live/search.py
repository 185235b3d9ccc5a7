"""Inputs of a session, and the search for a transform of them."""

from __future__ import annotations

import time

from msgspec import structs

from riot.errors import RiotError
from studio.live import news
from studio.live.session import LiveSession, problem
from studio.live.view import documents
from studio.messages import Pieces, Side
from studio.session.state import State
from studio.work.answer import Answer
from studio.work.reading import ShapeFile, is_transform, open_transform, read_shape
from studio.work.search import best_transform, first_transform

WORDS = ("looking for a transform", "bending both shapes a little")
"""What a search does in its two steps."""


async def put_file(session: LiveSession, side: Side, data: bytes, name: str) -> tuple[str, ...]:
    """Take a file that was given; returns why its outline may be wrong.

    Raises `riot.errors.RiotError` in words for the person if it cannot be read.
    """
    if is_transform(data):
        await _open(session, data, name)
        return ()
    shape = await session.workers.live.run(read_shape, data, name)
    if shape.colours:
        session.folder.put_picture(shape.digest, data)
    await put_shape(session, side, shape)
    return shape.doubts


async def put_shape(session: LiveSession, side: Side, shape: ShapeFile, number: int | None = None) -> None:
    """Take a shape as an input, of the collection if it has a number there; look for transforms if there are two."""
    async with session.turn:
        session.folder.put_shape(shape.text)
        state = structs.replace(_without_transform(session.history.now), step=f"choose {shape.name}")
        state = structs.replace(state, **{side: shape.digest, f"number_{side}": number, f"stiff_{side}": ()})
        await _begin(session, state, 0)


async def swap(session: LiveSession, seq: int) -> None:
    """Let the two shapes change places."""
    async with session.turn:
        now = _without_transform(session.history.now)
        swapped = {
            f"{name}{one}": getattr(now, f"{name}{other}")
            for name in ("", "number_", "stiff_")
            for one, other in ("pq", "qp")
        }
        await _begin(session, structs.replace(now, step="swap", **swapped), seq)


async def set_pieces(session: LiveSession, seq: int, edit: Pieces) -> None:
    """Look for transforms with other numbers of pieces."""
    counts = None if edit.least is None or edit.most is None else (edit.least, edit.most)
    if counts is not None and counts[0] > counts[1]:
        await session.tabs.tell(news.Refused(seq, "the least number of pieces is greater than the most"))
        return
    async with session.turn:
        now = _without_transform(session.history.now)
        await _begin(session, structs.replace(now, step="number of pieces", pieces=counts), seq)


async def resume(session: LiveSession) -> None:
    """Look for a transform of a state that has none, because the server ended before it was found."""
    if not session.jobs.has("transform"):
        _search(session, session.history.now, 0)


def _without_transform(state: State) -> State:
    return structs.replace(state, root=None, base=None, shown=None, pins_p=(), pins_q=())


async def _open(session: LiveSession, data: bytes, name: str) -> None:
    started = time.perf_counter()
    answer, inputs = await session.workers.live.run(open_transform, data, name)
    async with session.turn:
        for shape in inputs:
            session.folder.put_shape(shape.text)
        session.view.keep(answer.shown)
        await session.commit(session.history.step(answer.state), 0)
        await session.show(0, started, answer, draft=False)
    await session.plan_motion(answer.shown.digest)


async def _begin(session: LiveSession, state: State, seq: int) -> None:
    await session.commit(session.history.step(state), seq)
    _search(session, state, seq)


def _search(session: LiveSession, state: State, seq: int) -> None:
    if state.p is not None and state.q is not None and state.shown is None:
        session.jobs.start("transform", session.told(seq, _found(session, state, seq)))


async def _found(session: LiveSession, state: State, seq: int) -> None:
    """Show a transform soon, and then the best one; each completes the state that asked for it."""
    started, current = time.perf_counter(), state
    failure: RiotError | None = None
    draft: Answer | None = None
    steps = (first_transform,) if state.weight is None else (first_transform, best_transform)
    for done, (find, words) in enumerate(zip(steps, WORDS, strict=False)):
        await session.tabs.tell(news.Progress(seq, "transform", words, done, len(steps)))
        try:
            answer = await session.workers.live.run(find, state, documents(session.folder, state))
        except RiotError as error:
            failure = error
            continue
        async with session.turn:
            if session.history.now is not current:
                return  # the person went on with what was shown
            session.view.keep(answer.shown)
            await session.commit(session.history.settled(current, answer.state), seq)
            current = answer.state
            draft = answer if done + 1 < len(steps) else None
            await session.show(seq, started, answer, draft=draft is not None)
    if draft is not None:  # what was shown soon is the best there is
        await session.show(seq, started, draft, draft=False)
    if current.shown is not None:
        await session.plan_motion(current.shown)
    elif failure is not None:
        await session.tabs.tell(problem(seq, False, failure, None))
