"""The kernels of stages, compiled beside a run: a stage waits for its own, and the first stages for next to none."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import ExitStack
from types import TracebackType
from typing import TYPE_CHECKING, Self

from pipeline.plan.code_digest import modules_of
from pipeline.runtime.events import KernelsAwaited, Listener, Note
from pipeline.stages.stage import Stage
from riot import kernels

if TYPE_CHECKING:
    from riot.kernels.compiling.compilation import Compilation
    from riot.kernels.compiling.waiting import Waiting


class StageKernels:
    """Kernels that the cache lacks, compiled in processes of their own in the order in which stages need them.

    Entered as a context; when it is left, the processes end.
    """

    def __init__(self, stages: Sequence[Stage] = (), listen: Listener = lambda event: None) -> None:
        """``stages`` in the order of a run."""
        self._stages, self._listen = stages, listen
        self._stack = ExitStack()
        self._compilation: Compilation | None = None
        self._is_started = False
        self._failure = ""
        self._started = self._waited = 0.0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.close()

    def start(self, stage: Stage) -> None:
        """Begin to compile what the cache lacks for this stage and those after it; nothing the second time."""
        if self._is_started or stage not in self._stages:
            return
        self._is_started = True
        missing = kernels.compiling.cache.uncompiled()
        names = in_order(self._stages[self._stages.index(stage) :], missing) if missing else []
        if not names:
            return
        if kernels.compiling.cache.cache_folder() is None:
            self._tell(kernels.compiling.cache.NO_FOLDER)
            return
        self._started = time.perf_counter()
        self._listen(Note(f"compiling {len(names)} modules of kernels for this machine, once, beside the first stages"))
        self._compilation = self._stack.enter_context(kernels.compiling.compilation.open_compilation(names))

    def wait(self, stage: Stage) -> float:
        """Wait for the kernels of this stage, if they are being compiled; returns the seconds that it waited."""
        if self._compilation is None:
            return 0.0

        def report(waiting: Waiting) -> None:
            self._listen(KernelsAwaited(stage.name, waiting))

        began = time.perf_counter()
        self._compilation.wait(stage_kernels(stage), report)
        waited = time.perf_counter() - began
        self._waited += waited
        self._tell(self._compilation.failure)
        if self._compilation.is_over:
            seconds = time.perf_counter() - self._started
            self._listen(Note(f"kernels compiled in {seconds:.0f} s, of which stages waited {self._waited:.0f} s"))
            self._compilation = None
            self._stack.close()
        return waited

    def _tell(self, failure: str) -> None:
        if failure and not self._failure:
            self._listen(Note(kernels.warm.not_kept(failure)))
            self._failure = failure


def stage_kernels(stage: Stage) -> list[str]:
    """The modules of kernels that the code of a stage reaches, such as ``search``.

    >>> from pipeline.stages.all import BY_NAME
    >>> stage_kernels(BY_NAME["ingest"])
    ['simplify']
    """
    reached = modules_of(stage.module)
    return [name for name in kernels.compiling.uses.kernel_modules() if f"riot.kernels.{name}" in reached]


def in_order(stages: Sequence[Stage], names: Sequence[str]) -> list[str]:
    """Modules of kernels in the order in which stages need them, the longest of a stage first; others are left out."""
    ordered: dict[str, None] = {}
    for stage in stages:
        new = set(stage_kernels(stage)).intersection(names) - ordered.keys()
        ordered.update(dict.fromkeys(kernels.compiling.compilation.longest_first(sorted(new))))
    return list(ordered)
