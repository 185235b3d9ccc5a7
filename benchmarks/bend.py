"""What bending both shapes before they are cut gains, how far they bend, and what it costs, beside no bending.

    python benchmarks/bend.py --run outputs/mpeg7 --root DIR --pairs 40 --weights 1 0.5 0.25

The pairs are, of randomly chosen pairs of classes, those of highest QCRS in a finished run with ``qcrs.mode=all``; the
pictures are read from DIR. Bound and IoU are of the worse shape, against the shape that is cut: the input without
bending, else the bent input. Strain is of the more bent shape; sag is by how much the most bent of the input's straight
sides leaves its chord, as a share of its length.
"""

from __future__ import annotations

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)

# ruff: isort: split
import argparse
import json
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pyarrow.dataset as ds
import pyarrow.parquet as pq
from rich import box
from rich.console import Console
from rich.table import Table

from riot.construction.bend import bend_plans
from riot.construction.bent_choice import construct_bent
from riot.construction.plan_search import find_plans
from riot.construction.plan_transform import construct_plans
from riot.errors import RiotError
from riot.geometry.bend import Bend
from riot.geometry.modes import Modes, modes
from riot.geometry.shape import Shape
from riot.geometry.sides import straight_sides
from riot.geometry.silhouette import read
from riot.kernels.warm import warm_all
from riot.parameters import BendParameters, ConstructParameters, RefineParameters
from riot.transform.deformation import measure_deformation
from riot.transform.transform import Transform

FORMAT = 1
"""Version of the JSON."""

REFINEMENT, CONSTRUCTION = RefineParameters(), ConstructParameters()
WIDTH = 150


@dataclass(frozen=True)
class Figures:
    """One way of one pair; ``iou`` is nan and ``reason`` says why if there is no transform."""

    bound: float
    iou: float
    input_iou: float
    rms_strain: float
    max_strain: float
    sag: float
    refine_ms: float
    bend_ms: float
    construct_ms: float
    reason: str


@dataclass(frozen=True, eq=False)
class Outcome:
    """One way of one pair, with what is drawn of it."""

    figures: Figures
    shapes: tuple[Shape, Shape]
    transform: Transform | None
    bends: tuple[Bend, Bend] | None


@cache
def elastic(path: Path, straight: float, count: int) -> tuple[Modes, float]:
    """The modes of a picture's shape, and the CPU milliseconds that they took."""
    start = time.process_time()
    return modes(shape_of(path), count, straight), 1e3 * (time.process_time() - start)


@cache
def shape_of(path: Path) -> Shape:
    """The shape in a picture."""
    return read(path)


def class_pairs(run: Path, count: int, seed: int) -> list[tuple[str, str]]:
    """Sources of the pairs of highest QCRS of so many pairs of classes."""
    shapes = pq.read_table(run / "shapes.parquet", columns=["class", "source"])
    sources = shapes.column("source").to_pylist()
    _, classes = np.unique(shapes.column("class").to_numpy(zero_copy_only=False), return_inverse=True)
    scores = ds.dataset(run / "qcrs", format="parquet").to_table(columns=["i", "j", "score"])
    i, j, score = (scores.column(name).to_numpy() for name in ("i", "j", "score"))
    low, high = np.minimum(classes[i], classes[j]), np.maximum(classes[i], classes[j])
    order = np.lexsort((j, i, -score, high, low))
    order = order[low[order] != high[order]]
    key = low[order] * (classes.max() + 1) + high[order]
    best = order[np.concatenate([[True], key[1:] != key[:-1]])]
    drawn = np.sort(np.random.default_rng(seed).choice(len(best), min(count, len(best)), replace=False))
    return [(sources[i[k]], sources[j[k]]) for k in best[drawn]]


def best_of_classes(run: Path) -> list[tuple[str, str]]:
    """Sources of the least deformed certified transform of each class in a finished run, each pair once."""
    source = pq.read_table(run / "shapes.parquet", columns=["source"]).column("source").to_pylist()
    columns = ["i", "j", "class_i", "class_j", "iou", "status"]
    rows = pq.read_table(run / "transforms.parquet", columns=columns).to_pylist()
    best: dict[str, dict[str, Any]] = {}
    for row in sorted((row for row in rows if row["status"] == "certified"), key=lambda row: -row["iou"]):
        for side in ("class_i", "class_j"):
            best.setdefault(row[side], row)
    pairs = [(source[best[name]["i"]], source[best[name]["j"]]) for name in sorted(best)]
    return list(dict.fromkeys(pairs))


