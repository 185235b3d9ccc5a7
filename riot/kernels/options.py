"""The options of every compiled kernel."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numba

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile for the machine's CPU, cache on disk, release the GIL; IEEE arithmetic (no fast-math)."""
    return numba.njit(cache=True, nogil=True, fastmath=False, error_model="numpy")(function)  # type: ignore[no-any-return]


def inner(function: F) -> F:
    """Compile as `kernel`, for a function that only kernels call, many times, and that makes no array.

    Reference counts are off: to count those of a handful of arrays takes longer than the work of such a function.
    """
    return numba.njit(cache=True, nogil=True, fastmath=False, error_model="numpy", _nrt=False)(function)  # type: ignore[no-any-return]


def inlined(function: F) -> F:
    """Compile as `inner`, and always into the body of the caller, so that the caller's loop can be vectorised."""
    return numba.njit(  # type: ignore[no-any-return]
        cache=True, nogil=True, fastmath=False, error_model="numpy", _nrt=False, forceinline=True
    )(function)
