"""What the bookkeeping of a large run costs: plan, files, selection, tables, and the same run again.

    python benchmarks/bookkeeping.py --shapes 500,2000,20000 --json bookkeeping.json --plot bookkeeping.svg
    python benchmarks/bookkeeping.py --shapes 20000,100000 --mode topk --plan

The results are simulated: scores are random numbers in blocks of the right size, and no shape is read; with --mode topk
or approximate each search finds as many partners as are wanted of a shape, more than in a run. Each step runs
in a process of its own, whose greatest memory is measured: what is resident, and its own, without the pages of mapped
files, which the system takes back when it needs them. The step ``imports`` does nothing: its memory is that of Python
with its libraries. With --plan only the plan is made.
"""

from __future__ import annotations

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)

# ruff: isort: split
import argparse
import json
import multiprocessing
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import get_args

from bookkeeping_plot import draw, table
from own_memory import OwnMemory
from simulated import BLOCKS, COMPUTED, SEARCHES, bring, planned, simulated_run

from pipeline.config.schema import QcrsMode
from pipeline.plan.progress import Progress
from pipeline.runtime.worker import peak_mb
from pipeline.stages.all import BY_NAME
from pipeline.store.store import Store
from pipeline.tables.pair_tables import write_qcrs
from pipeline.tables.results import Results


@dataclass(frozen=True)
class Step:
    """What a step took, and what it counted."""

    shapes: int
    mode: str
    step: str
    wall_s: float
    cpu_s: float
    peak_mb: float
    """Greatest resident memory of its process."""
    own_mb: float
    """The part of it that is not of mapped files."""
    count: int
    counted: str


@dataclass(frozen=True)
class Case:
    """A collection of so many shapes whose run is simulated in a folder."""

    root: Path
    shapes: int
    mode: QcrsMode

    def planned(self) -> Progress:
        """The plan of the run."""
        return planned(self.root, self.shapes, self.mode)


def imports(case: Case) -> tuple[int, str]:
    """Do nothing."""
    return len(sys.modules), "modules"


def plan(case: Case) -> tuple[int, str]:
    """Make the plan."""
    return sum(map(len, case.planned().work.values())), "work items"


def simulate(case: Case) -> tuple[int, str]:
    """Write random results of all stages before the selection."""
    progress = case.planned()
    bring(simulated_run(case.root, progress), progress, *(name for name in progress.work if name not in COMPUTED))
    names = [name for name in (*BLOCKS, *SEARCHES) if name in progress.work]
    return sum(len(progress.work[name]) for name in names), "blocks or searches"


def pairs(case: Case) -> tuple[int, str]:
    """Collect what the searches found, as the process of a run does."""
    return _brought(case, "pairs", "collections")


def preselect(case: Case) -> tuple[int, str]:
    """Select in the blocks part by part, as a worker does, all parts in one process."""
    return _brought(case, "preselect", "parts")


def select(case: Case) -> tuple[int, str]:
    """Select the pairs, as the process of a run does."""
    _brought(case, "select", "selection")
    folders = [case.root / "store" / name for name in (*BLOCKS, "shards", *SEARCHES, *COMPUTED)]
    return sum(1 for folder in folders for path in folder.rglob("*") if path.is_file()), "files of QCRS and selection"


def _brought(case: Case, stage: str, counted: str) -> tuple[int, str]:
    progress = case.planned()
    work = progress.work.get(stage, ())
    if work:
        bring(simulated_run(case.root, progress, done=True), progress, stage)
    return len(work), counted


def again(case: Case) -> tuple[int, str]:
    """Plan a finished run, and find all of it in the store."""
    progress = case.planned()
    run = simulated_run(case.root, progress)
    for name, work in progress.work.items():
        run.stage(BY_NAME[name], work)
    missing = sum(stage.total - stage.cached for stage in run.stages)
    if missing:
        raise RuntimeError(f"{missing} work items were missing")
    return len(run.done), "artifacts found"


def tables(case: Case) -> tuple[int, str]:
    """Write the table of all pairs, or of those that the searches found."""
    files = write_qcrs(Results(case.planned(), Store(case.root / "store"), {}, 0, ()), case.root)
    size = sum(file.stat().st_size for file in files) // 2**20
    return size, f"MB in {sum(file.suffix == '.parquet' for file in files)} files"


STEPS: dict[str, Callable[[Case], tuple[int, str]]] = {
    "imports": imports,
    "plan": plan,
    "simulate": simulate,
    "pairs": pairs,
    "preselect": preselect,
    "select": select,
    "again": again,
    "tables": tables,
}


def measured(name: str, case: Case) -> Step:
    """Take a step in this process, which is new."""
    wall, cpu = time.perf_counter(), time.process_time()
    with OwnMemory() as own:
        count, counted = STEPS[name](case)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    return Step(case.shapes, case.mode, name, wall, cpu, peak_mb(), own.peak_mb, count, counted)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print, write JSON and the plot if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shapes", default="20000", help="sizes of the collection, with commas; default: %(default)s")
    parser.add_argument("--mode", choices=get_args(QcrsMode), default="all", help="qcrs.mode; default: %(default)s")
    parser.add_argument("--plan", action="store_true", help="only make the plan")
    parser.add_argument("--folder", type=Path, help="where the simulated store goes, 45 bytes a pair")
    parser.add_argument("--json", type=Path, help="write the figures to this file too")
    parser.add_argument("--plot", type=Path, help="draw the figures against the size: .svg, .png or .pdf")
    chosen = parser.parse_args(arguments)
    sizes = [int(size) for size in chosen.shapes.split(",")]
    if min(sizes) < 2:
        parser.error("give two shapes or more")
    results: list[Step] = []
    context = multiprocessing.get_context("spawn")
    for size in sizes:
        with tempfile.TemporaryDirectory(dir=chosen.folder) as folder:
            case = Case(Path(folder), size, chosen.mode)
            for name in ("imports", "plan") if chosen.plan else STEPS:
                with ProcessPoolExecutor(1, context) as process:  # a new one, for its memory
                    results.append(process.submit(measured, name, case).result())
                print(_line(results[-1]), flush=True)
    rows = [asdict(step) for step in results]
    if len(sizes) > 1:
        print(f"\n{table(rows)}")
    if chosen.json:
        chosen.json.write_text(json.dumps({"simulated": True, "steps": rows}, indent=1) + "\n")
    if chosen.plot:
        draw(rows, chosen.plot)
    return 0


def _line(step: Step) -> str:
    times = f"{step.shapes:>7,}  {step.step:9} {step.wall_s:8.2f} s  {step.cpu_s:8.2f} s CPU"
    return f"{times}  {step.peak_mb:6.0f} MB, {step.own_mb:5.0f} of it own  {step.count:,} {step.counted}"


if __name__ == "__main__":
    sys.exit(main())
