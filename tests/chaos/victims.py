"""What runs in a victim, how it dies, and the log that tells which work it began."""

from __future__ import annotations

import contextlib
import functools
import os
import resource
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pipeline.runtime.worker
from pipeline.config.cluster import ClusterConfig
from pipeline.config.schema import Config
from pipeline.config.selection import SelectConfig
from pipeline.datasets.collection import DatasetConfig
from pipeline.flow import run_pipeline
from pipeline.plan.work_item import Reference
from pipeline.stages.all import checked_stage
from pipeline.stages.stage import Stage
from pipeline.store.artifact import Artifact
from pipeline.store.store import State, Store
from riot.parameters import RefineParameters

Death = Callable[[], None]
"""Called at the start of a victim; arranges for its end."""


def settings(pictures: Path, where: Path) -> Config:
    """A short run in one process."""
    return Config(
        DatasetConfig("folder", "folder", str(pictures)),
        outputs=where / "outputs",
        store=where / "store",
        batch=3,
        select=SelectConfig("global", top=2, breadth=2, per_shape=2),
        refine=RefineParameters(candidates=2),
        cluster=ClusterConfig("sync"),
    )


@dataclass(frozen=True)
class Undisturbed:
    """A run that nobody disturbed: where it is, its tables, its artifacts."""

    where: Path
    pictures: Path
    tables: dict[str, str]
    artifacts: set[Reference]

    def again(self, where: Path) -> Config:
        """The same run elsewhere."""
        return settings(self.pictures, where)


def mine(config: Config, log: Path, death: Death | None = None) -> None:
    """A run whose work is written down as it begins."""
    with recording(log):
        if death is not None:
            death()
        run_pipeline(config, lambda event: None)


@contextlib.contextmanager
def recording(log: Path, disturb: Callable[[str], None] = lambda stage: None) -> Iterator[None]:
    """While entered, work items of this process are written down as they begin, and then ``disturb`` is called."""

    def recorded(stage: str, code: str) -> Stage:
        work = checked_stage(stage, code)

        def run(inputs: Sequence[Any], parameters: Sequence[Any], spec: Any) -> Artifact:
            with log.open("ab", buffering=0) as stream:
                stream.write(f"{stage}\n".encode())
            disturb(stage)
            return work.run(inputs, parameters, spec)

        return replace(work, run=run)

    perform_one = pipeline.runtime.worker.checked_stage
    pipeline.runtime.worker.checked_stage = recorded  # type: ignore[assignment]
    try:
        yield
    finally:
        pipeline.runtime.worker.checked_stage = perform_one


def begun(log: Path) -> list[str]:
    """Stages of the work items that a victim began, in order."""
    return log.read_text().split() if log.exists() else []


def committed(store: Store) -> set[Reference]:
    """What is whole in a store."""
    return {reference for reference in store.folders() if store.state(*reference) is State.PRESENT}


def after_seconds(seconds: float) -> None:
    """Die after so much computing: counted in the processor's time, which other load leaves alone."""
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_PROF, seconds)


def at_event(number: int, prefixes: tuple[str, ...] = ()) -> None:
    """Die right before the ``number``-th of the interpreter's audited operations: opening, renaming, locking …"""
    left = number

    def hook(event: str, arguments: Any) -> None:
        nonlocal left
        if not prefixes or event.startswith(prefixes):
            left -= 1
            if left == 0:
                os.kill(os.getpid(), signal.SIGKILL)

    sys.addaudithook(hook)


def at_sync(number: int, *, before: bool) -> None:
    """Die right before or after the ``number``-th time that something is synced."""
    left, sync = number, os.fsync

    def counted(descriptor: int) -> None:
        nonlocal left
        left -= 1
        if left == 0 and before:
            os.kill(os.getpid(), signal.SIGKILL)
        sync(descriptor)
        if left == 0:
            os.kill(os.getpid(), signal.SIGKILL)

    os.fsync = counted  # type: ignore[assignment]


def while_writing(size: int) -> None:
    """Die in the middle of the first file that gets longer than ``size`` bytes."""
    signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def little_memory(more: int) -> None:
    """Not more than ``more`` bytes above what is used now."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + more
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def put_one(store: Store, parts: Any, artifact: Artifact, death: Death) -> None:
    """Commit one artifact, or die of it."""
    death()
    store.put(parts, artifact)


def deaths_of_a_commit() -> Iterator[Death]:
    """Every step of writing one artifact: operations of the file system, syncs, and bytes written."""
    for number in range(1, 40):
        yield functools.partial(at_event, number, ("open", "os.", "fcntl.", "shutil."))
    for number in range(1, 5):
        for before in (True, False):
            yield functools.partial(at_sync, number, before=before)
    for size in (0, 1, 100, 500, 1000):
        yield functools.partial(while_writing, size)
