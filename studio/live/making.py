"""Make the puzzle of what a session shows."""

from __future__ import annotations

import math

from msgspec import structs

from riot.errors import FabricationError, RiotError
from studio.live import news
from studio.live.session import LiveSession, problem
from studio.messages import Make
from studio.work.making import make_puzzle


async def make(session: LiveSession, request: Make) -> None:
    """Build, certify and write it, and tell what was found; or why it cannot be made."""
    shown = session.history.now.shown
    if shown is None:
        await session.tabs.tell(news.Refused(request.seq, "there is no transform yet to be made"))
        return
    await session.tabs.tell(news.Progress(request.seq, "make", "building and checking the parts"))
    files = {shown: session.folder.transform(shown)}
    folder = session.folder.path / "make"
    try:
        puzzle = await session.workers.workshop.run(make_puzzle, files, shown, request.settings, request.fix, folder)
    except FabricationError as error:
        await session.tabs.tell(news.MadeNot(request.seq, str(error), error.parameter or None, _finite(error.value)))
        return
    except RiotError as error:
        await session.tabs.tell(problem(request.seq, False, error, None))
        return
    root = f"/api/sessions/{session.folder.name}/make/{puzzle.key}/parts"
    parts = [news.PartNews(**structs.asdict(part), url=f"{root}/{part.name}.stl") for part in puzzle.parts]
    await session.tabs.tell(
        news.Made(
            request.seq,
            shown,
            puzzle.key,
            puzzle.passed,
            puzzle.changes,
            puzzle.scale,
            puzzle.thickness,
            puzzle.findings,
            parts,
        )
    )


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
