"""Whether a run constructs the exact pairs that are hidden in its collection, and at what price.

    python benchmarks/hidden_run.py --root DIR --shapes 509 --pairs 80 --folder FOLDER [name=value …]

Pictures of exact pairs are put among pictures of a folder, evenly chosen; the run is one of `pipeline.run` over all of
them, with the parameters given: ``select=global`` for one list by QCRS. FOLDER keeps the pictures, store and tables.
"""

from __future__ import annotations

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)

# ruff: isort: split
import argparse
import shutil
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
from inputs import pictures
from PIL import Image

from pipeline.run import main as run
from pipeline.study.hidden import SEED, hide, picture

PRICED = ("qcrs", "qcrs_rare", "crs", "refine", "construct")


def write_collection(root: Path, shapes: int | None, pairs: int, pieces: Sequence[int], folder: Path) -> None:
    """Copy pictures of ``root``, and draw the exact pairs, two pictures each."""
    folder.mkdir(parents=True, exist_ok=True)
    for path in pictures(root, shapes):
        shutil.copy(path, folder / path.name)
    hidden, _ = hide(pairs, pieces)
    for number, pair in enumerate(hidden):
        rng = np.random.default_rng([SEED, pair.seed])
        for side, polygon in (("p", pair.exact.p), ("q", pair.exact.q)):
            image, _ = picture(polygon, polygon, 0.0, rng)
            Image.fromarray(image).save(folder / f"hidden{number:03d}-{side}.png")


def show(tables: Path, pieces: Sequence[int], pairs: int) -> None:
    """Print how many of the hidden pairs are selected, constructed and chosen, by n, and the CPU time of stages."""

    def found(name: str, chosen: bool = False) -> Counter[int]:
        numbers = [
            int(row["name_i"][6:9])
            for row in pq.read_table(tables / f"{name}.parquet").to_pylist()
            if row["name_i"].startswith("hidden") and row["name_j"][:9] == row["name_i"][:9]
            if name == "selected" or (row["status"] == "certified" and (row["chosen"] or not chosen))
        ]
        return Counter(pieces[number % len(pieces)] for number in numbers)

    all_pairs = Counter(pieces[number % len(pieces)] for number in range(pairs))
    for words, counted in (
        ("hidden", all_pairs),
        ("selected", found("selected")),
        ("constructed", found("transforms")),
        ("chosen", found("transforms", chosen=True)),
    ):
        by_n = ", ".join(f"n = {n}: {counted[n]}" for n in sorted(all_pairs))
        print(f"{words:12} {sum(counted.values()):4}   {by_n}")
    rows = {row["stage"]: row for row in pq.read_table(tables / "timings.parquet").to_pylist()}
    print(", ".join(f"{stage} {rows[stage]['stored_seconds']:.1f} s" for stage in PRICED if stage in rows))


def main(arguments: Sequence[str] | None = None) -> int:
    """Make the collection, run, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=Path, required=True, help="a folder of pictures to hide the pairs among")
    parser.add_argument("--shapes", type=int, help="so many of the pictures, evenly chosen, instead of all")
    parser.add_argument("--pairs", type=int, default=80, help="exact pairs to hide")
    parser.add_argument("--pieces", default="3,4,5,6", help="their numbers of pieces, in turn, with commas")
    parser.add_argument("--folder", type=Path, required=True, help="where pictures, store and tables are kept")
    parser.add_argument("parameters", nargs="*", metavar="NAME=VALUE", help="parameters of the run")
    options = parser.parse_args(arguments)
    pieces = [int(number) for number in options.pieces.split(",")]
    collection = options.folder / "pictures"
    write_collection(options.root, options.shapes, options.pairs, pieces, collection)
    code = run(
        [
            "+dataset=folder",
            "dataset.name=hidden",
            f"dataset.root={collection}",
            f"store={options.folder / 'store'}",
            f"outputs={options.folder / 'outputs'}",
            *options.parameters,
        ]
    )
    if (options.folder / "outputs" / "hidden" / "run.json").exists():
        show(options.folder / "outputs" / "hidden", pieces, options.pairs)
    return code


if __name__ == "__main__":
    sys.exit(main())