def sag(bend: Bend) -> float:
    """Of the straight side that bends most: its distance from its chord more than before, over its length."""
    before, after = bend.shape.points, bend.bent.points
    worst = 0.0
    for start, stop in straight_sides(before).ends:
        run = np.arange(start, stop + 1) % len(before)
        worst = max(worst, _sag(after[run]) - _sag(before[run]))
    return worst


def _sag(points: np.ndarray) -> float:
    chord = points[-1] - points[0]
    offset = points - points[0]
    return float(np.abs(chord[0] * offset[:, 1] - chord[1] * offset[:, 0]).max() / (chord @ chord))


def outcome(
    make: Callable[[], Transform], bound: float, shapes: tuple[Shape, Shape], refine_ms: float, bend_ms: float
) -> Outcome:
    """Construct, and measure; the times are those of what went before."""
    start = time.process_time()
    transform, reason = None, ""
    try:
        transform = make()
    except RiotError as error:
        reason = getattr(error, "reason", "error")
    times = refine_ms, bend_ms, 1e3 * (time.process_time() - start)
    if transform is None:
        return Outcome(Figures(bound, np.nan, np.nan, 0.0, 0.0, 0.0, *times, reason), shapes, None, None)
    deformation = measure_deformation(transform)
    bends = (transform.bend_p, transform.bend_q) if transform.bend_p and transform.bend_q else None
    figures = Figures(
        bound,
        deformation.iou,
        min(deformation.input_iou_p, deformation.input_iou_q),
        max(deformation.rms_strain_p, deformation.rms_strain_q),
        max(deformation.max_strain_p, deformation.max_strain_q),
        max(map(sag, bends)) if bends else 0.0,
        *times,
        reason,
    )
    return Outcome(figures, shapes, transform, bends)


def compare(paths: tuple[Path, Path], ways: dict[str, BendParameters]) -> dict[str, Outcome]:
    """All ways of one pair; raises RiotError if it has no trunks."""
    p, q = map(shape_of, paths)
    start = time.process_time()
    plans, unplanned = find_plans(p, q, REFINEMENT)
    refine_ms = 1e3 * (time.process_time() - start)
    if not plans:
        raise unplanned[0]
    unbent = outcome(lambda: construct_plans(plans, unplanned, CONSTRUCTION), plans[0].bound, (p, q), refine_ms, 0.0)
    outcomes = {"unbent": unbent}
    for name, parameters in ways.items():
        (of_p, ms_p), (of_q, ms_q) = (elastic(path, parameters.straight, parameters.modes) for path in paths)
        start = time.process_time()
        starts, _ = find_plans(p, q, REFINEMENT, None, parameters.starts)
        found_ms = 1e3 * (time.process_time() - start)
        bent = bend_plans(starts, of_p, of_q, parameters, REFINEMENT, CONSTRUCTION)
        bend_ms = 1e3 * (time.process_time() - start) - found_ms + ms_p + ms_q
        outcomes[name] = outcome(
            partial(construct_bent, bent, starts, unplanned, parameters, CONSTRUCTION),
            bent[0].plan.bound, (p, q), found_ms, bend_ms,
        )  # fmt: skip
    return outcomes


def show(results: Sequence[dict[str, Outcome]]) -> None:
    """Print medians with quartiles of every way, over the pairs that it has constructed."""
    table = Table(f"{len(results)} pairs", box=box.SIMPLE_HEAD, pad_edge=False)
    for name in ("rejected", "bound", "IoU", "IoU ≥ .92", "IoU with input", "rms strain", "greatest", "sag",
                 "refine ms", "bend ms", "construct ms", "refine + bend + construct p90"):  # fmt: skip
        table.add_column(name, justify="right")
    for way in results[0]:
        figures = [outcomes[way].figures for outcomes in results]
        ious = np.array([one.iou for one in figures])
        total = [one.refine_ms + one.bend_ms + one.construct_ms for one in figures]
        table.add_row(
            way,
            f"{np.isnan(ious).mean():.0%}",
            _quartiles([one.bound for one in figures], 3),
            _quartiles(ious, 3),
            f"{(ious >= 0.92).mean():.0%}",
            _quartiles([one.input_iou for one in figures], 3),
            *(_quartiles([100.0 * getattr(one, name) for one in figures], 1)
              for name in ("rms_strain", "max_strain", "sag")),
            *(f"{np.median([getattr(one, name) for one in figures]):.0f}"
              for name in ("refine_ms", "bend_ms", "construct_ms")),
            f"{np.quantile(total, 0.9):.0f}",
        )  # fmt: skip
    Console(highlight=False, width=WIDTH).print(table)


