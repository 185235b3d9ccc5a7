"""Files that anybody may have made: read only if they are files, and no more of them than they may have (ours).

What a content may ask for is limited where it is understood: pixels and contour points in `riot.parameters.method` and
`riot.geometry.silhouette`, drawn geometry in `riot.geometry.svg_document` and `riot.geometry.svg_outline`, pieces in
`riot.transform.riot_file`.
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
    """Raise `TooManyBytes`, or OSError for what is no file: a pipe or a device could be waited for without end.

    ValueError for a path with a null character.
    """
    found = path.stat()
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(found.st_mode):
        raise OSError(errno.EINVAL, "not a file", str(path))
    if found.st_size > most:
        raise TooManyBytes(f"{found.st_size} bytes are more than the limit of {most}")


def read_bytes(path: Path, most: int) -> bytes:
    """The content of a file of at most ``most`` bytes; errors as `check_file`."""
    check_file(path, most)
    with path.open("rb") as file:
        data = file.read(most + 1)
    if len(data) > most:  # it grew
        raise TooManyBytes(f"more bytes than the limit of {most}")
    return data


def read_text(path: Path, most: int) -> str:
    """The content of a file of at most ``most`` bytes as UTF-8 with whatever else replaced; errors as `check_file`."""
    return read_bytes(path, most).decode("utf-8", errors="replace")
