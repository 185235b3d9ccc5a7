"""What it costs to add a shape to a mined collection, by stage, with ``qcrs.mode=topk``.

    python benchmarks/adding.py --root DIR --sizes 2560,20480 --simulate 20480 --parts FOLDER

The collection is grown as in recall.py, and a run is as in search_stages.py. The shape in the middle is missing at
first; then it is there, and all that the store lacks is done: CPU seconds, with reading and writing. Where the searches
before it would take too long, they are simulated: random partners, with the least score that they have there.
The reference is the same work without older searches, of some tasks.
"""

from __future__ import annotations

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)

# ruff: isort: split
import argparse
import json
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from inputs import pictures
from recall import AMPLITUDE, grow_parts
from search_stages import PART, STAGES, WORKERS, Mode, Shapes

from pipeline.plan.work_item import WorkItem
from pipeline.runtime.bundles import bundles
from pipeline.runtime.inputs import InputCache, Inputs
from pipeline.runtime.reuse import with_older_results
from pipeline.runtime.worker import run_items
from pipeline.stages.all import BY_NAME
from pipeline.store.artifact import Artifact
from riot.kernels import knn_join, leaves, search

LEAST = 0.93
"""The score of the last partner in simulated searches: fewer added shapes are scored in full where it is higher."""


@dataclass(frozen=True)
class AddingCost:
    """CPU seconds and megabytes read by a stage when a shape is added, for the work items that the store lacked, and
    the CPU seconds of the same work by `searched_anew`."""

    shapes: int
    stage: str
    items: int
    missing: int
    cpu_s: float
    read_mb: float
    anew_s: float


def simulate(mode: Mode, item: WorkItem) -> Artifact:
    """A search that has found random partners of every shape."""
    shapes = len(item.members)
    sizes = {shard.reference: len(shard.members) for shard in mode.progress.work["shards"]}
    shards = zip(item.spec.shards, item.sources[item.spec.batches :], strict=False)
    others = np.concatenate([position.start + np.arange(sizes[shard]) for position, shard in shards])
    count = min(mode.progress.config.qcrs.k, len(others))
    random = np.random.default_rng(int(item.key[:8], 16))
    i = np.repeat(np.arange(shapes, dtype=np.int32), count)
    j = np.concatenate([np.sort(random.choice(others, count, replace=False)) for _ in range(shapes)])
    small, trunks = np.full(len(i), 3, np.int8), np.zeros(len(i), np.int32)
    columns = {"i": i, "j": j.astype(np.int32), "score": np.full(len(i), LEAST), "n": small, "shift": small}
    searched = {"searched": np.arange(shapes, dtype=np.int32), "least": np.full(shapes, LEAST)}
    more = {"trunk_i": trunks, "trunk_j": trunks, "promising": np.empty((0, 2), np.int32)}
    return Artifact({**columns, **more, **searched})


def searched_anew(mode: Mode, work: Sequence[WorkItem], tasks: int) -> float:
    """CPU seconds of work items without older searches, estimated from so many tasks."""
    every = bundles(work, WORKERS)
    chosen = [every[int((k + 0.5) * len(every) / tasks)] for k in range(tasks)] if tasks < len(every) else every
    stage, cache = BY_NAME[work[0].stage], InputCache()
    start = time.process_time()
    for bundle in chosen:
        inputs = Inputs(mode.store, bundle, cache)
        for position, item in enumerate(bundle):
            stage.run(inputs.of(position, item, stage.prepare), item.parameters, item.spec)
    done = sum(len(item.members) for bundle in chosen for item in bundle)
    return (time.process_time() - start) * sum(len(item.members) for item in work) / done


def measure(files: Sequence[Path], simulated: bool, tasks: int, root: Path) -> list[AddingCost]:
    """Mine the collection without its middle shape, then with it."""
    shapes = Shapes(files)
    before, after = Mode("topk", shapes, root, [len(shapes) // 2]), Mode("topk", shapes, root)
    for stage in STAGES["topk"]:
        work = before.progress.work[stage]
        if simulated and stage != "shards":
            for item in work:
                before.store.put(item.parts, simulate(before, item))
        else:
            before.bring(work)
    after.bring([*after.progress.work["ingest"], *after.progress.work["trunks"]])
    costs = []
    for stage in filter(after.progress.work.get, STAGES["topk"]):
        work = after.progress.work[stage]
        lacking = {item.key for item in work if after.store.entry(*item.reference) is None}
        anew = searched_anew(after, [item for item in work if item.key in lacking], tasks)
        start = time.process_time()
        missing = [item for item in with_older_results(after.store, work) if item.key in lacking]
        cpu, read = time.process_time() - start, 0
        cache = InputCache()
        for bundle in bundles(missing, WORKERS):
            start = time.process_time()
            for receipt in run_items(after.store, bundle, cache):
                if receipt.failure is not None:
                    raise RuntimeError(receipt.failure.message)
                read += receipt.read_bytes
            cpu += time.process_time() - start
        costs.append(AddingCost(len(shapes), stage, len(work), len(missing), cpu, read / 2**20, anew))
        print(_line(costs[-1]), flush=True)
    return costs


def main(arguments: Sequence[str] | None = None) -> int:
    """Grow, run, print, write JSON if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=Path, required=True, help="a folder of pictures")
    parser.add_argument("--sizes", default="1280,2560", help="numbers of shapes, with commas")
    parser.add_argument("--simulate", type=int, default=20_000, help="simulate older searches from this size on")
    parser.add_argument("--tasks", type=int, default=2, help="tasks of the reference that run at most")
    parser.add_argument("--parts", type=Path, help="a folder that keeps the trunks for other runs")
    parser.add_argument("--json", type=Path, help="write the figures to this file too")
    chosen = parser.parse_args(arguments)
    sizes = sorted(int(text) for text in chosen.sizes.split(","))
    for kernel in (leaves, search, knn_join):
        kernel.warm()
    costs: list[AddingCost] = []
    with tempfile.TemporaryDirectory() as folder:
        files = grow_parts(pictures(chosen.root), sizes[-1], AMPLITUDE, PART, chosen.parts or Path(folder))
        for size in sizes:
            kept = files[: max(1, round(size / PART))]
            costs += measure(kept, size >= chosen.simulate, chosen.tasks, Path(folder) / f"store-{size}")
    if chosen.json:
        chosen.json.write_text(json.dumps([asdict(cost) for cost in costs], indent=1) + "\n", encoding="utf-8")
    return 0


def _line(cost: AddingCost) -> str:
    return (
        f"{cost.shapes:>6} shapes  {cost.stage:<15} {cost.missing:>4} of {cost.items:>4} work items  "
        f"{cost.cpu_s:>7.1f} s CPU  {cost.read_mb:>6.0f} MB read  {cost.anew_s:>7.1f} s anew"
    )


if __name__ == "__main__":
    sys.exit(main())
