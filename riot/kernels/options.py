"""The options of every compiled kernel, and its cache: a disk that takes nothing stops no kernel."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any, TypeVar

import numba
from numba.core.caching import FunctionCache

from riot.kernels.compiling.cache import shared_code

F = TypeVar("F", bound=Callable[..., Any])

unkept: list[str] = []
"""Why kernels that this process compiled are not in the cache; `riot.kernels.compiling` asks."""


def kernel(function: F) -> F:
    """Compile for the machine's CPU, cache on disk, release the GIL; IEEE arithmetic (no fast-math)."""
    return _kept(function, _compiled(function, no_cfunc_wrapper=True))


def inner(function: F) -> F:
    """Compile as `kernel`, for a function that only kernels call, many times, and that makes no array.

    Reference counts are off: to count those of a handful of arrays takes longer than the work of such a function.
    Python cannot call it, and its code is in the cache only as part of the kernels: each way into a function and each
    file costs time to compile.
    """
    return _compiled(function, _nrt=False, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def inlined(function: F) -> F:
    """Compile as `inner`, and always into the body of the caller, so that the caller's loop can be vectorised."""
    return _compiled(function, _nrt=False, forceinline=True, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def _compiled(function: F, **options: bool) -> F:
    return numba.njit(nogil=True, fastmath=False, error_model="numpy", **options)(function)  # type: ignore[no-any-return]


def _kept(function: F, dispatcher: F) -> F:
    """The compiled function, kept on disk."""
    if hasattr(dispatcher, "py_func"):  # not with NUMBA_DISABLE_JIT
        try:
            dispatcher._cache = _Cache(function)  # type: ignore[attr-defined]
        except RuntimeError as error:  # Numba knows no folder that can be written
            _tell(str(error))
    return dispatcher


class _Cache(FunctionCache):  # type: ignore[misc]
    """Numba's cache, where what cannot be read is compiled again, and what cannot be written stays in memory.

    Numba compiles a kernel again when its own file has changed; so does this when a file has that all kernels share.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        self._cache_file._source_stamp = self._cache_file._source_stamp, shared_code()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """See `numba.core.caching.Cache`."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # a damaged file can raise anything
            self._write(self.flush)
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """See `numba.core.caching.Cache`."""
        self._write(super().save_overload, sig, data)

    def _write(self, write: Callable[..., None], *arguments: Any) -> None:
        try:
            write(*arguments)
        except OSError as error:
            _tell(error.strerror or str(error))


def _tell(reason: str) -> None:
    if not unkept:
        logging.getLogger(__name__).warning("compiled kernels cannot be kept, and stay in memory: %s", reason)
    unkept.append(reason)
