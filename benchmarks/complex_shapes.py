"""How far shapes that are too intricate for the paper's search can be turned, and which parameters would help.

    python benchmarks/complex_shapes.py --root DIR --each 2 --among 200

Pictures below DIR are named CLASS-NAME. Of each class that is asked for some shapes are taken, evenly chosen, and
their best partners of other classes are looked for among the others and an even choice of the whole collection: by
QCRS, by CRS, on refined trunks. Each way changes some parameters of the search and keeps the rest (`WAYS`).
"""

from __future__ import annotations

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)

# ruff: isort: split
import argparse
import json
import math
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
from inputs import pictures
from rich import box
from rich.console import Console
from rich.table import Table

from pipeline.study.partners import Clock, StudiedPartners
from riot.errors import RiotError
from riot.geometry.shape import Shape
from riot.geometry.silhouette import read
from riot.kernels.warm import warm_all
from riot.parameters import RefineParameters, TrunkParameters
from riot.scores.vertices import convex_points
from riot.transform.transform import Transform
from riot.types import FloatArray

FORMAT = 1
"""Version of the JSON."""

STARS = ("device0", "device1", "device2", "device5", "device7")
"""Classes of MPEG-7 with arms around a middle: five, six, eight, four and ten of them."""
OTHERS = ("device3", "device4", "device6", "device8", "device9", "octopus", "spring")
"""Classes of MPEG-7 with notches, slits and long limbs, or rounds without corners."""
WIDTH = 180


@dataclass(frozen=True)
class Way:
    """Parameters of the search; ``keep`` partners by QCRS go on to CRS, ``few`` by CRS to refined trunks."""

    trunks: TrunkParameters = field(default_factory=TrunkParameters)
    refinement: RefineParameters = field(default_factory=RefineParameters)
    keep: int = 40
    few: int = 3


FINER = RefineParameters(candidates=64, sketched=64, refined=8)
WAYS = {
    "default": Way(),
    "tau_s 0.07": Way(TrunkParameters(tau_s=0.07)),
    "tau_s 0.05": Way(TrunkParameters(tau_s=0.05)),
    "spacing 22": Way(TrunkParameters(spacing=22.0)),
    "min_area 0.005": Way(TrunkParameters(min_area=0.005)),
    "neck_width 0": Way(TrunkParameters(neck_width=0.0)),
    "candidates 64": Way(refinement=FINER),
    "keep 160, few 12": Way(keep=160, few=12),
    "tau_s 0.07, area 0.005, candidates 64, keep 160, few 12": Way(
        TrunkParameters(tau_s=0.07, min_area=0.005), FINER, 160, 12
    ),
}
"""By the names that --ways takes, by number from 0."""


@dataclass(frozen=True)
class Turned:
    """What one way makes of one shape.

    ``convex`` is the paper's K; ``quick`` and ``full`` count the shape's candidate trunks, ``most`` is the greatest n
    of the latter. ``iou`` is that of the worse shape with the best partner, nan without one, ``n`` its pieces.
    ``cpu_s`` counts the shape's own full trunks, its CRS and its construction.
    """

    cls: str
    name: str
    convex: int
    quick: int
    full: int
    most: int
    partner: str
    iou: float
    n: int
    cpu_s: float


@dataclass(frozen=True)
class WayOutcome:
    """One way: its shapes, and the CPU seconds that the trunks of all shapes, and QCRS, have cost."""

    way: str
    shapes: list[Turned]
    seconds: dict[str, float]


def run_way(name: str, way: Way, asked: Sequence[Shape], among: Sequence[Shape]) -> WayOutcome:
    """The best partner of every shape that is asked for."""
    clock = Clock()
    partners = StudiedPartners([*asked, *among], way.trunks, way.refinement)
    clock.tick("quick trunks")
    scores = partners.quick_scores(len(asked))
    clock.tick("QCRS")
    # The partners' trunks are made once for all that ask.
    for k in range(len(asked), len(partners.shapes)):
        partners.side(k)
    clock.tick("full trunks")
    turned = []
    for i, row in enumerate(scores):
        own = Clock()
        turned.append(turn(partners, i, row, way, own))
    clock.tick("CRS and construction")
    return WayOutcome(name, turned, clock.seconds)


def turn(partners: StudiedPartners, i: int, scores: FloatArray, way: Way, own: Clock) -> Turned:
    """The best partner of shape i."""
    shape = partners.shapes[i]
    other = [
        int(j) for j in np.argsort(-scores, kind="stable") if class_of(partners.shapes[j].name) != class_of(shape.name)
    ]
    cross = {j: partners.cross(i, j) for j in other[: way.keep] if scores[j] > 0.0}
    few = [j for j in sorted(cross, key=lambda j: (-cross[j], j))[: way.few] if cross[j] > 0.0]
    ious = partners.best(i, few)
    first = max(ious, key=lambda j: (ious[j], -j), default=-1)
    transform = partners.transform(i, first) if ious else None
    own.tick("all")
    full = partners.side(i).trunks
    return Turned(
        cls=class_of(shape.name),
        name=shape.name,
        convex=len(convex_points(shape, way.trunks)),
        quick=len(partners.quick[i]),
        full=len(full),
        most=int(full.sizes.max(initial=0)),
        partner=partners.shapes[first].name if ious else "",
        iou=ious[first] if ious else math.nan,
        n=len(transform.pieces) if isinstance(transform, Transform) else 0,
        cpu_s=own.seconds["all"],
    )


def class_of(name: str) -> str:
    """Of CLASS-NAME, the class."""
    return name.rsplit("-", 1)[0]


