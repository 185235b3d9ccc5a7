"""The paper's construction beside the exact one, on the same trunks: what is left over, how close, at what cost.

    python benchmarks/methods.py                               exact pairs, rendered to pictures
    python benchmarks/methods.py --root DIR --shapes 60        the best pairs of some of the pictures below DIR
    python benchmarks/methods.py --transforms DIR --pairs 40   the trunk pairs of transforms that a run has made

Of every pair the first trunk pair that can be made conjugate is constructed on: by the paper's method, by the exact
one, by the exact one after the trunks were moved for the best bound, as the library does it, and by the exact one after
both shapes were bent a little too, whose IoU and distances are with the bent shapes. All figures are of the worse of
the two shapes. Gaps, overlaps and outside are areas in the trunks, of unit-area shapes, measured by scanlines
for all ways alike; a way's quantiles are over the pairs that none has refused.
"""

from __future__ import annotations

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)

# ruff: isort: split
import argparse
import json
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from inputs import SIZES, pictures, render
from measure import time_items
from rich import box
from rich.console import Console
from rich.table import Table
from table import WIDTH

from riot.construction.given_trunks import given_pair
from riot.construction.laplacian.method import construct_laplacian
from riot.construction.laplacian.residual import residuals
from riot.construction.plan import ConstructionPlan, TrunkPair, plan_pair
from riot.construction.plan_search import refine_best
from riot.construction.plan_transform import construct_plan, construct_plans
from riot.construction.trunk_choice import construct_from
from riot.errors import RiotError
from riot.geometry.shape import Shape
from riot.geometry.silhouette import read
from riot.kernels.warm import warm_all
from riot.parameters import BendParameters, ConstructParameters, RefineParameters
from riot.scores.crs import best_trunk_pairs
from riot.scores.qcrs import score_block
from riot.scores.trunk_stack import stack
from riot.scores.trunks import full_trunks, quick_trunks
from riot.transform.certificate import certify
from riot.transform.deformation import measure_deformation
from riot.transform.riot_file import load
from riot.transform.transform import Transform

FORMAT = 1
"""Version of the JSON."""

PARAMETERS, REFINEMENT, BEND = ConstructParameters(), RefineParameters(), BendParameters(method="elastic")

QUANTILES = {"median": 0.5, "p90": 0.9, "worst": 1.0}
"""Of figures that are better the smaller; of the others the same from the other end."""


@dataclass(frozen=True)
class Figures:
    """What one way makes of one pair, of the worse shape; lengths in units of ``L_c``."""

    gaps: float
    overlaps: float
    outside: float
    iou: float
    hausdorff: float
    cpu_ms: float
    certified: bool
    """The certificate passes: pieces tile both shapes, and neither outline touches itself."""


WORDS = {
    "gaps": "gaps",
    "overlaps": "overlaps",
    "outside": "outside",
    "iou": "IoU",
    "hausdorff": "Hausdorff / L_c",
    "cpu_ms": "CPU ms",
}


@dataclass(frozen=True)
class Compared:
    """One pair: names, number of pieces, and the figures of every way; None where it was refused."""

    p: str
    q: str
    n: int
    ways: dict[str, Figures | None]


Way = Callable[[ConstructionPlan], Transform]

