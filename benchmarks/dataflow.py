"""What the dataflow costs beside the work: the pipeline's QCRS stage against a bare loop over the same stacks."""

from __future__ import annotations

import hashlib
import multiprocessing
import shutil
import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from floors import Floor
from inputs import Size
from measure import time_shares
from table import Row, row

from pipeline.config.cluster import ClusterConfig
from pipeline.config.schema import Config
from pipeline.datasets.collection import Collection, DatasetConfig
from pipeline.datasets.item import Item
from pipeline.plan.progress import Progress
from pipeline.runtime.clusters import Executor, SyncExecutor, open_cluster
from pipeline.runtime.execute import Run
from pipeline.stages.all import BY_NAME, begin_run
from pipeline.stages.trunk_arrays import unpack_trunks
from pipeline.store.store import Store
from riot.scores.qcrs import BlockScores, score_block
from riot.scores.trunk_stack import TrunkStack, stack

OVERHEAD = 1.1
"""The stage may cost so many times the bare loop."""

Job = tuple[int, int]
"""A block: numbers of two batches."""


@dataclass
class Kept:
    """What a process of the bare loop holds: the stacks, and the round that they were laid out for."""

    stacks: list[TrunkStack]
    round: int = -1


_kept = Kept([])
"""In a process of the bare loop: what its initializer was given."""


def dataflow_steps(paths: Sequence[Path], size: Size) -> list[Row]:
    """The QCRS stage in this process (CPU time) and on several (wall time, times their number)."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        config = Config(DatasetConfig(), store=root, batch=size.batch)
        names = [f"{k:06d}" for k in range(len(paths))]
        digests = [hashlib.sha256(path.read_bytes()).hexdigest() for path in paths]
        items = [Item(name, "", str(path), digest) for name, path, digest in zip(names, paths, digests, strict=True)]
        store = Store(root)
        run = Run(store, lambda event: None, SyncExecutor)
        plan = begin_run(config, Collection("benchmark", tuple(items)), store)
        for name in ("ingest", "trunks"):
            work = BY_NAME[name].items(plan)
            run.stage(BY_NAME[name], work)
            plan = plan.with_work(name, work, frozenset(run.done))
        plan = plan.with_work("qcrs", BY_NAME["qcrs"].items(plan), plan.done)
        jobs = [item.block for item in plan.work["qcrs"] if item.block is not None]
        stacks = _load(plan, store)
        return [_row(plan, root, stacks, jobs, workers, size) for workers in size.workers]


def _load(plan: Progress, store: Store) -> list[TrunkStack]:
    loaded = []
    for item in plan.work["trunks"]:
        batch = store.get(*item.reference)
        loaded.append(stack([unpack_trunks(batch, k) for k in range(len(item.members))]))
    return loaded


def _row(plan: Progress, root: Path, stacks: list[TrunkStack], jobs: list[Job], workers: int, size: Size) -> Row:
    if workers == 1:
        where = ""
        staged = [_stage(plan, root, SyncExecutor(), time.process_time) for _ in range(size.repeats)]
        bare = [_bare(stacks, jobs) for _ in range(size.repeats)]
        share = time_shares(lambda _: _stage(plan, root, SyncExecutor(), time.process_time), [0])
    else:
        where, share = f" on {workers} processes", "wall time × processes"
        with open_cluster(ClusterConfig(kind="local", workers=workers)) as executor:
            _stage(plan, root, executor, time.perf_counter)  # workers import and load their kernels
            staged = [_stage(plan, root, executor, time.perf_counter) for _ in range(size.repeats)]
        bare = _bare_pool(stacks, jobs, workers, size.repeats)
    scores = {job: score_block(stacks[job[0]], stacks[job[1]], None, job[0] == job[1]) for job in jobs}
    pairs = sum(len(block.score) for block in scores.values())
    unit = 1e3 * workers / pairs
    (seconds, cpu_seconds), loop = min(staged), unit * min(bare)
    return row(
        *(f"dataflow of QCRS{where}", "pair", [unit * seconds]),
        items=pairs,
        target_ms=OVERHEAD * loop,
        reference=f"bare loop{where}",
        reference_ms=loop,
        floor=Floor(loop, {"blocks": len(jobs)}, f"the bare loop over {len(jobs)} blocks"),
        bounded_by=share,
        agree=all(_stored_equal(plan, root, job, block) for job, block in scores.items()),
        note=f"{100 * (seconds / min(bare) - 1):+.1f} %, {1e3 * cpu_seconds / pairs:.3g} of it CPU in the work items",
    )


def _stage(plan: Progress, root: Path, executor: Executor, clock: Callable[[], float]) -> tuple[float, float]:
    """Seconds of the stage with nothing of it in the store, and CPU seconds of its work items."""
    shutil.rmtree(root / "qcrs", ignore_errors=True)
    run = Run(Store(root), lambda event: None, lambda: executor, done={item.reference for item in plan.work["trunks"]})
    start = clock()
    run.stage(BY_NAME["qcrs"], plan.work["qcrs"])
    seconds = clock() - start
    if run.failed:
        raise RuntimeError(f"the stage failed: {next(iter(run.failed.values()))}")
    return seconds, run.stages[-1].cpu_seconds


def _bare(stacks: list[TrunkStack], jobs: list[Job]) -> float:
    # Copies: what a stack lays out for the search, it lays out once, and that is part of the loop.
    fresh = [replace(trunk_stack) for trunk_stack in stacks]
    start = time.process_time()
    for a, b in jobs:
        score_block(fresh[a], fresh[b], None, a == b)
    return time.process_time() - start


def _bare_pool(stacks: list[TrunkStack], jobs: list[Job], workers: int, repeats: int) -> list[float]:
    """Wall seconds of each round, after one in which the processes import and load their kernels."""
    context = multiprocessing.get_context("spawn")
    seconds = []
    with ProcessPoolExecutor(workers, context, _keep, ([trunk_stack.to_arrays() for trunk_stack in stacks],)) as pool:
        for number in range(repeats + 1):
            start = time.perf_counter()
            list(pool.map(_one, [(number, job) for job in jobs]))
            seconds.append(time.perf_counter() - start)
    return seconds[1:]


def _keep(stacks: list[dict[str, npt.NDArray[Any]]]) -> None:
    _kept.stacks = [TrunkStack.from_arrays(arrays) for arrays in stacks]


def _one(task: tuple[int, Job]) -> int:
    number, (a, b) = task
    if number != _kept.round:
        _kept.stacks, _kept.round = [replace(trunk_stack) for trunk_stack in _kept.stacks], number
    return len(score_block(_kept.stacks[a], _kept.stacks[b], None, a == b).score)


def _stored_equal(plan: Progress, root: Path, job: Job, scores: BlockScores) -> bool:
    (item,) = (item for item in plan.work["qcrs"] if item.block == job)
    stored = Store(root).get(*item.reference).arrays
    columns = (field.name for field in fields(BlockScores))
    return all(np.array_equal(stored[name], getattr(scores, name)) for name in columns if name in stored)
