"""Follow the requests of a browser."""

from __future__ import annotations

from studio.live import news
from studio.live.alternatives import stream_alternatives
from studio.live.making import make
from studio.live.partners import stream_partners
from studio.live.search import set_pieces, swap
from studio.live.session import LiveSession
from studio.messages import (
    Alternatives,
    EditRequest,
    Forget,
    Make,
    Partners,
    Pieces,
    Redo,
    Request,
    Restore,
    Snapshot,
    Stop,
    Swap,
    Undo,
)


async def follow(session: LiveSession, request: Request) -> None:
    """Do what is asked for; answers go to all tabs of the session."""
    match request:
        case EditRequest(phase="move"):
            session.move(request)
        case EditRequest(seq, _, Swap()):
            await swap(session, seq)
        case EditRequest(seq, _, Pieces() as edit):
            await set_pieces(session, seq, edit)
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
            session.jobs.start("alternatives", session.told(seq, stream_alternatives(session, seq)))
        case Partners(seq):
            if session.collection is None:
                await session.tabs.tell(news.Refused(seq, "no collection is open: start with `riot studio --in RUN`"))
            else:
                work = stream_partners(session, session.collection, request)
                session.jobs.start("partners", session.told(seq, work))
        case Make(seq):
            session.jobs.start("make", session.told(seq, make(session, request)))
        case Stop():
            session.jobs.stop("alternatives", "partners", "make")
