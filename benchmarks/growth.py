"""How the cost of QCRS grows with a collection, and what one more shape costs.

    python benchmarks/growth.py --root DIR --sizes 500,1000,2000,4000 --json growth.json --plot growth.svg

The collection is grown from the pictures below DIR (see grown.py). For every size: QCRS of all pairs, by blocks of
batches on several processes, and QCRS of one new shape with all others. With --fraction only that share of the blocks
runs, evenly chosen, and the costs are estimates, marked so.
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
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from grown import Member, grown_trunks, members
from growth_plot import Cost, draw
from inputs import pictures

from riot.kernels.warm import warm_all
from riot.scores.index import TrunkIndex, best_partners
from riot.scores.qcrs import score_block
from riot.scores.trunk_stack import TrunkStack, stack
from riot.scores.trunks import Trunks

FORMAT = 1
"""Version of the JSON."""

LEAST_BLOCKS = 8
"""An estimate rests on so many blocks at least."""

NO_TRUNKS = Trunks(np.zeros(1, np.int64), np.empty(0, np.int32), *(np.empty(0) for _ in range(4)))

PARTNERS = 10
"""Partners that are looked for through the index."""

LEAST_QUERIES = 100
"""Shapes whose partners are looked for at least, evenly chosen."""

ADDED = 5
"""New shapes that are added, one by one, to take the mean of."""


@dataclass(frozen=True)
class Collection:
    """A grown collection on disk: a file with the quick trunks of each batch, and what it cost to make them."""

    files: tuple[Path, ...]
    sizes: tuple[int, ...]
    """Shapes of each batch, without the refused."""
    batch: int
    """With them."""
    added: tuple[Path, ...]
    """Files of one more shape each."""
    refused: int
    trunk_cpu_s: float

    @property
    def pairs(self) -> int:
        """All of them."""
        total = sum(self.sizes)
        return total * (total - 1) // 2

    def first(self, shapes: int) -> Collection:
        """The smaller collection of the first ``shapes``, in whole batches."""
        kept = max(1, round(shapes / self.batch))
        return replace(self, files=self.files[:kept], sizes=self.sizes[:kept])


Way = Callable[[Collection, ProcessPoolExecutor, float], Cost]
"""Find partners in a collection on the pool's processes; the last is the share of the work to run, 1 for all."""


def all_pairs(collection: Collection, pool: ProcessPoolExecutor, fraction: float) -> Cost:
    """QCRS of every pair, block by block."""
    numbers = range(len(collection.files))
    blocks = [(a, b) for a in numbers for b in numbers if a <= b]
    kept = min(len(blocks), max(LEAST_BLOCKS, round(fraction * len(blocks))))
    # The middles of equal parts of the list: diagonal blocks come in their proportion, more or less.
    chosen = [blocks[int((k + 0.5) * len(blocks) / kept)] for k in range(kept)]
    start = time.perf_counter()
    done = list(pool.map(_block, [(collection.files[a], collection.files[b]) for a, b in chosen]))
    wall = time.perf_counter() - start
    scored, cpu, prepare = (sum(column) for column in zip(*done, strict=True))
    scale = collection.pairs / scored if scored else 1.0
    shapes, estimated = sum(collection.sizes), kept < len(blocks)
    seconds = (scale * wall, scale * cpu, scale * prepare)
    return Cost("all pairs", shapes, collection.pairs, int(scored), *seconds, estimated)


def one_more(collection: Collection, pool: ProcessPoolExecutor, fraction: float) -> Cost:
    """QCRS of one new shape with all of the collection, the mean of several new ones; ``fraction`` is not used."""
    blocks = [(file, other) for file in collection.added for other in collection.files]
    start = time.perf_counter()
    done = list(pool.map(_block, blocks))
    wall = time.perf_counter() - start
    number, shapes = len(collection.added), sum(collection.sizes)
    scored, cpu, prepare = (sum(column) / number for column in zip(*done, strict=True))
    return Cost("one more shape", shapes, shapes, round(scored), wall / number, cpu, prepare, False)


def topk(collection: Collection, pool: ProcessPoolExecutor, fraction: float) -> Cost:
    """The `PARTNERS` best partners of every shape through an index, by one process.

    ``pairs_scored`` are those of which the distance of two trunks was computed, a pair from either side being two.
    """
    queries = max(LEAST_QUERIES, round(fraction * sum(collection.sizes)))
    start = time.perf_counter()
    compared, asked, cpu, prepare = pool.submit(_partners, collection.files, queries).result()
    wall = time.perf_counter() - start
    shapes = sum(collection.sizes)
    scale = shapes / asked
    seconds = (wall + (scale - 1.0) * (cpu - prepare), prepare + scale * (cpu - prepare), prepare)
    return Cost(f"top {PARTNERS}", shapes, collection.pairs, round(scale * compared), *seconds, asked < shapes)


