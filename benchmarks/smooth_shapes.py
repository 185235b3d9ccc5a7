"""What the score of a pair costs for shapes with few trunks and for smooth ones, which have thousands, by epsilon.

    python benchmarks/smooth_shapes.py --root DIR --shapes 40 --pairs 800

Smooth shapes are ovals with a few low waves, such as leaves. With each epsilon the same pairs are scored; the ratio is
to epsilon 0 in the same run, and the loss is that of a score.
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
from grown import SEED, grown_trunks, members
from inputs import pictures

from riot.geometry.shape import Shape
from riot.geometry.silhouette import polygon_shape
from riot.parameters import QcrsParameters
from riot.scores.qcrs import score_pairs
from riot.scores.trunk_stack import TrunkStack, stack
from riot.scores.trunks import quick_trunks

EPSILONS = (0.0, 0.01, 0.02, 0.05)
SAMPLES = 160
WAVES = range(2, 6)
HEIGHT = 0.02
"""Standard deviation of a wave's height, relative to the radius."""


def oval(rng: np.random.Generator) -> Shape:
    """A leaf: an ellipse that is wider at one end, with low waves."""
    t = np.linspace(0.0, 2.0 * np.pi, SAMPLES, endpoint=False)
    length = rng.uniform(1.0, 2.6)
    width = 1.0 + 0.25 * rng.normal() * np.cos(t)
    waves = [HEIGHT * rng.normal() * np.cos(k * t + rng.uniform(0.0, 2.0 * np.pi)) for k in WAVES]
    points = np.stack([length * np.cos(t), np.sin(t) * width], axis=1) * (1.0 + np.sum(waves, axis=0))[:, None]
    return polygon_shape(points, "leaf")


def compare(name: str, trunks: TrunkStack, count: int) -> None:
    """Score the same pairs with every epsilon, and print a line for each."""
    pairs = np.random.default_rng(SEED).integers(0, len(trunks), (count, 2))
    score_pairs(trunks, trunks, pairs[:1])  # lays out the trunks
    exact, least = np.zeros(count), 0.0
    for epsilon in EPSILONS:
        start = time.process_time()
        score = score_pairs(trunks, trunks, pairs, QcrsParameters(epsilon=epsilon)).score
        cost = time.process_time() - start
        if epsilon == 0.0:
            exact, least = score, cost
        loss = exact - score
        print(
            f"{name:<9} {np.mean(np.diff(trunks.starts)):6.0f} trunks  epsilon {epsilon:<5} "
            f"{1e3 * cost / count:.4f} ms a pair, ratio {cost / least:.2f}, loss {loss.mean():.5f}, "
            f"at most {loss.max():.4f}",
            flush=True,
        )


def main(arguments: Sequence[str] | None = None) -> int:
    """Make the shapes, score, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=Path, required=True, help="a folder of pictures")
    parser.add_argument("--shapes", type=int, default=40, help="shapes of either kind")
    parser.add_argument("--pairs", type=int, default=800, help="pairs that are scored")
    chosen = parser.parse_args(arguments)
    rng = np.random.default_rng(SEED)
    grown = [grown_trunks(member) for member in members(pictures(chosen.root), chosen.shapes)]
    compare("pictures", stack([trunks for trunks in grown if trunks is not None]), chosen.pairs)
    compare("smooth", stack([quick_trunks(oval(rng)) for _ in range(chosen.shapes)]), chosen.pairs)
    return 0


if __name__ == "__main__":
    sys.exit(main())
