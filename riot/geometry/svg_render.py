"""SVG text → pixels, by resvg, with limits (ours).

resvg cannot be interrupted, and a file made to harm can have it fill the memory or end the process. What is more than
plain filled paths is therefore drawn by a process of its own, which this file is the program of: it has limits of time
and memory, and reads and writes by pipes alone. There are no fonts, so that all machines draw alike.
"""

from __future__ import annotations

import io
import subprocess
import sys

import resvg_py
from PIL import Image

_SECONDS = 10
"""Limit of the processor time of a drawing, seconds. Ours: some hundred times what a drawing by hand takes."""

_PATIENCE = 30
"""After so many times the limit even a process that got no processor is ended."""

_MEMORY = 2 * 2**30
"""Limit of the memory of a drawing, bytes. Ours: some five hundred layers of a page."""

_REFUSED = 3
"""Exit code of the process for a drawing that resvg refuses; its reason is what was written."""


class RenderError(ValueError):
    """The renderer refuses a drawing; the message says why."""


class TooCostly(RenderError):
    """A drawing takes more time or memory than the limits."""


def render(svg: str, apart: bool) -> Image.Image:
    """Draw an SVG text at the size that its root says: RGBA, 8 bits, opacity not multiplied in.

    Parameters
    ----------
    svg : str
    apart : bool
        In a process of its own, with limits of time and memory.

    Raises
    ------
    RenderError
        The drawing is broken, or `TooCostly`.
    OSError, MemoryError
        No process could be started, or the machine ended it.

    >>> render('<svg xmlns="http://www.w3.org/2000/svg" width="3" height="2"/>', apart=False).size
    (3, 2)
    """
    if not apart:
        try:
            data = _draw(svg)
        except ValueError as error:
            raise RenderError(str(error)) from error
    else:
        data = _draw_apart(svg)
    with Image.open(io.BytesIO(data), formats=("PNG",)) as image:
        return image.convert("RGBA")


def _draw(svg: str) -> bytes:
    return resvg_py.svg_to_bytes(svg_string=svg, skip_system_fonts=True)


def _draw_apart(svg: str) -> bytes:
    program = [sys.executable, "-I", __file__, str(_SECONDS)]
    try:
        done = subprocess.run(
            program, input=svg.encode(), capture_output=True, timeout=_SECONDS * _PATIENCE, check=False
        )
    except subprocess.TimeoutExpired as error:
        raise TooCostly(f"drawing it takes more than {_SECONDS} s") from error
    if done.returncode == 0:
        return done.stdout
    if done.returncode == _REFUSED:
        reason = done.stdout.decode(errors="replace")
        raise (TooCostly if "limit reached" in reason else RenderError)(reason)
    if done.returncode == -9:  # by the machine, for want of memory
        raise MemoryError("the process that draws SVG files was ended by the machine")
    raise TooCostly(f"drawing it takes more than {_SECONDS} s, or more than {_MEMORY >> 20} MB")


def _limit(seconds: int) -> None:
    try:
        import resource
    except ImportError:  # not on Windows, where only the time is limited
        return
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))


def _main() -> int:
    _limit(int(sys.argv[1]))
    try:
        sys.stdout.buffer.write(_draw(sys.stdin.buffer.read().decode()))
    except ValueError as error:
        sys.stdout.buffer.write(str(error).encode()[:500])
        return _REFUSED
    return 0


if __name__ == "__main__":
    sys.exit(_main())
