"""Answers of the server as JSON."""

from __future__ import annotations

from msgspec import Raw, Struct, json
from starlette.requests import Request
from starlette.responses import Response

from studio.live.session import LiveSession
from studio.live.studio import Studio


def as_json(content: Struct | dict[str, object] | Raw, status: int = 200) -> Response:
    """A JSON answer."""
    return Response(json.encode(content), status, media_type="application/json", headers={"cache-control": "no-store"})


def refuse(status: int, words: str, reason: str = "") -> Response:
    """An answer that says why not."""
    return as_json({"words": words, "reason": reason}, status)


def studio_of(request: Request) -> Studio:
    """The studio that a request is for."""
    studio: Studio = request.app.state.studio
    return studio


def session_of(request: Request) -> LiveSession:
    """The session that a request's path names; KeyError if there is none."""
    return studio_of(request).session(request.path_params["session"])
