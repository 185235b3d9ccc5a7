"""What the bookkeeping of a large run costs: plan, files, selection, tables, and the same run again.

    python benchmarks/bookkeeping.py --shapes 20000 --json bookkeeping.json

The results are simulated: scores are random numbers in blocks of the right size, and no shape is read. Each step runs
in a process of its own, whose greatest resident memory is measured. With --plan only the plan is made.
"""

from __future__ import annotations

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)

# ruff: isort: split
import argparse
import hashlib
import json
import multiprocessing
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from pipeline.config.schema import Config
from pipeline.datasets.collection import Collection, DatasetConfig
from pipeline.datasets.item import Item
from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.runtime.clusters import Bundle
from pipeline.runtime.execute import Run
from pipeline.runtime.worker import Receipt, peak_mb
from pipeline.stages.all import BY_NAME, STAGES, begin_run
from pipeline.stages.stage import Stage
from pipeline.store.artifact import AnyArray, Artifact
from pipeline.store.store import Store
from pipeline.tables.pair_tables import write_qcrs
from pipeline.tables.results import Results

BLOCKS = ("qcrs", "qcrs_rare")
CLASS = 20
"""Shapes of a class."""


@dataclass(frozen=True)
class Step:
    """What a step took, and what it counted."""

    step: str
    wall_s: float
    cpu_s: float
    peak_mb: float
    """Greatest resident memory of its process, of which some 150 MB are Python with its libraries."""
    count: int
    counted: str


class Simulated:
    """An executor that writes random results of the right size."""

    workers = 1

    def __init__(self, progress: Progress) -> None:
        self._progress = progress

    def run(self, store: Store, bundles: Sequence[Bundle]) -> Iterator[Receipt]:
        """See `pipeline.runtime.clusters.executor.Executor`."""
        for item in (item for bundle in bundles for item in bundle):
            arrays = self._rows(item) if item.stage in BLOCKS else self._shapes(item)
            store.put(item.parts, Artifact(arrays, {"errors": []}), {"seconds": 1.0, "cpu_seconds": 1.0})
            yield Receipt(item.stage, item.key)

    def _shapes(self, item: WorkItem) -> dict[str, AnyArray]:
        """What selection and tables read of a batch: that each shape has one point, and is not doubtful."""
        count = len(item.members)
        return {"offsets": np.arange(count + 1), "quality_doubtful": np.zeros(count, dtype=np.bool_)}

    def _rows(self, item: WorkItem) -> dict[str, AnyArray]:
        assert item.block is not None
        rows, columns = (len(self._progress.of_group(number)) for number in item.block)
        same = item.block[0] == item.block[1]
        pairs = np.triu_indices(rows, 1) if same else np.divmod(np.arange(rows * columns), columns)
        i, j = (side.astype(np.int32) for side in pairs)
        random = np.random.default_rng(int(item.key[:8], 16))
        score, n = random.random(len(i)), random.integers(3, 7, len(i), dtype=np.int8)
        if item.stage == "qcrs_rare":
            return {"i": i, "j": j, "score": score, "n": n}
        first, second = random.integers(0, 1400, (2, len(i)), dtype=np.int32)
        return {"i": i, "j": j, "score": score, "n": n, "shift": n, "trunk_i": first, "trunk_j": second}


def stages(config: Config) -> list[Stage]:
    """The stages of shapes and blocks, and the selection."""
    simulated = [stage for stage in STAGES if stage.wanted(config) and stage.scope in ("batch", "block")]
    return [*simulated, BY_NAME["select"]]


def planned(root: Path, shapes: int) -> Progress:
    """The plan of a run up to the selection, as if all of it were done."""
    names = [f"{number:06d}" for number in range(shapes)]
    items = [
        Item(name, f"class-{int(name) // CLASS}", name, hashlib.sha256(name.encode()).hexdigest()) for name in names
    ]
    config = Config(DatasetConfig(), store=root / "store", outputs=root)
    progress = begin_run(config, Collection("simulated", tuple(items)), Store(root / "store"))
    for stage in stages(config):
        work = stage.items(progress)
        progress = progress.with_work(stage.name, work, progress.done | {item.reference for item in work})
    return progress


