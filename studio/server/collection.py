"""The mined collection: names, silhouettes, and its shapes as inputs."""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from studio.live.search import put_shape
from studio.messages import Side
from studio.server.answers import as_json, refuse, session_of, studio_of
from studio.work.collection import collection_shape, silhouettes

MOST_OUTLINES = 400
"""Silhouettes in one answer."""

NONE_OPEN = "no collection is open: start with `riot studio --in RUN`"


async def listing(request: Request) -> Response:
    """Names, classes, reversibility."""
    listed = await studio_of(request).listing()
    return refuse(404, NONE_OPEN) if listed is None else as_json(listed)


async def outlines(request: Request) -> Response:
    """Silhouettes from a number on."""
    studio = studio_of(request)
    if studio.run_folder is None:
        return refuse(404, NONE_OPEN)
    first, count = (_number(request.query_params.get(name, "")) for name in ("first", "count"))
    if first is None or count is None:
        return refuse(422, "first and count are whole numbers")
    count = min(count, MOST_OUTLINES)
    paths = await studio.workers.background.run(silhouettes, studio.run_folder, first, count)
    return as_json({"first": first, "paths": paths})


async def choose(request: Request) -> Response:
    """Take a shape of the collection as an input."""
    studio, side, number = studio_of(request), request.path_params["side"], request.path_params["number"]
    if studio.run_folder is None:
        return refuse(404, NONE_OPEN)
    if side not in ("p", "q"):
        return refuse(404, "an input is p or q")
    chosen: Side = "p" if side == "p" else "q"
    try:
        session = session_of(request)
        shape = await studio.workers.background.run(collection_shape, studio.run_folder, number)
    except KeyError:
        return refuse(404, f"there is no shape {number}")
    await put_shape(session, chosen, shape, number)
    return as_json({})


def _number(text: str) -> int | None:
    return int(text) if text.isascii() and text.isdigit() and len(text) < 10 else None


ROUTES = [
    Route("/api/collection", listing, methods=["GET"]),
    Route("/api/collection/outlines", outlines, methods=["GET"]),
    Route("/api/sessions/{session}/shape/{side}/{number:int}", choose, methods=["POST"]),
]
