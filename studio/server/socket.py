"""A tab's connection: requests in, news out."""

from __future__ import annotations

import asyncio

from starlette.websockets import WebSocket, WebSocketDisconnect
from websockets.exceptions import WebSocketException

from riot.errors import FormatError
from studio.live import news
from studio.live.requests import follow
from studio.live.search import resume
from studio.live.session import LiveSession
from studio.live.studio import Studio
from studio.live.tabs import Send
from studio.messages import MAX_BYTES, RequestError, read_request


async def connect(websocket: WebSocket) -> None:
    """Serve a tab until it is closed."""
    studio: Studio = websocket.app.state.studio
    try:
        session = studio.session(websocket.path_params["session"])
    except (KeyError, FormatError):
        await websocket.close(1008, "there is no such session")
        return
    await websocket.accept()
    turn = asyncio.Lock()

    async def send(data: bytes) -> None:
        async with turn:
            try:
                await websocket.send_text(data.decode("utf-8"))
            except (WebSocketDisconnect, WebSocketException) as error:
                raise ConnectionError("the tab is closed") from error

    try:
        await session.join(send)
        await resume(session)
        while True:
            text = await websocket.receive_text()
            await _answer(session, text, send)
    except (WebSocketDisconnect, ConnectionError):
        pass
    finally:
        session.tabs.remove(send)


async def _answer(session: LiveSession, text: str, send: Send) -> None:
    try:
        if len(text) > MAX_BYTES:
            raise RequestError(f"a message of {len(text)} characters is longer than the limit of {MAX_BYTES}")
        request = read_request(text)
    except RequestError as error:
        await send(news.encoded(news.Refused(0, str(error))))
        return
    session.jobs.spawn(session.told(request.seq, follow(session, request)))
