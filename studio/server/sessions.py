"""What there is: sessions, and the scenes of their transforms."""

from __future__ import annotations

from datetime import UTC, datetime

from msgspec import Raw
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from studio.server.answers import as_json, refuse, session_of, studio_of


async def list_sessions(request: Request) -> Response:
    """All sessions, the one that changed last first."""
    studio = studio_of(request)
    current = studio.current()
    rows = []
    for folder in studio.folders():
        names = studio.names(folder.name)
        changed = datetime.fromtimestamp(folder.changed(), UTC).isoformat(timespec="seconds")
        rows.append({"id": folder.name, "p": names[0], "q": names[1], "changed": changed})
    return as_json({"sessions": rows, "current": current})


async def new_session(request: Request) -> Response:
    """Begin a new one."""
    return as_json({"id": studio_of(request).new().folder.name})


async def scene(request: Request) -> Response:
    """The scene of a transform of a session."""
    try:
        return as_json(Raw(await session_of(request).view.scene(request.path_params["transform"])))
    except KeyError:
        return refuse(404, "there is no such transform")


async def textures(request: Request) -> Response:
    """Images of the pieces of the transform that is shown."""
    try:
        return as_json(Raw(await session_of(request).textures(request.path_params["transform"])))
    except KeyError:
        return refuse(404, "this transform is not shown")


ROUTES = [
    Route("/api/sessions", list_sessions, methods=["GET"]),
    Route("/api/sessions", new_session, methods=["POST"]),
    Route("/api/sessions/{session}/scene/{transform}", scene, methods=["GET"]),
    Route("/api/sessions/{session}/textures/{transform}", textures, methods=["GET"]),
]
