"""What each bound of the QCRS search leaves of all pairs of trunks, within some distances.

    python benchmarks/prunes.py --root DIR --shapes 300 --distances 0.2,0.3,0.5

Trunks are drawn by chance from the quick trunks of a collection grown from the pictures below DIR (see grown.py). The
bounds are taken one after the other, cheapest first, by plain loops: what is left at the end is within the distance.
"""

from __future__ import annotations

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)

# ruff: isort: split
import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from grown import SEED, grown_trunks, members
from inputs import pictures

from riot.parameters import QcrsParameters
from riot.scores.trunk_stack import TrunkStack, stack
from riot.types import FloatArray
from riot.units import D_C

BOUNDS = ("one n", "area", "perimeter", "angle sums", "sorted edges", "sorted angles", "all, at some shift")
"""In the order in which they are taken."""

USUAL = QcrsParameters()


class Corners:
    """The drawn trunks of one n: areas (t,), edges, alphas and betas (t, n)."""

    def __init__(self, trunks: TrunkStack, numbers: Sequence[int], n: int) -> None:
        rows = trunks.offsets[numbers][:, None] + np.arange(n)
        self.n, self.areas = n, trunks.areas[numbers]
        self.edges, self.alphas, self.betas = trunks.edges[rows], trunks.alphas[rows], trunks.betas[rows]


def left(a: Corners, b: Corners, distance: float) -> list[int]:
    """How many pairs of a's and b's trunks each of `BOUNDS` leaves."""
    edge, angle = a.n * USUAL.sigma_e * D_C * distance, 2 * a.n * USUAL.sigma_angle * distance
    t, u = np.indices((len(a.areas), len(b.areas))).reshape(2, -1)
    counts = [len(t)]

    def keep(near: np.ndarray) -> None:
        nonlocal t, u
        t, u = t[near], u[near]
        counts.append(len(t))

    keep(2.0 * np.abs(a.areas[t] + b.areas[u] - 1.0) <= USUAL.sigma_area * distance)
    keep(np.abs(a.edges.sum(1)[t] - b.edges.sum(1)[u]) <= edge)
    excess_a, excess_b = (np.abs(side.betas.sum(1) - (a.n - 2) * math.pi) for side in (a, b))
    keep(excess_a[t] + excess_b[u] <= angle)
    keep(_apart(np.sort(a.edges)[t], np.sort(b.edges)[u]) <= edge)
    betas, alphas = _apart(np.sort(a.betas)[t], np.sort(b.alphas)[u]), _apart(np.sort(a.alphas)[t], np.sort(b.betas)[u])
    keep(betas + alphas <= angle)
    near = np.zeros(len(t), dtype=bool)
    for shift in range(a.n):
        edges, corners = (shift - 1 - np.arange(a.n)) % a.n, (shift - np.arange(a.n)) % a.n
        turned = _apart(a.betas[t], b.alphas[u][:, corners]) + _apart(a.alphas[t], b.betas[u][:, corners])
        near |= (_apart(a.edges[t], b.edges[u][:, edges]) <= edge) & (turned <= angle)
    keep(near)
    return counts


def _apart(a: FloatArray, b: FloatArray) -> FloatArray:
    total: FloatArray = np.abs(a - b).sum(axis=1)
    return total


def counted(trunks: TrunkStack, queries: int, others: int, distance: float) -> list[int]:
    """`left`, over all n, of so many trunks drawn by chance with so many others."""
    rng, sizes = np.random.default_rng(SEED), np.diff(trunks.offsets)
    drawn = [rng.choice(len(sizes), min(number, len(sizes)), replace=False) for number in (queries, others)]
    total = np.zeros(len(BOUNDS), dtype=np.int64)
    for n in np.unique(sizes[drawn[0]]).tolist():
        a, b = (Corners(trunks, numbers[sizes[numbers] == n].tolist(), n) for numbers in drawn)
        if len(b.areas):
            total += left(a, b, distance)
    return [int(count) for count in total]


def main(arguments: Sequence[str] | None = None) -> int:
    """Grow, draw, count, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=Path, required=True, help="a folder of pictures")
    parser.add_argument("--shapes", type=int, default=300, help="shapes of the collection")
    parser.add_argument("--distances", default="0.2,0.3,0.5", help="distances D, with commas; the score is exp(−D²/2)")
    parser.add_argument("--trunks", type=int, default=3000, help="trunks that are drawn on either side")
    chosen = parser.parse_args(arguments)
    grown = [grown_trunks(member) for member in members(pictures(chosen.root), chosen.shapes)]
    trunks = stack([shape for shape in grown if shape is not None])
    print(f"{len(trunks)} shapes, {len(trunks.areas) / max(1, len(trunks)):.0f} trunks a shape")
    for distance in [float(text) for text in chosen.distances.split(",")]:
        counts = counted(trunks, chosen.trunks, chosen.trunks, distance)
        print(f"D ≤ {distance:g}, score ≥ {math.exp(-0.5 * distance**2):.3f}")
        for name, count in zip(BOUNDS, counts, strict=True):
            print(f"  {name:<20} {count:>12,}  {count / max(1, counts[0]):.2e}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
