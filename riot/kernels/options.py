"""The options of every compiled kernel."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numba

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile for the machine's CPU, cache on disk, release the GIL; IEEE arithmetic (no fast-math)."""
    return numba.njit(  # type: ignore[no-any-return]
        cache=True, nogil=True, fastmath=False, error_model="numpy", no_cfunc_wrapper=True
    )(function)


def inner(function: F) -> F:
    """Compile as `kernel`, for a function that only kernels call, many times, and that makes no array.

    Reference counts are off: to count those of a handful of arrays takes longer than the work of such a function.
    Python cannot call it, and its code is in the cache only as part of the kernels: each way into a function and each
    file costs time to compile.
    """
    return _inner(function, forceinline=False)


def inlined(function: F) -> F:
    """Compile as `inner`, and always into the body of the caller, so that the caller's loop can be vectorised."""
    return _inner(function, forceinline=True)


def _inner(function: F, *, forceinline: bool) -> F:
    return numba.njit(  # type: ignore[no-any-return]
        nogil=True, fastmath=False, error_model="numpy", _nrt=False, forceinline=forceinline,
        no_cpython_wrapper=True, no_cfunc_wrapper=True,
    )(function)  # fmt: skip
