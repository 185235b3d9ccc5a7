"""What ``qcrs.mode=topk`` and ``approximate`` cost as a collection grows, and how many of the best partners are found.

    python benchmarks/recall.py --root DIR --sizes 1280,5120,20480 --json recall.json --plot recall.svg

The collection is grown from the pictures below DIR (see grown.py), deformed so much that few are near-duplicates. A few
batches of it look for the partners of their shapes as in a run: in the own part of the index, then in all the others.
Costs are CPU milliseconds of one shape: the mean of these; that of scoring all pairs is half of N pairs, of which some
are scored. Recall is the share of the exact k best partners that the approximate mode finds from the shape's side; some
of these it scores too low.
"""

from __future__ import annotations

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)

# ruff: isort: split
import argparse
import json
import resource
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
from grown import SEED, grown_trunks, members
from inputs import pictures
from recall_plot import Growth, draw

from pipeline.stages.joined_search import known_distances, promising_only
from pipeline.stages.partners import MARGIN, find
from pipeline.stages.partners_beyond import promising_trunks
from pipeline.stages.search_spec import ShardPosition, Wanted
from pipeline.stages.shards import SHAPES_PER_SHARD
from pipeline.store.artifact import AnyArray
from riot.parameters import QcrsParameters
from riot.scores.index import TrunkIndex, join
from riot.scores.knn_join import join_partners, lay_out_queries
from riot.scores.qcrs import score_pairs
from riot.scores.trunk_stack import TrunkStack, stack
from riot.types import FloatArray

AMPLITUDE = 0.15
"""Of a deformation: one in four is a near-duplicate of its picture, on MPEG-7."""

SAMPLED_PAIRS = 2000
"""Pairs that are scored to know what all cost, of the first part."""

T = TypeVar("T")


@dataclass
class Batch:
    """Shapes of one part that look for partners, and by mode: the trunks that are compared in other parts, laid out,
    the distances of partners so far, and what was found, rows of (shape, part, j, score)."""

    part: int
    queries: dict[str, TrunkIndex]
    known: dict[str, FloatArray]
    found: dict[str, list[tuple[int, int, int, float]]]

    def add(self, mode: str, part: int, i: AnyArray, j: AnyArray, score: FloatArray) -> None:
        """Note the rows of a search."""
        rows = zip(i.tolist(), j.tolist(), score.tolist(), strict=True)
        self.found[mode] += [(a, part, b, value) for a, b, value in rows]

    def best(self, mode: str, shape: int, count: int) -> dict[tuple[int, int], float]:
        """The scores of the ``count`` best partners of a shape, by part and number."""
        rows = sorted((row for row in self.found[mode] if row[0] == shape), key=lambda row: (-row[3], row[1], row[2]))
        return {row[1:3]: row[3] for row in rows[:count]}


def measure(files: Sequence[Path], batches: int, size: int, count: int) -> Growth:
    """Search the collection of these parts for the partners of so many batches of ``size`` shapes."""
    cpu = {"topk": 0.0, "approximate": 0.0, "index": 0.0}

    def timed(name: str, work: Callable[[], T]) -> T:
        start = time.process_time()
        done = work()
        cpu[name] += time.process_time() - start
        return done

    own = sorted({int((k + 0.5) * len(files) / batches) for k in range(batches)})
    usual, sizes, asking = QcrsParameters(), [], []
    for part in own:
        index = TrunkIndex.build([_load(files[part])])
        first = (len(index) - size) // 2
        query = join([index.trunks.shape(k) for k in range(first, first + size)])
        batch = Batch(part, {}, {}, {"topk": [], "approximate": []})
        position = ShardPosition(first, False)
        for mode, margin in (("topk", 1.0), ("approximate", MARGIN)):
            wanted = Wanted(count, usual, margin)
            rows = timed(mode, lambda: find(query, index, wanted, position, range(size))).arrays  # noqa: B023
            batch.add(mode, part, rows["i"], rows["j"], rows["score"])
            batch.known[mode] = known_distances(rows["i"], rows["score"], size, count)
            few = promising_trunks(rows["i"], rows["promising"], size, count) if mode == "approximate" else {}
            batch.queries[mode] = timed(
                mode,
                lambda: lay_out_queries(promising_only(query, few)[0], batch.known[mode]),  # noqa: B023
            )
        asking.append(batch)
    for part, file in enumerate(files):
        trunks = _load(file)
        index = timed("index", lambda: TrunkIndex.build([trunks]))  # noqa: B023
        sizes.append(len(index))
        for batch in asking:
            if batch.part != part:
                earlier = np.full(size, len(index) * (batch.part > part), dtype=np.int64)
                for mode, laid_out in batch.queries.items():
                    joined = timed(
                        mode,
                        lambda: join_partners(index, laid_out, batch.known[mode], usual, earlier),  # noqa: B023
                    )
                    batch.known[mode] = joined.tops
                    batch.add(mode, part, joined.scores.i, joined.scores.j, joined.scores.score)
    shares, low = [], []
    for batch in asking:
        for shape in range(size):
            exact, near = (batch.best(mode, shape, count) for mode in ("topk", "approximate"))
            if exact:
                shares.append(len(exact.keys() & near.keys()) / len(exact))
                low += [near[partner] < exact[partner] for partner in exact.keys() & near.keys()]
    shapes, asked = sum(sizes), len(asking) * size
    exact_ms, approximate_ms = (1e3 * cpu[mode] / asked for mode in ("topk", "approximate"))
    return Growth(
        shapes=shapes,
        asked=asked,
        all_ms=_pair_ms(_load(files[0])) * (shapes - 1) / 2,
        index_ms=1e3 * cpu["index"] / shapes,
        exact_ms=exact_ms,
        approximate_ms=approximate_ms,
        recall=float(np.mean(shares)),
        least_recall=float(np.min(shares)),
        low_scores=float(np.mean(low)),
        peak_mb=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    )


