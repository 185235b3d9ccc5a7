"""Execution: a stage's plan → its artifacts, only those that the store lacks, streaming, on any cluster."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace
from pathlib import Path

from pipeline.config.cluster import ClusterConfig
from pipeline.errors import SignatureError, StartError, StorageError
from pipeline.plan.work_item import Reference, WorkItem
from pipeline.runtime.bundles import bundles
from pipeline.runtime.clusters import Executor, SyncExecutor, open_cluster
from pipeline.runtime.events import ItemDone, Listener, StageEnded, StageStarted
from pipeline.runtime.profile import profiled
from pipeline.runtime.retries import MACHINE_FAULTS, MACHINE_TRIES
from pipeline.runtime.spending import spending, with_earlier
from pipeline.runtime.stage_kernels import StageKernels
from pipeline.runtime.worker import Failure, Receipt
from pipeline.stages.all import BY_NAME
from pipeline.stages.block_rows import ReusingBlock
from pipeline.stages.reused_search import ReusingSearch
from pipeline.stages.stage import Stage
from pipeline.store.artifact import Artifact
from pipeline.store.store import State, Store

ENDING = {error.__name__: error for error in (StorageError, SignatureError)}
"""Failures of a work item that end the run: no other artifact can be written there either, or all may be forged."""


@dataclass
class Run:
    """A run in progress: what is done, what failed, and how to get a cluster once it is needed.

    With ``unwritable``, why the store takes nothing, it finds everything there or does not start.
    """

    store: Store
    listen: Listener
    cluster: Callable[[], Executor]
    unwritable: StartError | None = None
    kernels: StageKernels = field(default_factory=StageKernels)
    done: set[Reference] = field(default_factory=set)
    failed: dict[Reference, Failure] = field(default_factory=dict)
    blocked: set[Reference] = field(default_factory=set)
    stages: list[StageEnded] = field(default_factory=list)

    def stage(self, stage: Stage, items: Sequence[WorkItem]) -> None:
        """Bring a stage's items into the store, those that read others of the stage after these.

        Raises `StorageError` once the store takes no more, and ``unwritable`` for the first item that it lacks.
        """
        started = time.perf_counter()
        unique = {item.reference: item for item in items}
        states = dict(zip(unique, self.store.check_all(list(unique)), strict=True))
        cached = {reference: cost for reference, (state, cost) in states.items() if state is State.PRESENT}
        corrupt = sum(state is State.CORRUPT for state, _ in states.values())
        self.done |= cached.keys()
        missing = {ref: item for ref, item in unique.items() if ref not in cached}
        ready = self._ready(missing)
        amount = sum(stage.amount(item) for item in ready.values())
        self.listen(StageStarted(stage.name, stage.unit, len(unique), len(cached), corrupt, stage.counted, amount))
        spent: list[Receipt] = []
        waited = worked = 0.0
        if ready:
            if self.unwritable is not None:
                raise self.unwritable
            executor, waited = self._executor(stage)
            workers, begun = executor.workers, time.perf_counter()
            spent = self._work(executor, ready)
            while more := self._ready({ref: item for ref, item in missing.items() if ref not in ready}):
                ready |= more
                spent += self._work(executor, more)
            worked = workers * (time.perf_counter() - begun)
        self.blocked |= missing.keys() - ready.keys()
        ended = StageEnded(
            stage.name,
            total=len(unique),
            cached=len(cached),
            computed=sum(reference in self.done for reference in ready),
            failed=sum(reference in self.failed for reference in ready),
            blocked=len(unique) - len(cached) - len(ready),
            seconds=time.perf_counter() - started - waited,
            worker_seconds=worked,
            stored_seconds=self._stored_seconds(unique.keys(), cached),
            counted=stage.counted,
            amount=sum(stage.amount(item) for item in unique.values()),
            stored_amount=sum(stage.amount(unique[reference]) for reference in cached),
            **spending(spent, unique),
        )
        before = [earlier for earlier in self.stages if earlier.stage == stage.name]
        others = [earlier for earlier in self.stages if earlier.stage != stage.name]
        self.stages = [*others, with_earlier(ended, before[0]) if before else ended]
        self.listen(ended)

    def _ready(self, missing: Mapping[Reference, WorkItem]) -> dict[Reference, WorkItem]:
        return {ref: item for ref, item in missing.items() if self.done.issuperset(_needed(item))}

    def probe(self, items: Sequence[WorkItem]) -> dict[Reference, Failure]:
        """Bring work items into the store to see which of them fail, and tell nobody; returns their failures."""
        trial = Run(self.store, lambda event: None, self.cluster)
        states = self.store.check_all([item.reference for item in items])
        missing = {
            item.reference: item for item, (state, _) in zip(items, states, strict=True) if state is not State.PRESENT
        }
        if missing:
            executor, _ = self._executor(BY_NAME[items[0].stage])
            trial._work(executor, missing)
        return trial.failed

    def adopt(self, failed: WorkItem, joined: WorkItem, parts: Sequence[WorkItem], artifact: Artifact) -> None:
        """Keep the ``artifact`` joined from finished ``parts`` as that of ``joined``, instead of a failed item.

        Where that is the item itself, it has not failed after all.
        """
        costs = [entry.cost for part in parts if (entry := self.store.entry(*part.reference)) is not None]
        total = {name: float(sum(cost.get(name, 0.0) for cost in costs)) for name in ("seconds", "cpu_seconds")}
        total["peak_mb"] = max((cost.get("peak_mb", 0.0) for cost in costs), default=0.0)
        self.store.put(joined.parts, artifact, total)
        self.done.add(joined.reference)
        del self.failed[failed.reference]
        if joined.reference == failed.reference:
            self.stages = [
                replace(ended, failed=ended.failed - 1, computed=ended.computed + 1)
                if ended.stage == joined.stage
                else ended
                for ended in self.stages
            ]

    def begin_again(self) -> None:
        """Forget what is done and what failed, because another plan is followed; what was spent is remembered."""
        self.done.clear()
        self.failed.clear()
        self.blocked.clear()

    def _executor(self, stage: Stage) -> tuple[Executor, float]:
        """What runs the work items of a stage, whose kernels are then compiled, and the seconds it waited for them."""
        if stage.here:
            return SyncExecutor(), 0.0
        self.kernels.start(stage)  # they compile while the cluster opens
        executor = self.cluster()
        return executor, self.kernels.wait(stage)

    def _work(self, executor: Executor, ready: dict[Reference, WorkItem]) -> list[Receipt]:
        spent: list[Receipt] = []
        pending = list(ready.values())
        for tries in range(1, MACHINE_TRIES + 1):
            again: list[WorkItem] = []
            for receipt in executor.run(self.store, bundles(pending, executor.workers)):
                spent.append(receipt)
                reference = (receipt.stage, receipt.key)
                if receipt.failure is None:
                    self.done.add(reference)
                elif receipt.failure.type in ENDING:
                    raise ENDING[receipt.failure.type](receipt.failure.message)
                elif receipt.failure.type in MACHINE_FAULTS and tries < MACHINE_TRIES:
                    again.append(ready[reference])
                    continue
                else:
                    failure = receipt.failure
                    self.failed[reference] = replace(failure, attempts=failure.attempts + tries - 1)
                amount = BY_NAME[receipt.stage].amount(ready[reference])
                self.listen(ItemDone(receipt.stage, receipt.failure is not None, amount))
            if not again:
                break
            pending = again
        return spent

    def _stored_seconds(self, items: AbstractSet[Reference], known: Mapping[Reference, Mapping[str, float]]) -> float:
        total = 0.0
        for reference in sorted(items & self.done):
            cost = known.get(reference)
            if cost is None:
                entry = self.store.entry(*reference)
                cost = entry.cost if entry is not None else {}
            total += cost.get("seconds", 0.0)
        return total


def _needed(item: WorkItem) -> Sequence[Reference]:
    """The inputs without which a work item cannot be done: older blocks and searches only save work."""
    reuses = isinstance(item.spec, ReusingBlock | ReusingSearch)
    return item.sources[: len(item.parts.inputs)] if reuses else item.sources


@contextlib.contextmanager
def open_run(
    store: Store,
    cluster: ClusterConfig,
    stages: Sequence[Stage],
    listen: Listener,
    unwritable: StartError | None = None,
    profile: Path | None = None,
) -> Iterator[Run]:
    """A run through ``stages``: the cluster is opened, and kernels are compiled, with the first work item of them.

    What the cluster does is reported in the file ``profile``, if one is given.
    """
    with contextlib.ExitStack() as stack:
        opened: list[Executor] = []
        kernels = stack.enter_context(StageKernels(stages, listen))

        def executor() -> Executor:
            if not opened:
                opened.append(stack.enter_context(open_cluster(cluster, store, listen)))
                if profile is not None:
                    stack.enter_context(profiled(profile))
            return opened[0]

        yield Run(store, listen, executor, unwritable, kernels)
