"""Errors of the machine, and errors of a file, which alone say something about it whenever it is read (ours)."""

from __future__ import annotations

import errno

_OF_THE_FILE = frozenset(
    {
        errno.ENOENT,
        errno.ENOTDIR,
        errno.EISDIR,
        errno.EACCES,
        errno.EPERM,
        errno.ELOOP,
        errno.ENAMETOOLONG,
        errno.EILSEQ,
        errno.EINVAL,
    }
)
"""Nothing there, nothing that may be read, or no file: the same the next time, unless somebody mends it."""


def is_of_machine(error: BaseException) -> bool:
    """Whether an error tells of the machine (memory, descriptors, a failing disk or network), not of a file's content.

    Such an error may be gone the next time, and must not be kept as what is known of the file. Numbers of errors that
    are not known to be the file's count as the machine's; an OSError without a number is a decoder's, of its data.
    """
    if isinstance(error, OSError):
        return error.errno is not None and error.errno not in _OF_THE_FILE
    return isinstance(error, MemoryError)