def plan(root: Path, shapes: int) -> tuple[int, str]:
    """Make the plan."""
    return sum(map(len, planned(root, shapes).work.values())), "work items"


def simulate(root: Path, shapes: int) -> tuple[int, str]:
    """Write random results of all stages before the selection."""
    progress = planned(root, shapes)
    run = Run(Store(root / "store"), lambda event: None, lambda: Simulated(progress))
    run.kernels.start = lambda stage: None  # type: ignore[method-assign]  # nothing is computed
    run.kernels.wait = lambda stage: 0.0  # type: ignore[method-assign]
    for name, work in progress.work.items():
        if name != "select":
            run.stage(BY_NAME[name], work)
    return sum(1 for name in BLOCKS for path in (root / "store" / name).rglob("*") if path.is_file()), "files of QCRS"


def select(root: Path, shapes: int) -> tuple[int, str]:
    """Select the pairs, as a run does."""
    progress = planned(root, shapes)
    run = Run(Store(root / "store"), lambda event: None, lambda: Simulated(progress), done=set(progress.done))
    run.stage(BY_NAME["select"], progress.work["select"])
    for failure in run.failed.values():
        raise RuntimeError(f"the selection failed: {failure.message}")
    return sum(item.pairs for item in progress.work["qcrs"]), "pairs"


def again(root: Path, shapes: int) -> tuple[int, str]:
    """Plan a finished run, and find all of it in the store."""
    progress = planned(root, shapes)
    run = Run(Store(root / "store"), lambda event: None, lambda: Simulated(progress))
    for name, work in progress.work.items():
        run.stage(BY_NAME[name], work)
    missing = sum(stage.total - stage.cached for stage in run.stages)
    if missing:
        raise RuntimeError(f"{missing} work items were missing")
    return len(run.done), "artifacts found"


def tables(root: Path, shapes: int) -> tuple[int, str]:
    """Write the table of all pairs."""
    files = write_qcrs(Results(planned(root, shapes), Store(root / "store"), {}, 0, ()), root)
    return sum(file.stat().st_size for file in files) // 2**20, f"MB in {len(files)} files"


STEPS: dict[str, Callable[[Path, int], tuple[int, str]]] = {
    "plan": plan,
    "simulate": simulate,
    "select": select,
    "again": again,
    "tables": tables,
}


def measured(name: str, root: Path, shapes: int) -> Step:
    """Take a step in this process, which is new."""
    wall, cpu = time.perf_counter(), time.process_time()
    count, counted = STEPS[name](root, shapes)
    return Step(name, time.perf_counter() - wall, time.process_time() - cpu, peak_mb(), count, counted)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print, and write JSON if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shapes", type=int, default=20_000, help="size of the collection; default: %(default)s")
    parser.add_argument("--plan", action="store_true", help="only make the plan")
    parser.add_argument("--folder", type=Path, help="where the simulated store goes, 45 bytes a pair")
    parser.add_argument("--json", type=Path, help="write the figures to this file too")
    chosen = parser.parse_args(arguments)
    if chosen.shapes < 2:
        parser.error("give two shapes or more")
    results: list[Step] = []
    context = multiprocessing.get_context("spawn")
    with tempfile.TemporaryDirectory(dir=chosen.folder) as folder:
        for name in ("plan",) if chosen.plan else STEPS:
            with ProcessPoolExecutor(1, context) as process:  # a new one, for its memory
                step = process.submit(measured, name, Path(folder), chosen.shapes).result()
            results.append(step)
            line = f"{step.step:9} {step.wall_s:8.2f} s  {step.cpu_s:8.2f} s CPU  {step.peak_mb:6.0f} MB"
            print(f"{line}  {step.count:,} {step.counted}", flush=True)
    if chosen.json:
        document = {"shapes": chosen.shapes, "simulated": True, "steps": [asdict(step) for step in results]}
        chosen.json.write_text(json.dumps(document, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
