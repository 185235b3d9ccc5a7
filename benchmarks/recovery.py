"""Whether the search finds the partner of a shape when there is one: exact pairs hidden in a collection.

    python benchmarks/recovery.py --pairs 20                     exact pairs among one another
    python benchmarks/recovery.py --root DIR --pairs 100         the same among the pictures below DIR

Exact reversible pairs (`riot.groundtruth`), of stars and binary trees, with straight and curved arcs, are drawn as
pictures. Every hidden shape is scored with all others by QCRS; the `--keep` best go on to CRS, the `--few` best of
these to refined trunks and construction. Ranks count against the partner where scores are equal. Shares come with 95 %
Wilson intervals that take a pair's two shapes for one trial, for they stand and fall together more often than not.
"""

from __future__ import annotations

import pipeline.threads  # noqa: F401  (before anything that loads a numeric library)

# ruff: isort: split
import argparse
import json
import math
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from hidden import Hidden, HiddenPair, failed_test, hide
from inputs import pictures
from partners import Clock, Partners, attempt, changed
from rich import box
from rich.console import Console
from rich.table import Table

from riot import construct
from riot.errors import RiotError
from riot.kernels.warm import warm_all
from riot.shape import FloatArray, Shape
from riot.silhouette import read
from riot.transform import Transform

FORMAT = 1
"""Version of the JSON."""

POLYGONS, PICTURES = 0.999, 0.985
"""IoU of the worse shape that is aimed at."""
WAYS = {
    "polygons": "polygons, trunks given",
    "pictures": "pictures, trunks given",
    "found": "pictures, trunks found",
}
QUANTILES = {"least": 0.0, "p5": 0.05, "median": 0.5, "greatest": 1.0}
WIDTH = 150


@dataclass(frozen=True)
class Found:
    """What became of the partner of one hidden shape; ranks from 1, None where the partner did not get so far.

    ``quick_lost`` and ``full_lost`` name the test which the shape's or its partner's true trunk fails, "" if none does;
    ``first`` is the partner of highest IoU among those that were constructed.
    """

    name: str
    n: int
    topology: str
    curved: bool
    quick_rank: int
    quick_score: float
    quick_lost: str
    cross_rank: int | None
    cross_score: float
    full_lost: str
    final_rank: int | None
    first: str
    first_iou: float
    cause: str = ""


@dataclass(frozen=True)
class Closeness:
    """IoU of the worse shape of one pair, nan where construction refuses, by what was given."""

    name: str
    n: int
    polygons: float
    pictures: float
    found: float
    refusals: tuple[str, ...] = ()


