"""What a worker does: read inputs from the store, run the stage, write the artifact, and return a receipt."""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from pipeline.plan.work_item import WorkItem
from pipeline.runtime.inputs import InputCache, Inputs
from pipeline.runtime.retries import DEADLY
from pipeline.stages.all import checked_stage, code_text
from pipeline.store.artifact import encode_pieces
from pipeline.store.store import State, Store


@dataclass(frozen=True)
class Failure:
    """Why a work item made no artifact: the error's type and message, how often it was tried, and one word for it."""

    type: str
    message: str
    attempts: int = 1
    reason: str = ""

    @property
    def deadly(self) -> bool:
        """Whether the item ended its process, or the process had to be ended: others may do well without it."""
        return self.type in DEADLY


@dataclass(frozen=True)
class Receipt:
    """All that comes back from a worker: no geometry, only what happened and what it cost."""

    stage: str
    key: str
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    peak_mb: float = 0.0
    failure: Failure | None = None
    read_bytes: int = 0
    written_bytes: int = 0


def run_items(store: Store, items: Sequence[WorkItem], cache: InputCache) -> Iterator[Receipt]:
    """Run work items one after another against a store; a failure stays with its item.

    ``cache`` holds inputs from one task of this process to the next.
    """
    inputs = Inputs(store, items, cache)
    for position, item in enumerate(items):
        yield _run_item(store, inputs, position, item)


def _run_item(store: Store, inputs: Inputs, position: int, item: WorkItem) -> Receipt:
    wall, cpu = time.perf_counter(), time.process_time()
    read, written = inputs.read_bytes, 0
    failure = None
    try:
        if store.state(*item.reference) is State.PRESENT:
            # Another run has made it since the stage began, or a worker that was lost with its receipts has.
            return Receipt(item.stage, item.key)
        stage = checked_stage(item.stage, code_text(item.parts.code, item.parts.versions))
        artifact = stage.run(inputs.of(position, item, stage.prepare), item.parameters, item.spec)
        seconds, cpu_seconds = time.perf_counter() - wall, time.process_time() - cpu
        payload = encode_pieces(artifact)
        store.commit(item.parts, payload, {"seconds": seconds, "cpu_seconds": cpu_seconds, "peak_mb": peak_mb()})
        written = sum(map(len, payload))
    except Exception as error:
        failure = Failure(type(error).__name__, str(error) or type(error).__name__)
    spent = time.perf_counter() - wall, time.process_time() - cpu
    return Receipt(item.stage, item.key, *spent, peak_mb(), failure, inputs.read_bytes - read, written)


def peak_mb() -> float:
    """Greatest resident memory of this process so far."""
    # Kilobytes on Linux, bytes on macOS.
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)
