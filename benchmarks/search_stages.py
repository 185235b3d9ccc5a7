"""What the stages that score cost by each mode of QCRS: all pairs, exact best partners, approximate ones.

    python benchmarks/search_stages.py --root DIR --sizes 2560,5120 --parts FOLDER

The collection is grown as in recall.py. The plan, the store, the inputs that a worker keeps and the tasks are those of
a run; of all tasks of a stage only some run, evenly chosen, each after what it needs of other stages. The cost of a
stage is that of these tasks, by their shapes or pairs, for all of them: CPU seconds, with reading and writing.
"""

from __future__ import annotations

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)

# ruff: isort: split
import argparse
import hashlib
import json
import math
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from inputs import pictures
from recall import AMPLITUDE, grow_parts

from pipeline.config.schema import Config, QcrsConfig
from pipeline.datasets.collection import Collection, DatasetConfig
from pipeline.datasets.item import Item
from pipeline.plan.work_item import Reference, WorkItem
from pipeline.runtime.bundles import bundles
from pipeline.runtime.inputs import InputCache
from pipeline.runtime.worker import run_items
from pipeline.stages.all import BY_NAME, begin_run
from pipeline.stages.trunk_arrays import pack_trunks
from pipeline.store.artifact import Artifact
from pipeline.store.store import Store
from riot.kernels import knn_join, leaves, search
from riot.scores.trunk_stack import TrunkStack
from riot.scores.trunks import Trunks

PART = 640
"""Shapes of a file of grown shapes."""

WORKERS = 2
"""Tasks are as large as for so many workers."""

STAGES = {"all": ("qcrs",), "topk": ("shards", "partners", "partners_beyond")}
STAGES["approximate"] = STAGES["topk"]
"""The stages that score, by mode."""


@dataclass(frozen=True)
class StageCost:
    """CPU seconds of a stage over a whole collection, estimated from the ``share`` of its work that ran."""

    shapes: int
    mode: str
    stage: str
    items: int
    share: float
    cpu_s: float
    read_mb: float


class Shapes:
    """The trunks of a grown collection, from the files of its parts."""

    def __init__(self, files: Sequence[Path]) -> None:
        self._files, self._part, self._stack = files, 0, _load(files[0])
        counts = []
        for file in files:
            with np.load(file) as arrays:
                counts.append(len(arrays["starts"]) - 1)
        self._starts = np.concatenate([[0], np.cumsum(counts)])

    def __len__(self) -> int:
        return int(self._starts[-1])

    def batch(self, members: Sequence[int]) -> Artifact:
        """What the stage ``trunks`` writes of some shapes."""
        trunks, grouped = zip(*map(self._shape, members), strict=True)
        offsets = np.cumsum([0, *map(len, grouped)], dtype=np.int64)
        arrays = {
            "leaves": np.concatenate(grouped),
            "leaf_offsets": offsets,
            "sparse": np.zeros(len(members), np.int64),
        }
        return Artifact({**pack_trunks(trunks), **arrays}, {"errors": []})

    def _shape(self, number: int) -> tuple[Trunks, np.ndarray]:
        part = int(np.searchsorted(self._starts, number, side="right")) - 1
        if part != self._part:
            self._part, self._stack = part, _load(self._files[part])
        one = self._stack.shape(number - int(self._starts[part]))
        thetas = 2.0 * math.pi - one.alphas - one.betas
        vertices = np.zeros(len(thetas), np.int32)
        return Trunks(one.offsets, vertices, one.edges, one.alphas, thetas, one.areas), one.leaves


