"""Follow the requests of a browser."""

from __future__ import annotations

from studio.live import news
from studio.live.alternatives import stream_alternatives
from studio.live.session import LiveSession
from studio.messages import (
    Alternatives,
    EditRequest,
    Forget,
    Redo,
    Request,
    Restore,
    Snapshot,
    Stop,
    Undo,
)


async def follow(session: LiveSession, request: Request) -> None:
    """Do what is asked for; answers go to all tabs of the session."""
    match request:
        case EditRequest(phase="move"):
            session.move(request)
        case EditRequest():
            await session.release(request)
        case Undo(seq):
            await session.go(seq, lambda history: history.undone())
        case Redo(seq):
            await session.go(seq, lambda history: history.redone())
        case Snapshot(seq, name):
            await session.go(seq, lambda history: history.snapshot(name))
        case Restore(seq, name):
            await session.go(seq, lambda history: history.restored(name))
        case Forget(seq, name):
            await session.go(seq, lambda history: history.forgotten(name))
        case Alternatives(seq):
            session.start("alternatives", stream_alternatives(session, seq))
        case Stop():
            session.stop()
        case _:
            await session.tell(news.Refused(request.seq, "not known yet"))
