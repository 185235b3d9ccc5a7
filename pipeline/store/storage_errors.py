"""Room: what writes to a place that is full or read-only ends in, so that whoever is told knows which place it was."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Iterator

from pipeline.errors import PlaceError
from pipeline.store.filesystem.base import Place

TAKES_NO_MORE = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS})
"""Numbers of the errors of a place that is full, or may not be written: the next file fails as well."""


@contextlib.contextmanager
def writing_to(place: Place) -> Iterator[None]:
    """While files of a place are written; raises `PlaceError` if it takes no more, and other errors as they are."""
    try:
        yield
    except OSError as error:
        if error.errno not in TAKES_NO_MORE:
            raise
        raise PlaceError(f"cannot write to {place}: {os.strerror(error.errno)}") from error
