"""Distinguish errors of the machine (memory, a failing disk) from errors of a file (ours).

An error of a file is the same whenever the file is read, so it may be stored as the result of reading it.
"""

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
"""The file is missing, may not be read, or is none: the same the next time, unless somebody mends it."""


def is_of_machine(error: BaseException) -> bool:
    """Whether an error comes from the machine (memory, descriptors, a failing disk or network), not from a file.

    Such an error may not occur the next time, and must not be stored as the result of reading the file. Error numbers
    other than the known ones of a file count as the machine's; an OSError without a number comes from a decoder, of its
    data.

    >>> is_of_machine(FileNotFoundError(errno.ENOENT, "missing")), is_of_machine(MemoryError())
    (False, True)
    """
    if isinstance(error, OSError):
        return error.errno is not None and error.errno not in _OF_THE_FILE
    return isinstance(error, MemoryError)
