"""Whether the search finds the partner of a shape when there is one: exact pairs hidden in a collection.

    python benchmarks/recovery.py --pairs 20                     exact pairs among one another
    python benchmarks/recovery.py --root DIR --pairs 100         the same among the pictures below DIR

Exact reversible pairs (`riot.groundtruth.pairs`), of stars and binary trees, with straight and curved arcs, are drawn
as pictures. `pipeline.study.recovery` says what becomes of them; `python -m pipeline.study groundtruth` hides them
among the shapes of a finished run instead.
"""

from __future__ import annotations

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)

# ruff: isort: split
import argparse
import json
import math
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from inputs import pictures
from rich import box
from rich.console import Console
from rich.table import Table

from pipeline.study.hidden import Hidden, hide
from pipeline.study.partners import Clock, StudiedPartners, changed
from pipeline.study.recovery import (
    QUANTILES,
    WAYS,
    Closeness,
    Recovery,
    RecoverySearch,
    RecoveryShare,
    figures,
    quantiles,
)
from riot.draw.figure import draw_transform
from riot.errors import RiotError
from riot.geometry.shape import Shape
from riot.geometry.silhouette import read
from riot.kernels.warm import warm_all
from riot.parameters import QCRS_VARIANTS
from riot.transform.transform import Transform

FORMAT = 1
"""Version of the JSON."""

WIDTH = 150


def show(rows: Sequence[RecoveryShare], close: Sequence[Closeness], causes: Counter[str], console: Console) -> None:
    """Print the tables."""
    sizes = sorted({n for row in rows for n in row.by_n})
    table = Table("", box=box.SIMPLE_HEAD, pad_edge=False)
    for name in ("share", "count", "95 %", "target", "met", *(f"n = {n}" for n in sizes)):
        table.add_column(name, justify="right", no_wrap=True)
    for row in rows:
        met = "" if row.target is None else "yes" if row.share >= row.target else "NO"
        aim = "" if row.target is None else f"{row.target:.0%}"
        cells = [f"{good}/{of}" for good, of in row.by_n.values()]
        interval = f"{row.low:.1%} – {row.high:.1%}"
        table.add_row(row.name, f"{row.share:.1%}", f"{row.good}/{row.of}", interval, aim, met, *cells)
    console.print(table)
    ious = Table("IoU of the worse shape", *QUANTILES, "refused", box=box.SIMPLE_HEAD, pad_edge=False)
    for which, iou in quantiles(close).items():
        ious.add_row(WAYS[which], *(f"{iou[word]:.5f}" for word in QUANTILES), f"{iou['refused']:.0f}")
    console.print(ious)
    lost = Table("partner not first in the end; lost at", "shapes", box=box.SIMPLE_HEAD, pad_edge=False)
    for cause, count in causes.most_common():
        lost.add_row(cause, str(count))
    console.print(lost)


def draw_worst(
    search: RecoverySearch, records: Sequence[Recovery], close: Sequence[Closeness], folder: Path, count: int = 4
) -> None:
    """Pictures of the pairs that came out farthest from their inputs, and of those whose partner was lost."""
    folder.mkdir(parents=True, exist_ok=True)
    order = sorted(range(len(close)), key=lambda k: (not math.isnan(close[k].found), close[k].found))
    lost = [k for k in range(len(close)) if records[2 * k].cause or records[2 * k + 1].cause]
    for kind, numbers in (("far", order[:count]), ("lost", lost)):
        for k in numbers:
            transform = search.partners.transform(2 * k, 2 * k + 1)
            if isinstance(transform, Transform):
                draw_transform(transform, folder / f"{kind}-{close[k].name}.png")
            _draw_trunks(search.hidden[2 * k : 2 * k + 2], folder / f"{kind}-{close[k].name}-trunks.png")


def _draw_trunks(sides: Sequence[Hidden], path: Path) -> None:
    import matplotlib.figure

    figure = matplotlib.figure.Figure(figsize=(8, 4))
    for axes, side in zip(figure.subplots(1, 2), sides, strict=True):
        axes.fill(*side.shape.points.T, color="0.8")
        axes.fill(*side.corners.T, fill=False, edgecolor="tab:red")
        axes.set_aspect("equal")
        axes.set_title(side.shape.name)
        axes.axis("off")
    figure.savefig(path)


