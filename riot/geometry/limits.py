"""Limits on untrusted files: they must be regular files of limited length (ours).

Limits on the content stand where the content is understood: pixels and contour points in
`riot.parameters` and `riot.geometry.silhouette`, drawn geometry in `riot.geometry.svg_document` and
`riot.geometry.svg_outline`, pieces in `riot.transform.riot_file`.
"""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

PICTURE_BYTES = 600_000_000
"""A picture file with more bytes is refused: the greatest number of pixels takes fewer, uncompressed."""

SVG_BYTES = 20_000_000
"""An SVG file with more bytes is refused."""

JSON_BYTES = 20_000_000
"""A file of JSON (a transform, pins) with more bytes is refused: its values would take some fifty times the memory."""


class TooManyBytes(ValueError):
    """A file is longer than it may be; the message says how long, and what the limit is."""


def check_file(path: Path, most: int) -> None:
    """Refuse what is longer than ``most`` bytes, and what is no file: reading a pipe or a device might never end.

    Raises `TooManyBytes`; OSError for what is missing or no file; ValueError for a path with a null character.

    >>> _ = Path("small.txt").write_text("hello")
    >>> check_file(Path("small.txt"), 5)
    """
    status = path.stat()
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(status.st_mode):
        raise OSError(errno.EINVAL, "not a file", str(path))
    if status.st_size > most:
        raise TooManyBytes(f"{status.st_size} bytes are more than the limit of {most}")


def read_bytes(path: Path, most: int) -> bytes:
    """Read a file of at most ``most`` bytes; errors as `check_file`.

    >>> _ = Path("small.txt").write_text("hello")
    >>> read_bytes(Path("small.txt"), 5)
    b'hello'
    """
    check_file(path, most)
    with path.open("rb") as file:
        data = file.read(most + 1)
    if len(data) > most:  # it grew
        raise TooManyBytes(f"more bytes than the limit of {most}")
    return data


def read_text(path: Path, most: int) -> str:
    """Read a file of at most ``most`` bytes as UTF-8, other bytes replaced by U+FFFD; errors as `check_file`.

    >>> from pathlib import Path
    >>> _ = Path("pins.json").write_text("[]")
    >>> read_text(Path("pins.json"), 100)
    '[]'
    """
    return read_bytes(path, most).decode("utf-8", errors="replace")
