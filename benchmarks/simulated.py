"""A run whose results are simulated: random scores in blocks of the right size; no shape is read."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from pipeline.config.schema import Config, QcrsConfig, QcrsMode
from pipeline.datasets.collection import Collection, DatasetConfig
from pipeline.datasets.item import Item
from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.runtime.clusters import Bundle
from pipeline.runtime.execute import Run
from pipeline.runtime.inputs import InputCache
from pipeline.runtime.worker import Receipt, run_items
from pipeline.stages.all import BY_NAME, STAGES, begin_run
from pipeline.stages.stage import Stage
from pipeline.store.artifact import AnyArray, Artifact
from pipeline.store.store import Store

BLOCKS = ("qcrs", "qcrs_rare")
SEARCHES = ("partners", "partners_beyond")
COMPUTED = ("preselect", "pairs", "select")
"""Stages that run as they are."""

CLASS = 20
"""Shapes of a class."""


class Simulated:
    """An executor that writes random results of the right size, and runs the stages that select as they are."""

    workers = 1

    def __init__(self, progress: Progress) -> None:
        self._progress = progress

    def run(self, store: Store, bundles: Sequence[Bundle]) -> Iterator[Receipt]:
        """See `pipeline.runtime.clusters.executor.Executor`."""
        cache = InputCache()
        for item in (item for bundle in bundles for item in bundle):
            if item.stage in COMPUTED:
                yield from run_items(store, [item], cache)
                continue
            rows = {**dict.fromkeys(BLOCKS, self._rows), **dict.fromkeys(SEARCHES, self._partners)}
            arrays = rows.get(item.stage, self._shapes)(item)
            store.put(item.parts, Artifact(arrays, {"errors": []}), {"seconds": 1.0, "cpu_seconds": 1.0})
            yield Receipt(item.stage, item.key)

    def _shapes(self, item: WorkItem) -> dict[str, AnyArray]:
        """What selection and tables read of a batch: that each shape has one point, and is not doubtful."""
        count = len(item.members)
        return {"offsets": np.arange(count + 1), "quality_doubtful": np.zeros(count, dtype=np.bool_)}

    def _rows(self, item: WorkItem) -> dict[str, AnyArray]:
        assert item.block is not None
        rows, columns = (len(self._progress.of_side(item.stage, number)) for number in item.block)
        same = item.block[0] == item.block[1]
        pairs = np.triu_indices(rows, 1) if same else np.divmod(np.arange(rows * columns), columns)
        i, j = (side.astype(np.int32) for side in pairs)
        random = np.random.default_rng(int(item.key[:8], 16))
        score, n = random.random(len(i)), random.integers(3, 7, len(i), dtype=np.int8)
        if item.stage == "qcrs_rare":
            return {"i": i, "j": j, "score": score, "n": n}
        first, second = random.integers(0, 1400, (2, len(i)), dtype=np.int32)
        return {"i": i, "j": j, "score": score, "n": n, "shift": n, "trunk_i": first, "trunk_j": second}

    def _partners(self, item: WorkItem) -> dict[str, AnyArray]:
        """As many partners as are wanted of every shape: as many as a search finds where shapes have no order."""
        shapes, count = len(item.members), self._progress.config.qcrs.k
        targets = item.pairs // shapes
        random = np.random.default_rng(int(item.key[:8], 16))
        i = np.repeat(np.arange(shapes, dtype=np.int32), min(count, targets))
        j = np.concatenate([random.choice(targets, min(count, targets), replace=False) for _ in range(shapes)])
        first, second = random.integers(0, 1400, (2, len(i)), dtype=np.int32)
        n = random.integers(3, 7, len(i), dtype=np.int8)
        score = random.random(len(i))
        order = np.lexsort((-score, i))
        rows: dict[str, AnyArray] = {"i": i, "j": j[order].astype(np.int32), "score": score[order], "n": n, "shift": n}
        return {**rows, "trunk_i": first, "trunk_j": second, "promising": np.empty((0, 2), np.int32)}


def stages(config: Config) -> list[Stage]:
    """The stages of shapes and blocks or searches, and those that select."""
    names = ("shards", *COMPUTED)
    return [
        stage
        for stage in STAGES
        if stage.wanted(config) and (stage.scope in ("batch", "block", "part") or stage.name in names)
    ]


def planned(root: Path, shapes: int, mode: QcrsMode = "all") -> Progress:
    """The plan of a run up to the selection, as if all of it were done."""
    names = [f"{number:06d}" for number in range(shapes)]
    items = [
        Item(name, f"class-{int(name) // CLASS}", name, hashlib.sha256(name.encode()).hexdigest()) for name in names
    ]
    config = Config(DatasetConfig(), qcrs=QcrsConfig(mode=mode), store=root / "store", outputs=root)
    progress = begin_run(config, Collection("simulated", tuple(items)), Store(root / "store"))
    for stage in stages(config):
        work = stage.items(progress)
        progress = progress.with_work(stage.name, work, progress.done | {item.reference for item in work})
    return progress


def simulated_run(root: Path, progress: Progress, *, done: bool = False) -> Run:
    """A run of a plan, with nothing to compile; with ``done`` it need not look for what comes before a stage."""
    run = Run(Store(root / "store"), lambda event: None, lambda: Simulated(progress))
    run.kernels.start = lambda stage: None  # type: ignore[method-assign]
    run.kernels.wait = lambda stage: 0.0  # type: ignore[method-assign]
    return replace(run, done=set(progress.done)) if done else run


def bring(run: Run, progress: Progress, *names: str) -> None:
    """Bring stages into the store; raises RuntimeError where one fails."""
    for name in names:
        run.stage(BY_NAME[name], progress.work[name])
    for failure in run.failed.values():
        raise RuntimeError(failure.message)
