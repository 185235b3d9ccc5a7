"""What each step of the method costs on this machine: a table, and JSON for comparing runs.

    python benchmarks/run.py                          exact pairs, rendered to pictures
    python benchmarks/run.py --size small             the same in seconds
    python benchmarks/run.py --root DIR --shapes 60   pictures from a folder and its sub-folders, evenly chosen

One process, kernels compiled beforehand, each item timed once. Where a slower way to the same result is known, it runs
too, on the same input: the two must agree (exit code 1 if they do not) and the ratio of their times says what the
faster way is worth. Times depend on the machine; ratios and counts of work hardly do.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
from PIL import Image, ImageDraw

from riot.construct import construct_scored
from riot.cross import best_trunk_pairs
from riot.errors import RiotError
from riot.groundtruth import exact_pair
from riot.kernels.warm import warm_all
from riot.parameters import ConstructParameters
from riot.quick import brute_force, score_block, stack
from riot.reversibility import cut_off, reversibility
from riot.shape import FloatArray, Shape
from riot.silhouette import read
from riot.trunks import Trunks, full_trunks, quick_trunks

T = TypeVar("T")
R = TypeVar("R")

SUFFIXES = {".png", ".gif", ".bmp", ".tif", ".tiff", ".jpg", ".jpeg", ".svg"}
PIXELS = 256
"""Side of a rendered picture."""
AGREE = 1e-12
"""Greatest difference between a pruned and a brute-force score."""


@dataclass(frozen=True)
class Size:
    """How much of each step is run."""

    shapes: int
    brute_shapes: int
    """QCRS by brute force runs on all pairs of so many shapes."""
    pairs: int
    """CRS and construction run on so many pairs, those of highest QCRS."""


SIZES = {"small": Size(8, 4, 2), "medium": Size(40, 10, 8), "large": Size(160, 20, 24)}


@dataclass(frozen=True)
class Step:
    """The cost of one step: milliseconds an item, and how it compares with its reference."""

    step: str
    per: str
    items: int
    failed: int
    median_ms: float
    p90_ms: float
    ratio: float | None = None
    reference: str = ""
    """``ratio`` = this step's cost over the reference's."""
    note: str = ""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, print the table, write JSON if asked; 1 if a fast way and its reference disagree."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", choices=SIZES, default="medium")
    parser.add_argument("--root", type=Path, help="a folder of pictures instead of exact pairs")
    parser.add_argument("--shapes", type=int, help="number of shapes instead of the size's")
    parser.add_argument("--json", type=Path, help="write the figures to this file too")
    chosen = parser.parse_args(arguments)
    size = SIZES[chosen.size]
    count = chosen.shapes or size.shapes

    warm_all(lambda message: print(message, file=sys.stderr))
    with tempfile.TemporaryDirectory() as folder:
        paths = _pictures(chosen.root, count) if chosen.root else _render(count, Path(folder))
        if len(paths) < 2:
            parser.error(f"fewer than two pictures under {chosen.root}")
        steps, agree = measure(paths, size)
    _print(steps)
    if chosen.json:
        source = "folder" if chosen.root else "exact pairs"
        document = {"format": 1, "source": source, "machine": _machine(), "steps": [asdict(s) for s in steps]}
        chosen.json.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    if not agree:
        print("pruned and brute-force QCRS disagree", file=sys.stderr)
    return 0 if agree else 1


def measure(paths: Sequence[Path], size: Size) -> tuple[list[Step], bool]:
    """All steps on these pictures; and whether fast ways and references agree."""
    steps: list[Step] = []

    shapes, seconds = _each(read, paths)
    good = [shape for shape in shapes if shape is not None]
    points = [len(shape.points) for shape in good]
    note = f"{_middle(points):.0f} points"
    steps.append(_step("ingest", "shape", seconds, shapes.count(None), note=note))

    scores, seconds = _each(lambda shape: (found := reversibility(shape), cut_off(shape, found)), good)
    necks = [len(score[0].necks) for score in scores if score]
    steps.append(_step("reversibility", "shape", seconds, 0, note=f"{_middle(necks):.0f} necks"))

    quick = _trunk_step(steps, "quick trunks", quick_trunks, good)
    full = _trunk_step(steps, "full trunks", full_trunks, good)

    pairs, agree = _qcrs_steps(steps, quick, size)
    _pair_steps(steps, good, full, pairs[: size.pairs])
    return steps, agree


def _trunk_step(steps: list[Step], name: str, find: Callable[[Shape], Trunks], shapes: Sequence[Shape]) -> list[Trunks]:
    found, seconds = _each(find, shapes)
    trunks = [each for each in found if each is not None]
    if len(trunks) < len(shapes):
        raise RuntimeError(f"{name}: a shape failed; trunks never fail on a proper shape")
    steps.append(_step(name, "shape", seconds, 0, note=f"{_middle([len(t) for t in trunks]):.0f} trunks"))
    return trunks


def _qcrs_steps(steps: list[Step], trunks: Sequence[Trunks], size: Size) -> tuple[list[tuple[int, int]], bool]:
    """QCRS of all pairs, and by brute force of some; the pairs in order of score."""
    everything = stack(trunks)
    (block,), seconds = _each(lambda _: score_block(everything, everything, same=True), [0])
    assert block is not None
    pairs = len(block.score)

    some = stack(trunks[: size.brute_shapes])
    (pruned,), fast = _each(lambda _: score_block(some, some, same=True), [0])
    (brute,), slow = _each(lambda _: brute_force(some, some, same=True), [0])
    assert pruned is not None
    assert brute is not None
    agree = bool(np.abs(pruned.score - brute.score).max() <= AGREE)
    same = f"{len(brute.score)} pairs, " + ("equal" if agree else "NOT EQUAL")
    steps.append(
        _bulk("qcrs", pairs, seconds[0], fast[0] / slow[0], "qcrs, brute force", "median " + _score(block.score))
    )
    steps.append(_bulk("qcrs, brute force", len(brute.score), slow[0], None, "", same))
    order = np.argsort(-block.score, kind="stable")
    return [(int(block.i[k]), int(block.j[k])) for k in order if block.score[k] > 0], agree


def _pair_steps(
    steps: list[Step], shapes: Sequence[Shape], trunks: Sequence[Trunks], pairs: Sequence[tuple[int, int]]
) -> None:
    """CRS with the candidates that construction asks for, then construction on them."""
    wanted = ConstructParameters().candidates
    found, crs_seconds = _each(
        lambda pair: best_trunk_pairs(shapes[pair[0]], shapes[pair[1]], trunks[pair[0]], trunks[pair[1]], count=wanted),
        pairs,
    )
    shares = [
        scores[0].evaluations / _combinations(trunks[i], trunks[j])
        for (i, j), scores in zip(pairs, found, strict=True)
        if scores
    ]
    best = [scores[0].score for scores in found if scores]
    work = _middle(shares) if shares else None
    note = f"median {_score(best)}; ratio of area terms evaluated"
    steps.append(_step("crs", "pair", crs_seconds, 0, ratio=work, reference="all trunk pairs", note=note))

    ready = [(i, j, scores) for (i, j), scores in zip(pairs, found, strict=True) if scores]
    made, seconds = _each(lambda item: construct_scored(shapes[item[0]], shapes[item[1]], item[2]), ready)
    worst = [transform.deformation().iou for transform in made if transform is not None]
    ratio = _middle(seconds) / _middle(crs_seconds) if seconds else None
    note = f"median IoU {_score(worst)}"
    steps.append(_step("construct", "pair", seconds, made.count(None), ratio=ratio, reference="crs", note=note))


def _combinations(a: Trunks, b: Trunks) -> int:
    """How many (trunk, trunk, shift) there are."""
    sizes, counts = np.unique(a.sizes, return_counts=True)
    return int(sum(n * count * np.count_nonzero(b.sizes == n) for n, count in zip(sizes, counts, strict=True)))


def _each(function: Callable[[T], R], items: Sequence[T]) -> tuple[list[R | None], list[float]]:
    """Results, None where the library refused, and seconds an item."""
    results: list[R | None] = []
    seconds = []
    for item in items:
        start = time.perf_counter()
        try:
            results.append(function(item))
        except RiotError:
            results.append(None)
        seconds.append(time.perf_counter() - start)
    # A refusal may be quick or slow: it counts as an item.
    return results, seconds


def _step(
    step: str,
    per: str,
    seconds: Sequence[float],
    failed: int,
    *,
    ratio: float | None = None,
    reference: str = "",
    note: str = "",
) -> Step:
    p90 = float(np.quantile(seconds, 0.9)) if seconds else float("nan")
    return Step(step, per, len(seconds), failed, 1e3 * _middle(seconds), 1e3 * p90, ratio, reference, note)


def _bulk(step: str, pairs: int, seconds: float, ratio: float | None, reference: str, note: str) -> Step:
    """A step that is timed as a whole: its quantiles are its mean."""
    each = 1e3 * seconds / pairs
    return Step(step, "pair", pairs, 0, each, each, ratio, reference, note)


def _middle(values: Sequence[float] | FloatArray) -> float:
    return float(np.median(values)) if len(values) else float("nan")


def _score(values: Sequence[float] | FloatArray) -> str:
    return f"{_middle(values):.3f}"


def _render(count: int, folder: Path) -> list[Path]:
    """Pictures of exact pairs, three to six pieces."""
    paths = []
    for k in range((count + 1) // 2):
        pair = exact_pair(3 + k % 4, k)
        for side, polygon in (("p", pair.p), ("q", pair.q)):
            low, high = polygon.min(axis=0), polygon.max(axis=0)
            scale = (PIXELS - 17) / (high - low).max()
            corners = (polygon - low) * [scale, -scale] + [8, 8 + scale * (high - low)[1]]
            picture = Image.new("L", (PIXELS, PIXELS), 0)
            ImageDraw.Draw(picture).polygon([tuple(corner) for corner in corners], fill=255)
            paths.append(folder / f"{k:03d}-{side}.png")
            picture.save(paths[-1])
    return paths[:count]


def _pictures(root: Path, count: int) -> list[Path]:
    """``count`` pictures, evenly spaced in the sorted list of all."""
    every = sorted(path for path in root.rglob("*") if path.suffix.lower() in SUFFIXES)
    chosen = np.unique(np.linspace(0, max(len(every) - 1, 0), min(count, len(every))).astype(np.int64))
    return [every[k] for k in chosen]


def _machine() -> dict[str, object]:
    import numba

    return {
        "cpus": os.cpu_count(),
        "processor": platform.machine(),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "numba": numba.__version__,
    }


def _print(steps: Sequence[Step]) -> None:
    print(f"{'step':<18} {'items':>6} {'failed':>6} {'median ms':>10} {'p90 ms':>10}   ratio")
    for s in steps:
        ratio = f"{s.ratio:.2g} of {s.reference}" if s.ratio is not None else ""
        about = "; ".join(part for part in (ratio, s.note) if part)
        print(f"{s.step:<18} {s.items:>6} {s.failed:>6} {s.median_ms:>10.3f} {s.p90_ms:>10.3f}   {about}")


if __name__ == "__main__":
    sys.exit(main())
