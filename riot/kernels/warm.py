"""Compile kernels before they are needed: those that a command uses, and only where the cache lacks them."""

from __future__ import annotations

import importlib
import logging
import time
from collections.abc import Callable, Sequence

from riot.kernels import compiling  # lazy: most commands start no process
from riot.kernels.compiling.cache import NO_FOLDER, cache_folder, uncompiled
from riot.kernels.compiling.uses import kernel_modules, kernels_used_by
from riot.kernels.compiling.waiting import Waiting

Report = Callable[[str], None]

LOGGER = "riot.kernels.options"
SECONDS_BETWEEN_LINES = 5.0


def compile_used(report: Report, *modules: str) -> None:
    """Compile the kernels that ``modules`` of the project use, directly or not, if they are not in the cache.

    This takes half a minute once after installation and after a change; processes do it, one for each core. ``report``
    then gets a line now and then: how many modules are compiled, and how long the others will take.

    >>> compile_used(print, "riot.geometry.polyline")
    """
    if missing := uncompiled():
        needed = set(kernels_used_by(*modules))
        compile_modules([name for name in missing if name in needed], report)


def compile_modules(names: Sequence[str], report: Report) -> None:
    """Compile modules of kernels into the cache; ``report`` gets lines as for `compile_used`."""
    if not names:
        return
    failure = NO_FOLDER
    if cache_folder() is not None:
        lines = _Lines(report)
        with compiling.compilation.open_compilation(compiling.compilation.longest_first(names)) as compilation:
            compilation.wait(report=lines.show)
        lines.end()
        failure = compilation.failure
    if failure:
        report(not_kept(failure))


def not_kept(failure: str) -> str:
    """What a user is told, once, where the cache takes nothing; this process then says no more about it."""
    logging.getLogger(LOGGER).setLevel(logging.ERROR)
    return f"compiled kernels cannot be kept and are compiled again when they are needed: {failure}"


def warm_all(report: Report) -> None:
    """Make every kernel ready to run in this process; ``report`` gets lines as for `compile_used`."""
    compile_modules(uncompiled(), report)
    for name in kernel_modules():
        importlib.import_module(f"riot.kernels.{name}").warm()


class _Lines:
    """Lines for a user who waits for kernels."""

    def __init__(self, report: Report) -> None:
        self._report = report
        self._started = time.monotonic()
        self._next = self._started

    def show(self, waiting: Waiting) -> None:
        if time.monotonic() >= self._next and waiting.done < waiting.total:
            self._report(f"compiling kernels for this machine, once: {waiting}")
            self._next = time.monotonic() + SECONDS_BETWEEN_LINES

    def end(self) -> None:
        self._report(f"kernels compiled in {time.monotonic() - self._started:.0f} s")
