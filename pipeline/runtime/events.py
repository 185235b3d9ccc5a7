"""What a run tells while it runs; whoever shows progress listens to these and to nothing else."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from riot.kernels.compiling.waiting import Waiting


@dataclass(frozen=True)
class StageStarted:
    """A stage begins: work items in all, those already in the store, and those whose artifact was damaged.

    ``counted`` is what progress counts, "shapes" or "pairs"; ``amount`` is how many of them the items concern that are
    computed now.
    """

    stage: str
    unit: str
    total: int
    cached: int
    corrupt: int
    counted: str = ""
    amount: int = 0


@dataclass(frozen=True)
class ItemDone:
    """A work item of the stage has ended, which concerns this ``amount`` of shapes or pairs."""

    stage: str
    failed: bool
    amount: int = 1


@dataclass(frozen=True)
class StageEnded:
    """A stage is over. Times are of this run, in seconds; ``stored_seconds`` is what all its artifacts once cost.

    The longest chain of work items, one after the other, took ``critical_seconds``: no number of workers is faster.
    Workers had ``worker_seconds`` in all, of which they worked ``busy_seconds``, and read and wrote so many MiB.
    ``blocked`` items were not tried because an input had failed. All items concern ``amount`` shapes or pairs, as
    ``counted`` says, and those that were in the store ``stored_amount`` of them.
    """

    stage: str
    total: int
    cached: int
    computed: int
    failed: int
    blocked: int
    seconds: float
    cpu_seconds: float
    stored_seconds: float
    peak_mb: float
    counted: str = ""
    amount: int = 0
    stored_amount: int = 0
    critical_seconds: float = 0.0
    busy_seconds: float = 0.0
    worker_seconds: float = 0.0
    read_mb: float = 0.0
    written_mb: float = 0.0

    @property
    def idle(self) -> float | None:
        """The share of the workers' time in which they had nothing to do; None if they were not needed."""
        return max(0.0, 1.0 - self.busy_seconds / self.worker_seconds) if self.worker_seconds else None


@dataclass(frozen=True)
class Note:
    """A line for the user."""

    text: str


@dataclass(frozen=True)
class KernelsAwaited:
    """A stage waits for its kernels: how many modules of them are compiled, and how long the others will take."""

    stage: str
    waiting: Waiting


Event = StageStarted | ItemDone | StageEnded | KernelsAwaited | Note
Listener = Callable[[Event], None]
