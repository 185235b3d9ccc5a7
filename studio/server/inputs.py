"""Files that a person gives, read by the guarded readers of `riot.geometry`; their names open nothing."""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from riot.errors import RiotError, SilhouetteError
from studio.live.search import put_file
from studio.server.answers import as_json, refuse, session_of

MAX_UPLOAD = 32_000_000
"""A file with more bytes is refused."""

UNPROCESSABLE, TOO_LARGE = 422, 413


class UploadTooLarge(Exception):
    """More bytes came than may."""


async def body_of(request: Request, most: int) -> bytes:
    """The body of a request; raises `UploadTooLarge` as soon as more than ``most`` bytes have come."""
    length = request.headers.get("content-length", "0")
    if length.isascii() and length.isdigit() and int(length) > most:
        raise UploadTooLarge
    body = bytearray()
    async for chunk in request.stream():
        body += chunk
        if len(body) > most:
            raise UploadTooLarge
    return bytes(body)


async def put_input(request: Request) -> Response:
    """Take a file as one of the two shapes, or as the transform."""
    side = request.path_params["side"]
    if side not in ("p", "q"):
        return refuse(404, "an input is p or q")
    try:
        session = session_of(request)
    except KeyError:
        return refuse(404, "there is no such session")
    try:
        data = await body_of(request, MAX_UPLOAD)
        doubts = await put_file(session, side, data, request.query_params.get("name", ""))
    except UploadTooLarge:
        return refuse(TOO_LARGE, f"the file has more than {MAX_UPLOAD // 1_000_000} MB: make it smaller", "too-large")
    except SilhouetteError as error:
        return refuse(UNPROCESSABLE, str(error), error.reason)
    except RiotError as error:
        return refuse(UNPROCESSABLE, str(error))
    return as_json({"doubts": list(doubts)})


ROUTES = [Route("/api/sessions/{session}/input/{side}", put_input, methods=["PUT"])]
