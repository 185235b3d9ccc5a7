"""Progress on the terminal: a live bar a stage, and one line when the stage is over."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, SpinnerColumn, Task, TextColumn, TimeRemainingColumn
from rich.text import Text

from pipeline.runtime.events import Event, ItemDone, Listener, Note, StageEnded, StageStarted


class _Rate(ProgressColumn):
    """Work items a second."""

    def render(self, task: Task) -> Text:
        """See `ProgressColumn.render`."""
        return Text("" if task.speed is None else f"{task.speed:.2g}/s", style="cyan")


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
        TimeRemainingColumn(compact=True),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    ) as progress:
        tasks = {}

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
            elif isinstance(event, Note):
                # File names and messages, as they are: to rich, brackets are colours, and colons pictograms.
                console.print(event.text, highlight=False, markup=False, emoji=False)

        yield listen


def stage_line(event: StageEnded) -> str:
    """A finished stage in one line."""
    counts = [f"{event.cached} cached" if event.cached else "", f"{event.computed} computed" if event.computed else ""]
    counts += [f"{event.failed} failed" if event.failed else "", f"{event.blocked} blocked" if event.blocked else ""]
    done = ", ".join(count for count in counts if count) or "nothing to do"
    return f"{event.stage:<14} {done} in {event.seconds:.1f} s"