def show(outcomes: Sequence[WayOutcome], console: Console) -> None:
    """Print, of each class and way, the best shape's IoU and n; of each way, quantiles, counts and times."""
    numbered = Table("class", "K", "trunks", box=box.SIMPLE_HEAD, pad_edge=False)
    for k, outcome in enumerate(outcomes):
        numbered.add_column(f"({k}) {outcome.way}" if len(outcome.way) < 20 else f"({k})", justify="right")
    numbered.add_column("best partner, way")
    for cls in dict.fromkeys(shape.cls for shape in outcomes[0].shapes):
        mine = [[shape for shape in outcome.shapes if shape.cls == cls] for outcome in outcomes]
        best = [max(shapes, key=lambda shape: -1.0 if math.isnan(shape.iou) else shape.iou) for shapes in mine]
        cells = ["none" if math.isnan(shape.iou) else f"{shape.iou:.3f}  n {shape.n}" for shape in best]
        top = max(range(len(best)), key=lambda k: -1.0 if math.isnan(best[k].iou) else best[k].iou)
        convex = "–".join(str(count) for count in sorted({shape.convex for shape in mine[0]}))
        trunks = f"{np.median([shape.full for shape in mine[0]]):.0f}"
        words = f"{best[top].name} → {best[top].partner} ({top})"
        numbered.add_row(f"{cls}{' *' if cls in STARS else ''}", convex, trunks, *cells, words)
    console.print(numbered)
    console.print("The best of the shapes of each class: IoU of the worse shape, number of pieces. * stars.")
    table = Table("way", box=box.SIMPLE_HEAD, pad_edge=False)
    for name in (
        *("median IoU", "p25", "≥ 0.9", "≥ 0.95", "no partner", "trunks, median", "greatest n", "n found"),
        *("better", "worse", "CPU s a shape", "CPU s, trunks of all"),
    ):
        table.add_column(name, justify="right")
    for k, outcome in enumerate(outcomes):
        table.add_row(f"({k}) {outcome.way}", *_summary(outcome, outcomes[0]))
    console.print(table)
    console.print("better, worse: shapes whose IoU is by more than 0.002 above or below that of the first way.")


def _summary(outcome: WayOutcome, first: WayOutcome) -> list[str]:
    ious = np.array([0.0 if math.isnan(shape.iou) else shape.iou for shape in outcome.shapes])
    before = np.array([0.0 if math.isnan(shape.iou) else shape.iou for shape in first.shapes])
    sizes = sorted({shape.n for shape in outcome.shapes if shape.n})
    counts = ", ".join(f"{n}: {sum(shape.n == n for shape in outcome.shapes)}" for n in sizes)
    return [
        *(f"{np.quantile(ious, q):.3f}" for q in (0.5, 0.25)),
        *(f"{(ious >= limit).sum()}/{len(ious)}" for limit in (0.9, 0.95)),
        str(sum(math.isnan(shape.iou) for shape in outcome.shapes)),
        f"{np.median([shape.full for shape in outcome.shapes]):.0f}",
        str(max(shape.most for shape in outcome.shapes)),
        counts,
        *(str(int(count)) for count in ((ious > before + 0.002).sum(), (ious < before - 0.002).sum())),
        f"{np.mean([shape.cpu_s for shape in outcome.shapes]):.2f}",
        f"{outcome.seconds['quick trunks'] + outcome.seconds['full trunks']:.1f}",
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    """Search in every way, print, write JSON if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=Path, required=True, help="a folder of pictures named CLASS-NAME")
    parser.add_argument("--classes", default=",".join((*STARS, *OTHERS)), help="with commas")
    parser.add_argument("--each", type=int, default=2, help="shapes of each class")
    parser.add_argument("--among", type=int, default=200, help="pictures, evenly chosen, to look for partners in")
    parser.add_argument("--ways", help=f"numbers with commas; 0 … {len(WAYS) - 1}: {'; '.join(WAYS)}")
    parser.add_argument("--json", type=Path, help="write the figures to this file too")
    chosen = parser.parse_args(arguments)
    paths = pictures(chosen.root)
    asked_paths: list[Path] = []
    for cls in chosen.classes.split(","):
        members = [path for path in paths if class_of(path.stem) == cls]
        if not members:
            parser.error(f"no pictures {cls}-… under {chosen.root}")
        numbers = np.unique(np.linspace(0, len(members) - 1, min(chosen.each, len(members))).astype(np.int64))
        asked_paths += [members[k] for k in numbers]
    names = list(WAYS)
    try:
        ways = names if chosen.ways is None else [names[int(number)] for number in chosen.ways.split(",")]
    except (ValueError, IndexError):
        parser.error(f"--ways {chosen.ways}: numbers from 0 to {len(names) - 1}, with commas")

    warm_all(_say)
    asked = _read_all(asked_paths)
    among = _read_all([path for path in pictures(chosen.root, chosen.among) if path not in asked_paths])
    outcomes = []
    for name in ways:
        _say(f"{name} …")
        outcomes.append(run_way(name, WAYS[name], asked, among))
    console = Console(highlight=False)
    console = console if console.is_terminal else Console(highlight=False, width=WIDTH)
    console.print(f"{len(asked)} shapes, partners among {len(asked) + len(among)}.")
    show(outcomes, console)
    if chosen.json:
        document = {"format": FORMAT, "each": chosen.each, "shapes": len(asked) + len(among)}
        document["ways"] = [{**asdict(outcome), "parameters": asdict(WAYS[outcome.way])} for outcome in outcomes]
        chosen.json.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return 0


def _read_all(paths: Sequence[Path]) -> list[Shape]:
    shapes = []
    for path in paths:
        try:
            shapes.append(read(path))
        except RiotError as error:
            _say(f"{path.name}: {error}")
    return shapes


def _say(message: str) -> None:
    print(message, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
