"""Stream the best partners of a shape in the collection: their names at once, then each as a small transform."""

from __future__ import annotations

import time
from pathlib import Path

from msgspec import Raw

from riot.errors import RiotError
from studio.live import news
from studio.live.session import LiveSession
from studio.messages import Partners
from studio.work.collection import partners_of_input, partners_of_number, preview

COUNT = 24
"""Partners that are listed."""

PREVIEWS = 12
"""Of these so many are shown as small transforms."""


async def stream_partners(session: LiveSession, folder: Path, request: Partners) -> None:
    """Tell of the partners of a shape of the collection or of an input; ends when it is cancelled."""
    background, state = session.workers.background, session.history.now
    started = time.perf_counter()
    digest = state.p if request.side == "p" else state.q
    files = {} if digest is None else {digest: session.folder.shape(digest)}
    try:
        if request.shape is not None:
            partners = await background.run(partners_of_number, folder, request.shape, COUNT)
        elif request.side is not None and digest is not None:
            partners = await background.run(partners_of_input, folder, files, digest, COUNT)
        else:
            await session.tabs.tell(
                news.Refused(request.seq, "name a shape of the collection, or an input that is there")
            )
            return
    except KeyError:
        await session.tabs.tell(news.Refused(request.seq, f"the collection has no shape {request.shape}"))
        return
    except RiotError as error:
        await session.tabs.tell(news.Refused(request.seq, str(error)))
        return
    milliseconds = round(1e3 * (time.perf_counter() - started), 1)
    rows = [news.PartnerRow(partner.shape, partner.qcrs) for partner in partners]
    await session.tabs.tell(news.PartnersNews(request.seq, request.shape, milliseconds, rows))
    own: int | str | None = request.shape if request.shape is not None else digest
    assert own is not None
    for partner in partners[:PREVIEWS]:
        made = await background.run(preview, folder, own, files, partner.shape)
        if made is not None:
            await session.tabs.tell(news.PartnerNews(request.seq, partner.shape, Raw(made.scene)))
    await session.tabs.tell(news.PartnersEnd(request.seq))
