"""Errors of a full or read-only location: they name the location, and no other file can be written there either."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Iterator

from pipeline.errors import StorageError
from pipeline.store.location import Location

UNWRITABLE = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS})
"""Error numbers of a full disk, a used-up quota, a file size limit, and a read-only file system."""


@contextlib.contextmanager
def writing_to(location: Location) -> Iterator[None]:
    """Turn the errors of a full or read-only ``location`` into `StorageError`; other errors pass as they are."""
    try:
        yield
    except OSError as error:
        if error.errno not in UNWRITABLE:
            raise
        raise StorageError(f"cannot write to {location}: {os.strerror(error.errno)}") from error