WAYS: dict[str, Way] = {"all-pairs": all_pairs, "topk": topk, "one-more": one_more}
"""By the names that --ways takes."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Grow, measure, print, write JSON and the plot if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=Path, required=True, help="a folder of pictures")
    parser.add_argument("--sizes", type=_numbers, default=[500, 1000, 2000], help="numbers of shapes, with commas")
    parser.add_argument("--ways", default=",".join(WAYS), help=f"which of {', '.join(WAYS)}, with commas")
    parser.add_argument("--batch", type=int, default=50, help="shapes of a batch; a block is a pair of batches")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--fraction", type=float, default=1.0, help="share of the blocks to run")
    parser.add_argument("--json", type=Path, help="write the figures to this file too")
    parser.add_argument("--plot", type=Path, help="draw cost against size: .svg, .png or .pdf")
    chosen = parser.parse_args(arguments)
    unknown = [name for name in chosen.ways.split(",") if name not in WAYS]
    if unknown or not 0.0 < chosen.fraction <= 1.0 or chosen.batch < 1 or chosen.workers < 1:
        parser.error(f"no such way: {unknown[0]}" if unknown else "a number is out of range")
    paths = pictures(chosen.root)
    if len(paths) < 2:
        parser.error(f"fewer than two pictures under {chosen.root}")

    warm_all(_say)
    context = multiprocessing.get_context("spawn")
    costs: list[Cost] = []
    with tempfile.TemporaryDirectory() as folder, ProcessPoolExecutor(chosen.workers, context) as pool:
        whole = make_collection(paths, max(chosen.sizes), chosen.batch, Path(folder), pool)
        for size in sorted(chosen.sizes):
            for name in chosen.ways.split(","):
                costs.append(WAYS[name](whole.first(size), pool, chosen.fraction))
                print(_line(costs[-1]), flush=True)
    if chosen.json:
        settings = {name: getattr(chosen, name) for name in ("batch", "workers", "fraction")}
        collection = {"pictures": len(paths), "refused": whole.refused, "trunk_cpu_s": whole.trunk_cpu_s}
        figures = [{**asdict(cost), "ms_per_pair": cost.ms_per_pair} for cost in costs]
        document = {"format": FORMAT, **settings, **collection, "costs": figures}
        chosen.json.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    if chosen.plot:
        draw(costs, chosen.plot)
    return 0


def make_collection(
    paths: Sequence[Path], count: int, batch: int, folder: Path, pool: ProcessPoolExecutor
) -> Collection:
    """Grow ``count`` shapes and some more, and store their quick trunks; the refused are left out."""
    everyone = members(paths, count + ADDED)
    batches = [everyone[start : min(start + batch, count)] for start in range(0, count, batch)]
    jobs = [(group, folder / f"batch-{k:05d}.npz") for k, group in enumerate(batches)]
    jobs += [([member], folder / f"added-{member.number}.npz") for member in everyone[count:]]
    results = []
    for k, result in enumerate(pool.map(_make_batch, jobs)):
        results.append(result)
        if k % 20 == 19:
            _say(f"trunks of {k + 1} of {len(jobs)} batches")
    sizes = [good for good, _ in results]
    number = len(batches)
    return Collection(
        tuple(file for (_, file), good in zip(jobs[:number], sizes, strict=False) if good),
        tuple(good for good in sizes[:number] if good),
        batch,
        tuple(file for (_, file), good in zip(jobs[number:], sizes[number:], strict=True) if good),
        count - sum(sizes[:number]),
        sum(seconds for _, seconds in results),
    )


def _make_batch(job: tuple[list[Member], Path]) -> tuple[int, float]:
    """Store one batch; returns how many shapes it has, and the CPU seconds."""
    start = time.process_time()
    members = [grown_trunks(member) for member in job[0]]
    good = [trunks for trunks in members if trunks is not None]
    if good:
        with job[1].open("wb") as stream:
            np.savez(stream, allow_pickle=False, **stack(good).to_arrays())
    return len(good), time.process_time() - start


def _block(files: tuple[Path, Path]) -> tuple[int, float, float]:
    """Read two batches and score their pairs; the number of pairs, CPU seconds, and those of reading and laying out."""
    start = time.process_time()
    a = _load(files[0])
    b = a if files[0] == files[1] else _load(files[1])
    prepared = time.process_time()
    scores = score_block(a, b, None, files[0] == files[1])
    return len(scores.score), time.process_time() - start, prepared - start


def _partners(files: Sequence[Path], queries: int) -> tuple[int, int, float, float]:
    """Index all batches, look for partners; pairs compared, shapes asked for, CPU seconds, those of indexing."""
    start = time.process_time()
    stacks = []
    for file in files:
        with np.load(file) as arrays:
            stacks.append(TrunkStack.from_arrays({name: arrays[name] for name in arrays.files}))
    index = TrunkIndex.build(stacks)
    prepared = time.process_time()
    chosen = np.unique(np.linspace(0, len(index) - 1, min(queries, len(index))).astype(np.int64)).tolist()
    everyone = [(stack, i) for stack in stacks for i in range(len(stack))]
    compared = 0
    for number in chosen:
        stack, i = everyone[number]
        compared += best_partners(index, stack.shape(i), PARTNERS, itself=[number]).compared
    return compared, len(chosen), time.process_time() - start, prepared - start


def _load(file: Path) -> TrunkStack:
    with np.load(file) as arrays:
        loaded = TrunkStack.from_arrays({name: arrays[name] for name in arrays.files})
    # Scored with a shape without trunks, which costs next to nothing: what is laid out once is laid out now.
    score_block(loaded, stack([NO_TRUNKS]))
    return loaded


def _line(cost: Cost) -> str:
    about = " (estimated)" if cost.estimated else ""
    return (
        f"{cost.shapes:>6} shapes  {cost.way:<15} {cost.pairs:>12,} pairs, {cost.pairs_scored:>12,} scored  "
        f"{cost.wall_s:>9.2f} s  {cost.cpu_s:>9.2f} s CPU, {cost.prepare_cpu_s:>8.2f} s of it preparing  "
        f"{cost.ms_per_pair:.4f} ms a pair{about}"
    )


def _numbers(text: str) -> list[int]:
    numbers = [int(number) for number in text.split(",")]
    if min(numbers) < 2:
        raise argparse.ArgumentTypeError("a collection has two shapes at least")
    return numbers


def _say(message: str) -> None:
    print(message, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
