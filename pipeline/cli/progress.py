"""Progress on the terminal: a bar for each stage, and a line when it is over. Elsewhere a line every few seconds."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, SpinnerColumn, Task, TextColumn
from rich.text import Text

from pipeline.runtime.events import Event, ItemDone, KernelsAwaited, Listener, Note, StageEnded, StageStarted

SECONDS_BETWEEN_LINES = 5.0
"""Seconds between the lines of a stage where there is no terminal (ours)."""


@dataclass
class Advance:
    """How far a stage is, or the kernels that it waits for."""

    name: str
    total: int
    counted: str
    began: float
    done: int = 0
    failed: int = 0
    estimate: float | None = None
    """Seconds that remain, where something knows better than the speed so far."""

    def remaining(self, now: float) -> float | None:
        """Seconds that remain at the speed so far; None before anything is done.

        >>> Advance("trunks", total=40, counted="shapes", began=100.0, done=10).remaining(now=103.0)
        9.0
        """
        if self.estimate is not None or not self.done:
            return self.estimate
        return (now - self.began) * (self.total - self.done) / self.done

    def words(self, now: float) -> str:
        """Such as ``10 of 40 shapes, about 9 s left``.

        >>> Advance("trunks", total=40, counted="shapes", began=100.0, done=10).words(now=103.0)
        '10 of 40 shapes, about 9 s left'
        """
        remaining = self.remaining(now)
        amount = f"{self.done:,} of {self.total:,} {self.counted}".rstrip() if self.total > 1 or self.counted else ""
        left = f"{duration(now - self.began)} so far" if remaining is None else f"about {duration(remaining)} left"
        return ", ".join(filter(None, [amount, f"{self.failed} failed" if self.failed else "", left]))


@dataclass
class _Lines:
    """Prints where the stage is, every few seconds, from a thread of its own."""

    show: Callable[[], None]
    _over: threading.Event = field(default_factory=threading.Event)

    def __enter__(self) -> None:
        self._thread = threading.Thread(target=self._run, daemon=True, name="progress")
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._over.wait(SECONDS_BETWEEN_LINES):
            self.show()


class _Words(ProgressColumn):
    """Where the stage is, in words."""

    def render(self, task: Task) -> Text:
        """See `ProgressColumn.render`."""
        advance: Advance = task.fields["advance"]
        return Text(advance.words(time.monotonic()), no_wrap=True, overflow="ellipsis")


class _Shown:
    """What is shown: above, in lines, what is over; below, in a bar, the stage that is at work."""

    def __init__(self, console: Console, bars: Progress) -> None:
        self._console, self._bars = console, bars
        self._stage: Advance | None = None
        self._at_work: Advance | None = None
        """The stage, or the kernels that it waits for."""

    def listen(self, event: Event) -> None:
        """Show an event of the run."""
        now = time.monotonic()
        if isinstance(event, StageStarted):
            total = event.amount if event.counted else event.total - event.cached
            self._stage = Advance(event.stage, total, event.counted, now)
            self._turn_to(self._stage)
            if event.corrupt:
                self._print(f"{event.stage}: {event.corrupt} damaged in the store (corrupt), computed again")
        elif isinstance(event, ItemDone) and self._stage is not None:
            self._stage.done += event.amount if self._stage.counted else 1
            self._stage.failed += event.failed
        elif isinstance(event, KernelsAwaited):
            self._await_kernels(event, now)
        elif isinstance(event, StageEnded):
            self._stage = None
            self._turn_to(None)
            self._print(stage_line(event))
        elif isinstance(event, Note):
            self._print(event.text)
        if self._at_work is not None:
            for task in self._bars.task_ids:
                self._bars.update(task, completed=self._at_work.done, total=self._at_work.total)

    def print_line(self) -> None:
        """Print where the stage is."""
        at_work = self._at_work
        if at_work is not None and at_work.total:
            self._print(f"{at_work.name:<14} {at_work.words(time.monotonic())}")

    def _await_kernels(self, event: KernelsAwaited, now: float) -> None:
        waiting = event.waiting
        if self._at_work is None or self._at_work is self._stage:
            self._turn_to(Advance("kernels", waiting.total, "modules compiled", now))
        assert self._at_work is not None
        self._at_work.done, self._at_work.estimate = waiting.done, waiting.seconds
        if waiting.done == waiting.total:
            if self._stage is not None:
                self._stage.began = now
            self._turn_to(self._stage)

    def _turn_to(self, advance: Advance | None) -> None:
        self._at_work = advance
        for task in self._bars.task_ids:
            self._bars.remove_task(task)
        if advance is not None and advance.total:
            self._bars.add_task(advance.name, total=advance.total, advance=advance)

    def _print(self, text: str) -> None:
        # File names and messages, as they are: to rich, brackets are colours, and colons pictograms.
        self._console.print(text, highlight=False, markup=False, emoji=False, soft_wrap=True)


@contextlib.contextmanager
def show_progress(console: Console) -> Iterator[Listener]:
    """A listener that draws a bar on a terminal, and prints a line every few seconds anywhere else."""
    bars = Progress(
        SpinnerColumn(),
        TextColumn("{task.description:<13}"),
        BarColumn(bar_width=20),
        _Words(),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    )
    shown = _Shown(console, bars)
    with bars, contextlib.nullcontext() if console.is_terminal else _Lines(shown.print_line):
        yield shown.listen


def stage_line(event: StageEnded) -> str:
    """A finished stage in one line.

    >>> counts = {"total": 54, "cached": 0, "computed": 54, "failed": 0, "blocked": 0}
    >>> costs = {"seconds": 12.61, "cpu_seconds": 24.0, "stored_seconds": 24.0, "peak_mb": 300.0}
    >>> stage_line(StageEnded("trunks", **counts, **costs, counted="shapes", amount=1400))
    'trunks         1,400 shapes in 12.6 s'
    """
    whole = f"{event.amount:,} {event.counted}" if event.counted and event.total else ""
    if event.cached == event.total:
        return f"{event.stage:<14} {f'{whole}, in the store'.lstrip(', ') if event.total else 'nothing to do'}"
    stored = f"{event.stored_amount:,} of them in the store" if event.counted and event.cached else ""
    failed = f"{event.failed} failed" if event.failed else ""
    blocked = f"{event.blocked} blocked" if event.blocked else ""
    counts = ", ".join(filter(None, [whole, stored, failed, blocked]))
    return f"{event.stage:<14} {counts or 'done'} in {event.seconds:.1f} s"


def duration(seconds: float) -> str:
    """Seconds in words, rounded to what matters.

    >>> duration(0.4), duration(12.3), duration(100), duration(4000)
    ('1 s', '12 s', '1 min 40 s', '1 h 6 min')
    """
    whole = max(1, round(seconds))
    if whole < 60:
        return f"{whole} s"
    minutes, rest = divmod(whole, 60)
    return f"{minutes} min {rest} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"