class Search:
    """A collection with the hidden shapes first: pair k's are 2k and 2k + 1."""

    def __init__(self, hidden: Sequence[HiddenPair], partners: Partners, keep: int, few: int) -> None:
        self.hidden = [side for pair in hidden for side in (pair.p, pair.q)]
        self.pairs, self.keep, self.few = hidden, keep, few
        self.partners, self.clock = partners, Clock()

    def run(self, say: Callable[[str], None]) -> list[Found]:
        """QCRS, CRS and construction for every hidden shape."""
        scores = self.partners.quick_scores(len(self.hidden))
        self.clock.tick("QCRS")
        found = []
        for i, row in enumerate(scores):
            found.append(self.follow(i, row))
            if i % 20 == 19:
                say(f"CRS and construction of {i + 1} of {len(self.hidden)} hidden shapes …")
        return found

    def follow(self, i: int, quick: FloatArray) -> Found:
        """What becomes of the partner of hidden shape i, whose QCRS with all shapes are ``quick``."""
        mate, partners = i ^ 1, self.partners
        kept = [int(j) for j in np.argsort(-quick, kind="stable")[: self.keep] if quick[j] > 0.0]
        cross = {j: partners.cross(i, j) for j in kept}
        cross_score = partners.cross(i, mate)
        self.clock.tick("CRS")
        cross_rank = _rank(np.array([*cross.values()]), kept.index(mate)) if mate in cross else None
        few = [j for j in sorted(cross, key=lambda j: (-cross[j], j))[: self.few] if cross[j] > 0.0]
        ious = partners.best(i, few, mate)
        first = max(ious, key=lambda j: (ious[j], -j), default=-1)
        final_rank = 1 + sum(iou >= ious[mate] for j, iou in ious.items() if j != mate) if mate in ious else None
        self.clock.tick("refinement and construction")
        quick_lost = next(filter(None, (self._failed_test(k, True) for k in (i, mate))), "")
        full_lost = next(filter(None, (self._failed_test(k, False) for k in (i, mate))), "")
        self.clock.tick("looking for the true trunks")
        pair = self.pairs[i // 2]
        found = Found(
            name=self.hidden[i].shape.name,
            n=pair.n,
            topology=pair.topology,
            curved=pair.curved,
            quick_rank=_rank(quick, mate),
            quick_score=float(quick[mate]),
            quick_lost=quick_lost,
            cross_rank=cross_rank,
            cross_score=cross_score,
            full_lost=full_lost,
            final_rank=final_rank,
            first=partners.shapes[first].name if ious else "",
            first_iou=ious[first] if ious else math.nan,
        )
        return replace(found, cause=self._cause(found, i, few))

    def _failed_test(self, k: int, quick: bool) -> str:
        trunks = self.partners.quick[k] if quick else self.partners.side(k).trunks
        return failed_test(self.hidden[k], trunks, quick, self.partners.parameters)

    def _cause(self, found: Found, i: int, few: Sequence[int]) -> str:
        """Where the partner was lost; "" if it is first in the end."""
        if found.final_rank == 1:
            return ""
        if found.cross_rank is None:
            return f"QCRS: {found.quick_lost or 'others score higher'}"
        if i ^ 1 not in few:
            return f"CRS: {found.full_lost or 'others score higher'}"
        if found.final_rank is None:
            refusal = self.partners.transform(i, i ^ 1)
            return f"construction: {getattr(refusal, 'reason', 'refused')}"
        return "construction: another has a higher IoU"

    def closeness(self, number: int) -> Closeness:
        """IoU of one pair from its polygons and from its pictures on the true trunks, and as the search finds it."""
        pair = self.pairs[number]
        polygons = [Shape.from_polygon(each) for each in (pair.exact.p, pair.exact.q)]
        moved = [polygons[0].from_source(pair.exact.trunk_p), polygons[1].from_source(pair.exact.trunk_q)]
        ways: list[Transform | RiotError] = [
            attempt(lambda: construct(polygons[0], polygons[1], trunks=(moved[0], moved[1]))),
            attempt(lambda: construct(pair.p.shape, pair.q.shape, trunks=(pair.p.corners, pair.q.corners[::-1]))),
            self.partners.transform(2 * number, 2 * number + 1),
        ]
        self.clock.tick("construction on given trunks")
        refusals = tuple("" if isinstance(made, Transform) else str(made) for made in ways)
        polygon, given, found = (min(made.overlap_ratios) if isinstance(made, Transform) else math.nan for made in ways)
        return Closeness(f"hidden{number:03d}", pair.n, polygon, given, found, refusals)


def _rank(scores: FloatArray, number: int) -> int:
    return int(np.count_nonzero(scores >= scores[number]))


def wilson(good: float, trials: int) -> tuple[float, float]:
    """95 % interval of a share of ``good`` in ``trials``."""
    z2 = 1.959964**2
    share = good / trials
    middle = (share + z2 / (2 * trials)) / (1 + z2 / trials)
    half = math.sqrt(z2 * (share * (1 - share) + z2 / (4 * trials)) / trials) / (1 + z2 / trials)
    return max(0.0, middle - half), min(1.0, middle + half)


@dataclass(frozen=True)
class Figure:
    """A share of hidden shapes, or of pairs: ``good`` of ``of``, its interval, and what is aimed at."""

    name: str
    good: int
    of: int
    low: float
    high: float
    target: float | None
    by_n: dict[int, tuple[int, int]]

    @property
    def share(self) -> float:
        """``good`` / ``of``."""
        return self.good / self.of


def figures(found: Sequence[Found], close: Sequence[Closeness], keep: int) -> list[Figure]:
    """All shares."""
    tests: list[tuple[str, float | None, Callable[[Found], bool]]] = [
        ("QCRS: a trunk near the true one, both shapes", None, lambda one: one.quick_lost == ""),
        ("QCRS: partner first", None, lambda one: one.quick_rank == 1),
        ("QCRS: among the first three", None, lambda one: one.quick_rank <= 3),
        (f"QCRS: among the first {keep}", None, lambda one: one.cross_rank is not None),
        ("CRS: a trunk near the true one, both shapes", None, lambda one: one.full_lost == ""),
        ("CRS: partner first", None, lambda one: one.cross_rank == 1),
        ("CRS: among the first three", 0.9, lambda one: one.cross_rank is not None and one.cross_rank <= 3),
        ("construction: partner first by IoU", 0.95, lambda one: one.final_rank == 1),
    ]
    rows = [_figure(name, target, [(one.n, test(one)) for one in found], 2) for name, target, test in tests]
    # What ranking costs: the partner's own trunks, refined, may be better than all that got so far.
    above = [(one.n, close[k // 2].found >= one.first_iou or one.final_rank == 1) for k, one in enumerate(found)]
    rows.append(_figure("IoU with the partner above all constructed", None, above, 2))
    for which, words in WAYS.items():
        aim = POLYGONS if which == "polygons" else PICTURES
        results = [(one.n, getattr(one, which) >= aim) for one in close]
        rows.append(_figure(f"IoU ≥ {aim}: {words}", None, results, 1))
    return rows


def _figure(name: str, target: float | None, results: Sequence[tuple[int, bool]], together: int) -> Figure:
    good, of = sum(ok for _, ok in results), len(results)
    sizes = sorted({n for n, _ in results})
    by_n = {n: (sum(ok for m, ok in results if m == n), sum(m == n for m, _ in results)) for n in sizes}
    return Figure(name, good, of, *wilson(good / together, of // together), target, by_n)


def quantiles(close: Sequence[Closeness]) -> dict[str, dict[str, float]]:
    """IoU of the worse shape, of the pairs that were constructed."""
    rows = {}
    for which in WAYS:
        ious = np.array([getattr(one, which) for one in close])
        good = ious[~np.isnan(ious)]
        row = {word: float(np.quantile(good, q)) if len(good) else math.nan for word, q in QUANTILES.items()}
        rows[which] = {**row, "refused": float(len(ious) - len(good))}
    return rows


def show(rows: Sequence[Figure], close: Sequence[Closeness], causes: Counter[str], console: Console) -> None:
    """Print the tables."""
    sizes = sorted({n for each in rows for n in each.by_n})
    table = Table("", box=box.SIMPLE_HEAD, pad_edge=False)
    for name in ("share", "count", "95 %", "target", "met", *(f"n = {n}" for n in sizes)):
        table.add_column(name, justify="right", no_wrap=True)
    for each in rows:
        met = "" if each.target is None else "yes" if each.share >= each.target else "NO"
        aim = "" if each.target is None else f"{each.target:.0%}"
        cells = [f"{good}/{of}" for good, of in each.by_n.values()]
        interval = f"{each.low:.1%} – {each.high:.1%}"
        table.add_row(each.name, f"{each.share:.1%}", f"{each.good}/{each.of}", interval, aim, met, *cells)
    console.print(table)
    ious = Table("IoU of the worse shape", *QUANTILES, "refused", box=box.SIMPLE_HEAD, pad_edge=False)
    for which, row in quantiles(close).items():
        ious.add_row(WAYS[which], *(f"{row[word]:.5f}" for word in QUANTILES), f"{row['refused']:.0f}")
    console.print(ious)
    lost = Table("partner not first in the end; lost at", "shapes", box=box.SIMPLE_HEAD, pad_edge=False)
    for cause, count in causes.most_common():
        lost.add_row(cause, str(count))
    console.print(lost)


def draw_worst(
    search: Search, found: Sequence[Found], close: Sequence[Closeness], folder: Path, count: int = 4
) -> None:
    """Pictures of the pairs that came out farthest from their inputs, and of those whose partner was lost."""
    folder.mkdir(parents=True, exist_ok=True)
    order = sorted(range(len(close)), key=lambda k: (not math.isnan(close[k].found), close[k].found))
    lost = [k for k in range(len(close)) if found[2 * k].cause or found[2 * k + 1].cause]
    for kind, numbers in (("far", order[:count]), ("lost", lost)):
        for k in numbers:
            made = search.partners.transform(2 * k, 2 * k + 1)
            if isinstance(made, Transform):
                made.draw(folder / f"{kind}-{close[k].name}.png")
            _draw_trunks(search.hidden[2 * k : 2 * k + 2], folder / f"{kind}-{close[k].name}-trunks.png")


def _draw_trunks(sides: Sequence[Hidden], path: Path) -> None:
    import matplotlib.figure

    figure = matplotlib.figure.Figure(figsize=(8, 4))
    for axes, each in zip(figure.subplots(1, 2), sides, strict=True):
        axes.fill(*each.shape.points.T, color="0.8")
        axes.fill(*each.corners.T, fill=False, edgecolor="tab:red")
        axes.set_aspect("equal")
        axes.set_title(each.shape.name)
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
    parser.add_argument("--keep", type=int, default=100, help="partners by QCRS that go on to CRS")
    parser.add_argument("--few", type=int, default=5, help="partners by CRS that go on to construction")
    parser.add_argument("--json", type=Path, help="write the figures to this file too")
    parser.add_argument("--draw", type=Path, help="write pictures of the worst to this folder")
    chosen = parser.parse_args(arguments)
    if min(chosen.pairs, chosen.keep, chosen.few) < 1:
        parser.error("a number is out of range")
    pieces = [int(part) for part in chosen.pieces.split(",")]
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
    partners = Partners([*shapes, *others], trunks, refinement)
    clock.tick("quick trunks")
    search = Search(hidden, partners, chosen.keep, chosen.few)
    found = search.run(_say)
    close = [search.closeness(k) for k in range(len(hidden))]
    seconds = clock.seconds | search.clock.seconds

    rows = figures(found, close, chosen.keep)
    causes = Counter(one.cause for one in found if one.cause)
    console = Console(highlight=False)
    console = console if console.is_terminal else Console(highlight=False, width=WIDTH)
    about = f"{2 * len(hidden)} shapes of {len(hidden)} exact pairs among {len(search.partners.shapes)} shapes"
    console.print(f"{about}; {left_out} pairs left out as degenerate, {refused} pictures refused.", soft_wrap=True)
    show(rows, close, causes, console)
    console.print("CPU s: " + ", ".join(f"{step} {spent:.1f}" for step, spent in seconds.items()), soft_wrap=True)
    if chosen.json:
        settings = {
            name: getattr(chosen, name) for name in ("pairs", "pieces", "deform", "narrow", "set", "keep", "few")
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
            "found": [asdict(one) for one in found],
            "closeness": [asdict(one) for one in close],
            "cpu_s": seconds,
        }
        chosen.json.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    if chosen.draw:
        draw_worst(search, found, close, chosen.draw)
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
