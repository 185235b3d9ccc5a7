"""The command `riot studio [A B | FILE.riot | --in RUN]`: work on a transform in the browser. Ours."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import secrets
import socket
import webbrowser
from pathlib import Path

import platformdirs
import uvicorn

from pipeline.match.search import open_mined
from riot.cli.output import Output
from riot.cli.parser import DONE, INTERRUPTED, Parser, UsageError
from riot.kernels.warm import compile_used
from studio.live.search import put_file
from studio.live.studio import Studio
from studio.messages import Side
from studio.server.app import make_app

LOOPBACK = "127.0.0.1"
SIDES: tuple[Side, Side] = ("p", "q")
USED = ("studio.work.warm", "studio.work.reading")
"""Modules whose kernels are compiled before the server starts."""


def add_options(parser: Parser) -> None:
    """See `riot.cli.command.CommandModule`."""
    parser.add_argument(
        "files",
        type=Path,
        nargs="*",
        metavar="FILE",
        help="two pictures or SVG files, or one .riot file (default: none)",
    )
    parser.add_argument("--in", dest="run_folder", type=Path, metavar="RUN", help="a run whose shapes can be chosen")
    parser.add_argument("--port", type=_port, default=0, metavar="N", help="serve on this port (default: a free one)")
    parser.add_argument("--no-browser", action="store_true", help="only print the address")
    parser.add_argument("--folder", type=Path, metavar="DIR", help="keep sessions here (default: the user's data)")


def run(chosen: argparse.Namespace, output: Output) -> int:
    """See `riot.cli.command.CommandModule`."""
    if len(chosen.files) > 2:
        raise UsageError(f"give two pictures or one .riot file, not {len(chosen.files)} files")
    if chosen.run_folder is not None:
        open_mined(chosen.run_folder)  # here, where it can be told why not
    given = [path.read_bytes() for path in chosen.files]
    names = [path.name for path in chosen.files]
    compile_used(output.note, *USED)
    root = chosen.folder or Path(platformdirs.user_data_dir("riot")) / "studio"
    studio = Studio(root, chosen.run_folder)
    with contextlib.closing(_listen(chosen.port)) as listening:
        port = listening.getsockname()[1]
        token = secrets.token_urlsafe(24)
        address = f"http://{LOOPBACK}:{port}/?token={token}"
        app = make_app(studio, port, token)
        server = uvicorn.Server(uvicorn.Config(app, log_level="warning", ws="websockets-sansio", server_header=False))
        output.show(f"The studio is at {address}", "Ctrl-C ends it; everything is kept.")
        with contextlib.suppress(KeyboardInterrupt):
            asyncio.run(_serve(server, listening, studio, given, names, None if chosen.no_browser else address))
            return DONE
    return INTERRUPTED


async def _serve(
    server: uvicorn.Server,
    listening: socket.socket,
    studio: Studio,
    given: list[bytes],
    names: list[str],
    address: str | None,
) -> None:
    studio.warm()
    serving = asyncio.create_task(server.serve([listening]))
    if given:
        session = studio.new()
        for side, data, name in zip(SIDES, given, names, strict=False):
            await put_file(session, side, data, name)
    if address is not None:
        await asyncio.to_thread(webbrowser.open, address)
    await serving


def _listen(port: int) -> socket.socket:
    """A socket on this machine alone."""
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    listening.bind((LOOPBACK, port))
    listening.listen()  # who is told the address may come at once
    return listening


def _port(text: str) -> int:
    if not (text.isascii() and text.isdigit() and int(text) < 65536):
        raise argparse.ArgumentTypeError(f"{text!r} is no port: give a number from 0 to 65535")
    return int(text)