def _quartiles(values: Sequence[float] | np.ndarray, digits: int) -> str:
    known = np.asarray(values, dtype=np.float64)
    known = known[np.isfinite(known)]
    if len(known) == 0:
        return "–"
    low, middle, high = (f"{value:.{digits}f}" for value in np.quantile(known, (0.25, 0.5, 0.75)))
    return f"{middle} ({low}–{high})"


def draw(results: Sequence[dict[str, Outcome]], way: str, path: Path) -> None:
    """A sheet: input in grey with the unbent result, and input in grey with the bent outline and result, of each."""
    columns = 4
    rows = -(-len(results) // columns)
    figure, grid = plt.subplots(rows, 4 * columns, figsize=(5.6 * columns, 1.5 * rows), squeeze=False)
    for axes in grid.ravel():
        axes.set_axis_off()
        axes.set_aspect("equal")
    for number, outcomes in enumerate(results):
        row, column = divmod(number, columns)
        for side in range(2):
            for kind, name in enumerate(("unbent", way)):
                result = outcomes[name]
                axes = grid[row, 4 * column + 2 * side + kind]
                bend = result.bends[side] if result.bends else None
                axes.fill(*outcomes[name].shapes[side].points.T, color="0.8")
                if bend is not None:
                    axes.plot(*np.concatenate([bend.bent.points, bend.bent.points[:1]]).T, color="C0", lw=0.6)
                if result.transform is not None:
                    outline = result.transform.outline_p() if side == 0 else result.transform.outline_q()
                    axes.plot(*np.concatenate([outline, outline[:1]]).T, color="C3", lw=0.7)
                figures = result.figures
                text = f"{figures.iou:.3f}" if result.transform is not None else figures.reason
                if bend is not None:
                    text += f" {bend.rms_strain:.1%}"
                axes.set_title(f"{outcomes[name].shapes[side].name}\n{text}" if kind == 0 else text, fontsize=6, pad=1)
    figure.tight_layout(pad=0.3)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare, print the table, write JSON and a sheet of pictures if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--run", type=Path, required=True, help="the folder of a finished run")
    parser.add_argument("--root", type=Path, required=True, help="the folder of its pictures")
    parser.add_argument("--pairs", type=int, default=40, help="so many pairs of classes")
    parser.add_argument("--seed", type=int, default=2026, help="of their choice")
    parser.add_argument("--best", action="store_true", help="each class's best transform of the run instead")
    parser.add_argument("--weights", type=float, nargs="+", default=[BendParameters.weight], help="of the strain")
    parser.add_argument("--straight", type=float, default=BendParameters.straight, help="weight of straight sides")
    parser.add_argument("--sheet", type=Path, help="draw the pairs to this file, bent with the first weight")
    parser.add_argument("--json", type=Path, help="write the figures to this file too")
    chosen = parser.parse_args(arguments)
    ways = {f"{weight:g}": BendParameters(weight=weight, straight=chosen.straight) for weight in chosen.weights}
    warm_all(lambda text: print(text, file=sys.stderr))
    results = []
    pairs = best_of_classes(chosen.run) if chosen.best else class_pairs(chosen.run, chosen.pairs, chosen.seed)
    for sources in pairs:
        try:
            outcomes = compare((chosen.root / sources[0], chosen.root / sources[1]), ways)
        except RiotError as error:
            print(f"{sources[0]}, {sources[1]}: {error}", file=sys.stderr)
            continue
        results.append(outcomes)
        words = ", ".join(f"{name} {one.figures.iou:.3f}{one.figures.reason}" for name, one in outcomes.items())
        print(f"{sources[0]}, {sources[1]}: {words}", file=sys.stderr, flush=True)
    show(results)
    if chosen.sheet:
        draw(results, next(iter(ways)), chosen.sheet)
    if chosen.json:
        document = {"format": FORMAT, "pairs": [{k: asdict(v.figures) for k, v in r.items()} for r in results]}
        chosen.json.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
