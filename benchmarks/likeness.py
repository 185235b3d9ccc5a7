"""How well the likeness of shapes tells classes apart, by what it compares, and what a query costs.

    python benchmarks/likeness.py --root DIR                a folder of pictures named CLASS-NUMBER, such as MPEG-7
    python benchmarks/likeness.py --root DIR --threshold    how far noise moves a shape: see `LikenessParameters`

1-NN: the share of shapes whose nearest other shape has their class. Bull's-eye: the share of a shape's class among the
nearest of all, itself included, twice as many as the class has. Milliseconds are of one query against SIZE shapes.
"""

from __future__ import annotations

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)

# ruff: isort: split
import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from inputs import pictures
from rich import box
from rich.console import Console
from rich.table import Table
from table import WIDTH

from riot.errors import RiotError
from riot.geometry.shape import Shape
from riot.geometry.silhouette import polygon_shape, read
from riot.scores.descriptor import CHORDS, descriptor
from riot.scores.likeness import DescriptorIndex, distance
from riot.types import FloatArray

SIZE = 3400
"""Shapes against which a query is timed."""

NOISE = (0.0, 0.0025, 0.005, 0.01)
"""Standard deviation of the noise of an outline's points, in the unit-area frame."""

STEP = 0.02
"""Distance of the points to which noise is added, in the unit-area frame."""


def methods(index: DescriptorIndex) -> dict[str, DescriptorIndex]:
    """The index with all that is compared, and with less of it."""
    outline, none, chords = index.outline, index.region[:, :0], len(CHORDS)
    return {
        "chord lengths": DescriptorIndex(outline[:, :chords], none),
        "triangle areas": DescriptorIndex(outline[:, chords:], none),
        "outline: both": DescriptorIndex(outline, none),
        "region": DescriptorIndex(outline[:, :0], index.region),
        "likeness: all": index,
    }


def recognition(distances: FloatArray, classes: Sequence[str]) -> tuple[float, float]:
    """The rate of 1-NN, leaving one out, and the bull's-eye rate."""
    labels = np.array(classes)
    same = labels[:, None] == labels
    order = np.argsort(distances, axis=1, kind="stable")
    ranked = np.take_along_axis(same, order, axis=1)
    sizes = same.sum(axis=1)
    hits = sum(int(row[: 2 * size].sum()) for row, size in zip(ranked, sizes, strict=True))
    others = distances + np.diag(np.full(len(labels), np.inf))
    return float(same[np.arange(len(labels)), others.argmin(axis=1)].mean()), hits / int(sizes.sum())


def milliseconds(index: DescriptorIndex, mirrored: bool, queries: int = 20) -> float:
    """Median time of a query against `SIZE` shapes, which repeat those of the index."""
    many = index.subset(np.arange(SIZE) % len(index))
    times = []
    for number in range(queries):
        start = time.perf_counter()
        many.nearest(index.descriptor(number % len(index)), 10, mirrored=mirrored)
        times.append(time.perf_counter() - start)
    return 1e3 * float(np.median(times))


def compare(index: DescriptorIndex, classes: Sequence[str]) -> Table:
    """A row for each method, without and with mirroring."""
    table = Table("method", "mirrored", "1-NN", "bull's-eye", f"ms / {SIZE}", box=box.SIMPLE)
    for name, reduced in methods(index).items():
        for mirrored in (False, True):
            distances = np.array(
                [reduced.distances(reduced.descriptor(number), mirrored=mirrored) for number in range(len(reduced))]
            )
            nearest, bull = recognition(distances, classes)
            cost = f"{milliseconds(reduced, mirrored):.1f}"
            table.add_row(name, "yes" if mirrored else "no", f"{nearest:.4f}", f"{bull:.4f}", cost)
    return table


def noisy(points: FloatArray, deviation: float, rng: np.random.Generator) -> FloatArray:
    """The outline with points every `STEP`, each moved at random."""
    length = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    at = np.concatenate([[0.0], np.cumsum(length)])
    closed, where = np.vstack([points, points[:1]]), np.arange(0.0, at[-1], STEP)
    dense = np.column_stack([np.interp(where, at, closed[:, axis]) for axis in (0, 1)])
    return np.asarray(dense + rng.normal(0.0, deviation, dense.shape), dtype=np.float64)


def noise_distances(shapes: Sequence[Shape]) -> Table:
    """How far noise of the outline moves a shape, by the noise; an outline that crosses itself is left out."""
    table = Table("noise", "median", "95 %", "shapes", box=box.SIMPLE)
    for deviation in NOISE:
        rng = np.random.default_rng(0)
        moved = []
        for shape in shapes:
            try:
                other = polygon_shape(noisy(shape.points, deviation, rng))
            except RiotError:
                continue
            moved.append(distance(descriptor(shape), descriptor(other)))
        table.add_row(f"{deviation}", *(f"{np.quantile(moved, q):.3f}" for q in (0.5, 0.95)), str(len(moved)))
    return table


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table; 0 if there is one."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=Path, required=True, help="folder of pictures, named CLASS-NUMBER")
    parser.add_argument("--shapes", type=int, default=None, help="so many of the pictures, evenly spread")
    parser.add_argument("--threshold", action="store_true", help="how far noise moves a shape, instead")
    options = parser.parse_args(arguments)
    shapes, classes = [], []
    for path in pictures(options.root, options.shapes):
        try:
            shapes.append(read(path))
        except RiotError as error:
            print(f"{path.name}: {error}", file=sys.stderr)
            continue
        classes.append(path.stem.rpartition("-")[0])
    index = DescriptorIndex.build([descriptor(shape) for shape in shapes])
    Console(width=WIDTH).print(noise_distances(shapes) if options.threshold else compare(index, classes))
    return 0


if __name__ == "__main__":
    sys.exit(main())