WAYS: dict[str, Way] = {
    "paper": lambda plan: construct_laplacian(plan, PARAMETERS),
    "exact": lambda plan: construct_plan(plan, PARAMETERS),
    "exact, refined": lambda plan: construct_plans(refine_best([plan], REFINEMENT), [], PARAMETERS),
    "exact, bent": lambda plan: construct_from(refine_best([plan], REFINEMENT), [], PARAMETERS, REFINEMENT, bend=BEND),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, print the tables, write JSON if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", choices=SIZES, default="medium")
    source = parser.add_mutually_exclusive_group()
    source.add_argument("--root", type=Path, help="a folder of pictures instead of exact pairs")
    source.add_argument("--transforms", type=Path, help="a folder of .riot files instead")
    parser.add_argument("--shapes", type=int, help="number of pictures instead of the size's")
    parser.add_argument("--pairs", type=int, help="number of pairs instead of the size's")
    parser.add_argument("--json", type=Path, help="write the figures to this file too")
    chosen = parser.parse_args(arguments)
    size = SIZES[chosen.size]
    wanted, count = chosen.pairs or size.pairs, chosen.shapes or size.shapes

    with tempfile.TemporaryDirectory() as folder:
        if chosen.transforms:
            paths = sorted(chosen.transforms.rglob("*.riot"))
            if not paths:
                parser.error(f"no .riot file under {chosen.transforms}")
        else:
            paths = pictures(chosen.root, count) if chosen.root else render(count, Path(folder))
            if len(paths) < 2:
                parser.error(f"fewer than two pictures under {chosen.root}")
        warm_all(lambda message: print(message, file=sys.stderr))
        plans = (_plans_of_run if chosen.transforms else _plans_of_pictures)(paths, wanted)
    pairs = compare(plans)
    show(pairs)
    if chosen.json:
        source_name = "transforms" if chosen.transforms else "folder" if chosen.root else "exact pairs"
        document = {"format": FORMAT, "source": source_name, "pairs": [asdict(pair) for pair in pairs]}
        document["quantiles"] = {way: quantiles(pairs, way) for way in WAYS}
        chosen.json.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return 0


def compare(plans: Sequence[ConstructionPlan]) -> list[Compared]:
    """Construct on every plan in every way."""
    timed = {name: time_items(way, plans) for name, way in WAYS.items()}
    compared = []
    for k, plan in enumerate(plans):
        ways = {name: _figures(way.results[k], way.ms[k]) for name, way in timed.items()}
        compared.append(Compared(plan.pair.p.name, plan.pair.q.name, len(plan.trunk_p), ways))
    return compared


def _figures(transform: Transform | None, ms: float) -> Figures | None:
    if transform is None:
        return None
    worse = max(residuals(transform), key=lambda residual: residual.total)
    deformation = measure_deformation(transform)
    return Figures(
        worse.gaps,
        worse.overlaps,
        worse.outside,
        deformation.iou,
        max(deformation.hausdorff_p, deformation.hausdorff_q),
        ms,
        certify(transform).passed,
    )


def _plans_of_run(paths: Sequence[Path], count: int) -> list[ConstructionPlan]:
    """Plans on the trunks that the first of these transforms were constructed from."""
    plans: list[ConstructionPlan] = []
    for path in paths:
        if len(plans) == count:
            break
        made = load(path)
        try:
            pair = given_pair(made.p, made.q, made.trunk_p, made.trunk_q, PARAMETERS.snap, REFINEMENT.reach)
            plans.append(plan_pair(pair))
        except RiotError as error:
            print(f"{path.name}: {error}", file=sys.stderr)
    return plans


def _plans_of_pictures(paths: Sequence[Path], count: int) -> list[ConstructionPlan]:
    """Plans of the pairs of highest QCRS, each on its first trunk pair by CRS that can be made conjugate."""
    shapes = []
    for path in paths:
        try:
            shapes.append(read(path))
        except RiotError as error:
            print(f"{path.name}: {error}", file=sys.stderr)
    quick = stack([quick_trunks(shape) for shape in shapes])
    scores = score_block(quick, quick, None, True)
    plans: list[ConstructionPlan] = []
    for k in np.argsort(-scores.score, kind="stable"):
        if len(plans) == count or scores.score[k] <= 0.0:
            break
        plan = _first_plan(shapes[scores.i[k]], shapes[scores.j[k]])
        if plan is not None:
            plans.append(plan)
    return plans


def _first_plan(p: Shape, q: Shape) -> ConstructionPlan | None:
    trunks_p, trunks_q = full_trunks(p), full_trunks(q)
    if len(trunks_p) == 0 or len(trunks_q) == 0:
        return None
    for score in best_trunk_pairs(p, q, trunks_p, trunks_q, count=REFINEMENT.candidates):
        try:
            return plan_pair(TrunkPair(p, q, p.points, q.points, score.trunk_a, score.trunk_b, REFINEMENT.reach))
        except RiotError:
            continue
    return None


def quantiles(pairs: Sequence[Compared], way: str) -> dict[str, dict[str, float]]:
    """Of each figure, over the pairs that no way has refused; empty if there is none."""
    common = [pair.ways[way] for pair in pairs if all(pair.ways.values())]
    if not common:
        return {}
    return {
        name: {
            words: float(np.quantile([getattr(outcome, name) for outcome in common], 1.0 - q if name == "iou" else q))
            for words, q in QUANTILES.items()
        }
        for name in WORDS
    }


def show(pairs: Sequence[Compared], console: Console | None = None) -> None:
    """Print a line for each pair, and the quantiles."""
    console = console or Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=WIDTH, file=console.file)
    rows = Table("pair", "n", box=box.SIMPLE_HEAD, pad_edge=False)
    for way in WAYS:
        rows.add_column(way, justify="right", no_wrap=True)
    for pair in pairs:
        rows.add_row(f"{pair.p} → {pair.q}", str(pair.n), *(_cell(pair.ways[way]) for way in WAYS))
    console.print(rows)
    console.print("Of each way: gaps + overlaps + outside; IoU; Hausdorff / L_c; CPU ms.", soft_wrap=True)
    table = Table("", box=box.SIMPLE_HEAD, pad_edge=False)
    for way in WAYS:
        for words in QUANTILES:
            table.add_column(f"{way}\n{words}", justify="right")
    each_way = {way: quantiles(pairs, way) for way in WAYS}
    for name, words in WORDS.items():
        cells = [f"{of[name][q]:.3g}" if of else "" for of in each_way.values() for q in QUANTILES]
        table.add_row(words, *cells)
    console.print(table)
    common = sum(all(pair.ways.values()) for pair in pairs)
    console.print(f"{len(pairs)} pairs; quantiles over the {common} that no way refused.", soft_wrap=True)
    for way in WAYS:
        accepted = [figures for pair in pairs if (figures := pair.ways[way]) is not None]
        passed = sum(figures.certified for figures in accepted)
        console.print(f"{way}: {len(pairs) - len(accepted)} refused, {passed} certified.", soft_wrap=True)


def _cell(figures: Figures | None) -> str:
    if figures is None:
        return "refused"
    areas = f"{figures.gaps:.4f} + {figures.overlaps:.4f} + {figures.outside:.4f}"
    return f"{areas}; {figures.iou:.4f}; {figures.hausdorff:.4f}; {figures.cpu_ms:.0f}"


if __name__ == "__main__":
    sys.exit(main())
