"""Progress on the terminal: a live bar a stage, and one line when the stage is over."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    ProgressColumn,
    SpinnerColumn,
    Task,
    TaskID,
    TextColumn,
    TimeRemainingColumn,
)
from rich.text import Text

from pipeline.runtime.events import Event, ItemDone, KernelsAwaited, Listener, Note, StageEnded, StageStarted

SECONDS_BETWEEN_LINES = 5.0


class _Rate(ProgressColumn):
    """Work items a second."""

    def render(self, task: Task) -> Text:
        """See `ProgressColumn.render`."""
        return Text("" if task.speed is None else f"{task.speed:.2g}/s", style="cyan")


class _Remaining(TimeRemainingColumn):
    """The time that remains: by the speed of the bar, if nothing knows better."""

    def render(self, task: Task) -> Text:
        """See `ProgressColumn.render`."""
        seconds = task.fields.get("seconds")
        return super().render(task) if seconds is None else Text(f"{seconds:.0f} s", style="progress.remaining")


class _AwaitedKernels:
    """The wait of a stage for its kernels: a bar, and plain lines where there are no bars."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._task: TaskID | None = None
        self._next_line = 0.0

    def show(self, event: KernelsAwaited) -> None:
        waiting = event.waiting
        if self._task is None:
            self._task = self._progress.add_task("kernels", total=waiting.total, cached=0, failed=0)
        self._progress.update(self._task, completed=waiting.done, total=waiting.total, seconds=waiting.seconds)
        if waiting.done == waiting.total:
            self._progress.remove_task(self._task)
            self._task, self._next_line = None, 0.0
        elif self._progress.disable and time.monotonic() >= self._next_line:
            self._progress.console.print(kernels_line(event))
            self._next_line = time.monotonic() + SECONDS_BETWEEN_LINES


@contextlib.contextmanager
def show_progress(console: Console) -> Iterator[Listener]:
    """A listener that draws bars on a terminal, and plain lines anywhere else."""
    with Progress(
        SpinnerColumn(),
        TextColumn("{task.description:<14}"),
        BarColumn(bar_width=30),
        TextColumn("{task.completed:.0f}/{task.total:.0f} done"),
        TextColumn("{task.fields[cached]} cached", style="green"),
        TextColumn("{task.fields[failed]} failed", style="red"),
        _Rate(),
        _Remaining(compact=True),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    ) as progress:
        tasks = {}
        awaited = _AwaitedKernels(progress)

        def listen(event: Event) -> None:
            if isinstance(event, StageStarted):
                missing = event.total - event.cached
                tasks[event.stage] = progress.add_task(event.stage, total=missing, cached=event.cached, failed=0)
                if event.corrupt:
                    console.print(f"{event.stage}: {event.corrupt} damaged in the store (corrupt), computed again")
            elif isinstance(event, ItemDone):
                task = tasks[event.stage]
                progress.advance(task)
                if event.failed:
                    progress.update(task, failed=progress.tasks[progress.task_ids.index(task)].fields["failed"] + 1)
            elif isinstance(event, StageEnded):
                progress.remove_task(tasks.pop(event.stage))
                console.print(stage_line(event), highlight=False)
            elif isinstance(event, KernelsAwaited):
                awaited.show(event)
            elif isinstance(event, Note):
                # File names and messages, as they are: to rich, brackets are colours, and colons pictograms.
                console.print(event.text, highlight=False, markup=False, emoji=False)

        yield listen


def kernels_line(event: KernelsAwaited) -> str:
    """The wait of a stage for its kernels in one line.

    >>> from riot.kernels.compiling.waiting import Waiting
    >>> kernels_line(KernelsAwaited("trunks", Waiting(3, 5, 11.7)))
    'trunks         waits for kernels: 3 of 5 modules, about 12 s remain'
    """
    return f"{event.stage:<14} waits for kernels: {event.waiting}"


def stage_line(event: StageEnded) -> str:
    """A finished stage in one line."""
    counts = [f"{event.cached} cached" if event.cached else "", f"{event.computed} computed" if event.computed else ""]
    counts += [f"{event.failed} failed" if event.failed else "", f"{event.blocked} blocked" if event.blocked else ""]
    done = ", ".join(count for count in counts if count) or "nothing to do"
    return f"{event.stage:<14} {done} in {event.seconds:.1f} s"
