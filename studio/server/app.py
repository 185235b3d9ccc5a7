"""The web application of a studio: a page, what it asks for, and one connection a tab."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from starlette.applications import Starlette
from starlette.middleware.gzip import GZipMiddleware
from starlette.requests import Request
from starlette.responses import FileResponse
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp

from studio.live.studio import Studio
from studio.server import collection, downloads, inputs, sessions
from studio.server.guard import Guard
from studio.server.socket import connect

STATIC = Path(__file__).parents[1] / "static"


def make_app(studio: Studio, port: int, token: str) -> ASGIApp:
    """The application, as it is served on a port of this machine to who knows the token."""

    @asynccontextmanager
    async def running(_: Starlette) -> AsyncIterator[None]:
        yield
        studio.close()

    app = Starlette(
        lifespan=running,
        routes=[
            Route("/", page),
            *sessions.ROUTES,
            *inputs.ROUTES,
            *collection.ROUTES,
            *downloads.ROUTES,
            WebSocketRoute("/ws/{session}", connect),
            Mount("/static", StaticFiles(directory=STATIC)),
        ],
    )
    app.state.studio = studio
    return Guard(GZipMiddleware(app, minimum_size=1000), port, token)


async def page(_: Request) -> FileResponse:
    """The page; what it shows comes by its connection."""
    return FileResponse(STATIC / "index.html")
