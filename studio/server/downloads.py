"""What can be made and taken away: settings, parts to be looked at, and files."""

from __future__ import annotations

import re
from pathlib import Path
from urllib.parse import quote

from starlette.requests import Request
from starlette.responses import FileResponse, Response
from starlette.routing import Route

from riot.errors import RiotError
from studio.live.session import LiveSession
from studio.server.answers import as_json, refuse, session_of
from studio.session.folder import is_name
from studio.work.making import PARTS, PUZZLE
from studio.work.pictures import MEDIA, PICTURES, PUZZLE_FILES, everything, picture, puzzle_archive
from studio.work.settings import settings

_PART = re.compile(r"[a-z]+(-[a-z0-9]+)*\.stl")


async def list_settings(_: Request) -> Response:
    """What can be set when a puzzle is made."""
    return as_json(settings())


async def part(request: Request) -> Response:
    """A part as binary STL."""
    name, key = request.path_params["part"], request.path_params["key"]
    try:
        folder = session_of(request).folder.path / "make"
    except KeyError:
        return refuse(404, "there is no such session")
    path = folder / key / PARTS / name
    if not is_name(key) or not _PART.fullmatch(name) or not path.is_file():
        return refuse(404, "there is no such part")
    return FileResponse(path, media_type="model/stl", headers={"cache-control": "private, max-age=3600, immutable"})


async def download(request: Request) -> Response:
    """A file of what is shown, or of what was made of it."""
    kind, key = request.path_params["kind"], request.query_params.get("make", "")
    if kind not in MEDIA:
        return refuse(404, f"there is no {kind}; there are {', '.join(MEDIA)}")
    try:
        session = session_of(request)
    except KeyError:
        return refuse(404, "there is no such session")
    shown = session.history.now.shown
    puzzle = session.folder.path / "make" / key / PUZZLE if is_name(key) else None
    if puzzle is not None and not puzzle.is_dir():
        puzzle = None
    if shown is None:
        return refuse(409, "there is no transform yet")
    if kind in PUZZLE_FILES and puzzle is None:
        return refuse(409, "nothing was made yet that passes its certificate")
    try:
        name = "--".join(filter(None, session.input_names)) or "transform"
        data = await _data(session, shown, kind, name, puzzle)
    except KeyError:
        return refuse(409, f"this puzzle has no {kind} files")
    except RiotError as error:
        return refuse(409, str(error))
    suffix = f"{kind}.zip" if kind in PUZZLE_FILES else kind
    disposition = f"attachment; filename*=UTF-8''{quote(f'{name}.{suffix}')}"
    return Response(data, media_type=MEDIA[kind], headers={"content-disposition": disposition})


async def _data(session: LiveSession, shown: str, kind: str, name: str, puzzle: Path | None) -> bytes:
    files, background = {shown: session.folder.transform(shown)}, session.workers.workshop
    if kind == "riot":
        return files[shown]
    if kind in PICTURES:
        return await background.run(picture, files, shown, kind)
    if kind == "zip":
        return await background.run(everything, files, shown, name, puzzle)
    assert puzzle is not None
    return await background.run(puzzle_archive, puzzle, kind)


ROUTES = [
    Route("/api/settings", list_settings, methods=["GET"]),
    Route("/api/sessions/{session}/make/{key}/parts/{part}", part, methods=["GET"]),
    Route("/api/sessions/{session}/download/{kind}", download, methods=["GET"]),
]
