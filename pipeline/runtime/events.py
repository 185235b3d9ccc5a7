"""What a run tells while it runs; whoever shows progress listens to these and to nothing else."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from riot.kernels.compiling.waiting import Waiting


@dataclass(frozen=True)
class StageStarted:
    """A stage begins: work items in all, those already in the store, and those whose artifact was damaged."""

    stage: str
    unit: str
    total: int
    cached: int
    corrupt: int


@dataclass(frozen=True)
class ItemDone:
    """A work item of the stage has ended."""

    stage: str
    failed: bool


@dataclass(frozen=True)
class StageEnded:
    """A stage is over. Times are of this run, in seconds; ``stored_seconds`` is what all its artifacts once cost.

    ``blocked`` items were not tried because an input had failed.
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
