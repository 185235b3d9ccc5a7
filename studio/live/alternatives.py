"""Stream other transforms of the two shapes of a session, the most promising first."""

from __future__ import annotations

from msgspec import Raw, Struct, json

from riot.errors import RiotError
from studio.live import news
from studio.live.session import LiveSession
from studio.live.view import documents
from studio.work.search import alternative, count_alternatives


class _Shown(Struct):
    words: str
    pieces: list[Raw]


async def stream_alternatives(session: LiveSession, seq: int) -> None:
    """Tell of one after the other as they are computed; ends when it is cancelled or the shapes are others."""
    state = session.history.now
    files = documents(session.folder, state)
    background = session.workers.background
    try:
        count = await background.run(count_alternatives, state, files)
    except RiotError as error:
        await session.tabs.tell(news.AlternativesEnd(seq, 0, str(error)))
        return
    rank = 0
    for number in range(count):
        made = await background.run(alternative, state, files, number)
        await session.tabs.tell(news.Progress(seq, "alternatives", "trying other trunks", number + 1, count))
        if made is None:
            continue
        session.folder.put_transform(made.text)
        shown = json.decode(made.scene, type=_Shown)
        await session.tabs.tell(
            news.AlternativeNews(
                seq, rank, made.digest, len(shown.pieces), round(made.worth, 5), shown.words, Raw(made.scene)
            )
        )
        rank += 1
    await session.tabs.tell(news.AlternativesEnd(seq, rank))