def _pair_ms(trunks: TrunkStack) -> float:
    pairs = np.random.default_rng(SEED).integers(0, len(trunks), (SAMPLED_PAIRS, 2))
    score_pairs(trunks, trunks, pairs[:1])  # lays out the trunks
    start = time.process_time()
    score_pairs(trunks, trunks, pairs)
    return 1e3 * (time.process_time() - start) / SAMPLED_PAIRS


def grow_parts(paths: Sequence[Path], count: int, amplitude: float, part: int, folder: Path) -> list[Path]:
    """Files with the trunks of the parts of a grown collection; those that are there are kept."""
    everyone, files = members(paths, count, amplitude), []
    for k, start in enumerate(range(0, count, part)):
        files.append(folder / f"part-{k:03d}.npz")
        if not files[-1].exists():
            grown = [grown_trunks(member) for member in everyone[start : start + part]]
            with files[-1].open("wb") as stream:
                np.savez(stream, allow_pickle=False, **stack([good for good in grown if good is not None]).to_arrays())
    return files


def _load(file: Path) -> TrunkStack:
    with np.load(file) as arrays:
        return TrunkStack.from_arrays({name: arrays[name] for name in arrays.files})


def main(arguments: Sequence[str] | None = None) -> int:
    """Grow, search, print, write JSON and the plot if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=Path, required=True, help="a folder of pictures")
    parser.add_argument("--sizes", default="1280,2560,5120", help="numbers of shapes, with commas")
    parser.add_argument("--amplitude", type=float, default=AMPLITUDE, help="of the deformations, in units of √area")
    parser.add_argument("--k", type=int, default=20, help="partners of a shape")
    parser.add_argument("--batches", type=int, default=4, help="batches that look for partners")
    parser.add_argument("--batch", type=int, default=96, help="shapes of such a batch")
    parser.add_argument("--part", type=int, default=SHAPES_PER_SHARD, help="shapes of a part of the index")
    parser.add_argument("--parts", type=Path, help="a folder that keeps the trunks for other runs")
    parser.add_argument("--json", type=Path, help="write the figures to this file too")
    parser.add_argument("--plot", type=Path, help="draw costs and recall: .svg, .png or .pdf")
    chosen = parser.parse_args(arguments)
    sizes = sorted(int(text) for text in chosen.sizes.split(","))
    table = []
    with tempfile.TemporaryDirectory() as folder:
        parts = grow_parts(
            pictures(chosen.root), sizes[-1], chosen.amplitude, chosen.part, chosen.parts or Path(folder)
        )
        for size in sizes:
            kept = parts[: max(1, round(size / chosen.part))]
            measure(kept[:1], 1, 1, 1)  # loads the kernels
            table.append(measure(kept, chosen.batches, chosen.batch, chosen.k))
            print(table[-1].sentence, flush=True)
    if chosen.json:
        chosen.json.write_text(json.dumps([asdict(row) for row in table], indent=1) + "\n", encoding="utf-8")
    if chosen.plot:
        draw(table, chosen.plot)
    return 0


if __name__ == "__main__":
    sys.exit(main())