class Mode:
    """A collection that is mined by one mode, as far as somebody asks for it; without the shapes ``left_out``."""

    def __init__(self, name: str, shapes: Shapes, root: Path, left_out: Sequence[int] = ()) -> None:
        self.name, self._shapes, self.store = name, shapes, Store(root)
        self._numbers = [number for number in range(len(shapes)) if number not in left_out]
        names = [f"{number:06d}" for number in self._numbers]
        items = [Item(name, name, name, hashlib.sha256(name.encode()).hexdigest()) for name in names]
        config = replace(Config(DatasetConfig(), store=root, outputs=root), qcrs=QcrsConfig(mode=name))  # type: ignore[arg-type]
        progress = begin_run(config, Collection("grown", tuple(items)), self.store)
        for stage in ("ingest", "trunks", *STAGES[name]):
            work = BY_NAME[stage].items(progress)
            progress = progress.with_work(stage, work, progress.done | {item.reference for item in work})
        self.progress = progress
        self._by_reference: Mapping[Reference, WorkItem] = {
            item.reference: item for stage in progress.work.values() for item in stage
        }

    def cost(self, stage: str, tasks: int) -> StageCost:
        """Run some tasks of a stage, and what these need first."""
        work = self.progress.work[stage]
        every = bundles(work, WORKERS)
        # The middles of equal parts of the list.
        chosen = [every[int((k + 0.5) * len(every) / tasks)] for k in range(tasks)] if tasks < len(every) else every
        needed = [self._by_reference[source] for bundle in chosen for item in bundle for source in item.sources]
        self.bring(needed)
        cache, cpu, read = InputCache(), 0.0, 0
        for bundle in chosen:
            start = time.process_time()
            for receipt in run_items(self.store, bundle, cache):
                if receipt.failure is not None:
                    raise RuntimeError(receipt.failure.message)
                read += receipt.read_bytes
            cpu += time.process_time() - start
        share = sum(map(_amount, (item for bundle in chosen for item in bundle))) / sum(map(_amount, work))
        return StageCost(len(self._shapes), self.name, stage, len(work), share, cpu / share, read / share / 2**20)

    def bring(self, needed: Sequence[WorkItem]) -> None:
        """Bring work items into the store, and what they need."""
        for item in {item.reference: item for item in needed}.values():
            if self.store.entry(*item.reference) is not None:
                continue
            self.bring([self._by_reference[source] for source in item.sources])
            if item.stage == "ingest":
                self.store.put(item.parts, Artifact())
            elif item.stage == "trunks":
                self.store.put(item.parts, self._shapes.batch([self._numbers[place] for place in item.members]))
            else:
                for receipt in run_items(self.store, [item], InputCache()):
                    if receipt.failure is not None:
                        raise RuntimeError(receipt.failure.message)


def _load(file: Path) -> TrunkStack:
    with np.load(file) as arrays:
        return TrunkStack.from_arrays({name: arrays[name] for name in arrays.files})


def _amount(item: WorkItem) -> int:
    return item.pairs or len(item.members)


def measure(files: Sequence[Path], modes: Sequence[str], tasks: int, root: Path) -> list[StageCost]:
    """The cost of the stages of every mode for the collection in ``files``."""
    shapes = Shapes(files)
    costs: list[StageCost] = []
    known: dict[Reference, StageCost] = {}  # the modes that search share their shards
    for name in modes:
        mode = Mode(name, shapes, root)
        for stage in filter(mode.progress.work.get, STAGES[name]):
            first = mode.progress.work[stage][0].reference
            cost = replace(known[first], mode=name) if first in known else mode.cost(stage, tasks)
            known[first] = cost
            costs.append(cost)
            print(_line(costs[-1]), flush=True)
    return costs


def ratios(costs: Sequence[StageCost]) -> dict[str, float]:
    """What each mode costs, as a share of mode all."""
    total = {mode: sum(cost.cpu_s for cost in costs if cost.mode == mode) for mode in {cost.mode for cost in costs}}
    return {mode: seconds / total["all"] for mode, seconds in sorted(total.items()) if "all" in total}


def main(arguments: Sequence[str] | None = None) -> int:
    """Grow, run, print, write JSON if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=Path, required=True, help="a folder of pictures")
    parser.add_argument("--sizes", default="1280,2560", help="numbers of shapes, with commas")
    parser.add_argument("--modes", default=",".join(STAGES), help="with commas")
    parser.add_argument("--amplitude", type=float, default=AMPLITUDE, help="of the deformations, in units of √area")
    parser.add_argument("--tasks", type=int, default=4, help="tasks of a stage that run at most")
    parser.add_argument("--parts", type=Path, help="a folder that keeps the trunks for other runs")
    parser.add_argument("--json", type=Path, help="write the figures to this file too")
    chosen = parser.parse_args(arguments)
    sizes = sorted(int(text) for text in chosen.sizes.split(","))
    for kernel in (leaves, search, knn_join):
        kernel.warm()
    costs: list[StageCost] = []
    with tempfile.TemporaryDirectory() as folder:
        parts = chosen.parts or Path(folder)
        files = grow_parts(pictures(chosen.root), sizes[-1], chosen.amplitude, PART, parts)
        for size in sizes:
            kept = files[: max(1, round(size / PART))]
            of_size = measure(kept, chosen.modes.split(","), chosen.tasks, Path(folder) / "store")
            print("  ".join(f"{mode} {ratio:.3f}" for mode, ratio in ratios(of_size).items()), flush=True)
            costs += of_size
    if chosen.json:
        chosen.json.write_text(json.dumps([asdict(cost) for cost in costs], indent=1) + "\n", encoding="utf-8")
    return 0


def _line(cost: StageCost) -> str:
    return (
        f"{cost.shapes:>6} shapes  {cost.mode:<11} {cost.stage:<15} {cost.items:>6} work items  {cost.cpu_s:>9.1f} s "
        f"CPU  {cost.read_mb:>9.0f} MB read  ({cost.share:.1%} of it ran)"
    )


if __name__ == "__main__":
    sys.exit(main())
