"""What a stage spends: seconds of its workers, the longest chain of its work items, bytes read and written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from pipeline.plan.work_item import Reference, WorkItem
from pipeline.runtime.events import StageEnded
from pipeline.runtime.worker import Receipt

SUMS = ("failed", "seconds", "cpu_seconds", "busy_seconds", "worker_seconds", "read_mb", "written_mb")
GREATEST = ("peak_mb", "critical_seconds")


def spending(spent: Sequence[Receipt], items: Mapping[Reference, WorkItem]) -> dict[str, float]:
    """The fields of `StageEnded` that the receipts of a stage's work ``items`` tell."""
    return {
        "cpu_seconds": sum(receipt.cpu_seconds for receipt in spent),
        "busy_seconds": sum(receipt.seconds for receipt in spent),
        "peak_mb": max((receipt.peak_mb for receipt in spent), default=0.0),
        "critical_seconds": critical_seconds(spent, items),
        "read_mb": sum(receipt.read_bytes for receipt in spent) / 2**20,
        "written_mb": sum(receipt.written_bytes for receipt in spent) / 2**20,
    }


def critical_seconds(spent: Sequence[Receipt], items: Mapping[Reference, WorkItem]) -> float:
    """Seconds of the longest chain of work items of which each reads the one before; of most stages, of the longest."""
    ends: dict[Reference, float] = {}
    for receipt in spent:
        reference = (receipt.stage, receipt.key)
        begins = max((ends.get(source, 0.0) for source in items[reference].sources), default=0.0)
        ends[reference] = begins + receipt.seconds
    return max(ends.values(), default=0.0)


def with_earlier(ended: StageEnded, earlier: StageEnded) -> StageEnded:
    """A stage with what an earlier plan spent on it: what that computed was not in the store when the run began."""
    computed = min(earlier.computed, ended.cached)
    sums = {name: getattr(ended, name) + getattr(earlier, name) for name in SUMS}
    greatest = {name: max(getattr(ended, name), getattr(earlier, name)) for name in GREATEST}
    found, made = ended.cached - computed, ended.computed + computed
    return replace(ended, cached=found, computed=made, **sums, **greatest)