def main(arguments: Sequence[str] | None = None) -> int:
    """Hide, search, print, write JSON and pictures if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=Path, help="a folder of pictures to hide the pairs among")
    parser.add_argument("--shapes", type=int, help="so many of the pictures, evenly chosen, instead of all")
    parser.add_argument("--pairs", type=int, default=20, help="exact pairs to hide")
    parser.add_argument("--pieces", default="3,4,5,6", help="their numbers of pieces, in turn, with commas")
    parser.add_argument(
        "--deform", type=float, default=0.0, help="deform both shapes, 0.03 is a little, before drawing"
    )
    parser.add_argument("--narrow", action="store_true", help="pairs made with no regard to what the search needs")
    parser.add_argument("--set", nargs="*", default=[], metavar="G.NAME=VALUE", help="parameters: trunks.…, refine.…")
    parser.add_argument("--variant", choices=tuple(QCRS_VARIANTS), default="paper", help="of QCRS")
    parser.add_argument("--keep", type=int, default=100, help="partners by QCRS that go on to CRS")
    parser.add_argument("--few", type=int, default=5, help="partners by CRS that go on to construction")
    parser.add_argument("--json", type=Path, help="write the figures to this file too")
    parser.add_argument("--draw", type=Path, help="write pictures of the worst to this folder")
    chosen = parser.parse_args(arguments)
    if min(chosen.pairs, chosen.keep, chosen.few) < 1:
        parser.error("a number is out of range")
    pieces = [int(number) for number in chosen.pieces.split(",")]
    paths = pictures(chosen.root, chosen.shapes) if chosen.root else []
    if chosen.root and not paths:
        parser.error(f"no pictures under {chosen.root}")

    try:
        trunks, refinement = changed(chosen.set)
    except ValueError as error:
        parser.error(str(error))

    warm_all(_say)
    clock = Clock()
    hidden, left_out = hide(chosen.pairs, pieces, chosen.deform, chosen.narrow)
    clock.tick("making exact pairs")
    others, refused = read_all(paths)
    clock.tick("reading pictures")
    shapes = [side.shape for pair in hidden for side in (pair.p, pair.q)]
    partners = StudiedPartners([*shapes, *others], trunks, refinement, variant=chosen.variant)
    search = RecoverySearch(hidden, partners, chosen.keep, chosen.few)
    records = search.run(_say)
    close = [search.closeness(k) for k in range(len(hidden))]
    seconds = clock.seconds | search.clock.seconds

    rows = figures(records, close, chosen.keep)
    causes = Counter(record.cause for record in records if record.cause)
    console = Console(highlight=False)
    console = console if console.is_terminal else Console(highlight=False, width=WIDTH)
    about = f"{2 * len(hidden)} shapes of {len(hidden)} exact pairs among {len(search.partners.shapes)} shapes"
    console.print(f"{about}; {left_out} pairs left out as degenerate, {refused} pictures refused.", soft_wrap=True)
    show(rows, close, causes, console)
    console.print("CPU s: " + ", ".join(f"{step} {spent:.1f}" for step, spent in seconds.items()), soft_wrap=True)
    if chosen.json:
        settings = {
            name: getattr(chosen, name)
            for name in ("pairs", "pieces", "deform", "narrow", "variant", "set", "keep", "few")
        }
        document = {
            "format": FORMAT,
            **settings,
            "shapes": len(search.partners.shapes),
            "left_out": left_out,
            "refused": refused,
            "figures": [asdict(row) for row in rows],
            "quantiles": quantiles(close),
            "causes": causes,
            "found": [asdict(record) for record in records],
            "closeness": [asdict(record) for record in close],
            "cpu_s": seconds,
        }
        chosen.json.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    if chosen.draw:
        draw_worst(search, records, close, chosen.draw)
    return 0


def read_all(paths: Sequence[Path]) -> tuple[list[Shape], int]:
    """The shapes of pictures, and how many are none."""
    shapes = []
    for path in paths:
        try:
            shapes.append(read(path))
        except RiotError as error:
            _say(f"{path.name}: {error}")
    return shapes, len(paths) - len(shapes)


def _say(message: str) -> None:
    print(message, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
