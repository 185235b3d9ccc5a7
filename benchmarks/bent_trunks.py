"""Whether trunks that bend, or are not convex, would let exact constructions come closer to their inputs.

    python benchmarks/bent_trunks.py --transforms DIR --pairs 40

A trunk edge only parts a piece into what it owns of P and of Q: any line from hinge to hinge within the piece would do,
and the hinges need not be corners of a convex polygon. From the refined trunks of a run's transforms on, the bound of
the worse shape's IoU is raised by one and the same derivative-free search (Powell) in four ways: convex trunks with
straight edges, as the library has them (the control: what more searching alone gains); straight, but not necessarily
convex; with edges of one bend; of two bends, both not necessarily convex. A bend is a point over the even divisions of
the edge, moved off it; its piece owns it, so that it bulges out of T as far as it goes into T̄.
"""

from __future__ import annotations

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)

# ruff: isort: split
import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numba
import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table
from scipy.optimize import minimize

from riot.construction.conjugate import is_convex
from riot.construction.given_trunks import given_pair
from riot.construction.plan import ConstructionPlan, TrunkPair, plan_on
from riot.construction.tuning import EDGE_TOLERANCE
from riot.errors import RiotError
from riot.geometry.polyline import is_simple
from riot.kernels.change import placed_arcs
from riot.kernels.conjugate import conjugated
from riot.parameters import RefineParameters
from riot.transform.riot_file import load
from riot.transform.transform import Transform
from riot.types import FloatArray, IntArray

FORMAT = 1
"""Version of the JSON."""

REFINEMENT = RefineParameters()
LINES = 256
MOVE, BEND = 0.02, 0.02
"""First steps of the search: of corners and of bends."""
EVALUATIONS = 1500
WIDTH = 150


@dataclass(frozen=True)
class Way:
    """Bends an edge, and whether trunks stay convex."""

    bends: int
    convex: bool


WAYS = {
    "straight, convex": Way(0, True),
    "straight": Way(0, False),
    "one bend": Way(1, False),
    "two bends": Way(2, False),
}


@dataclass(frozen=True)
class Bent:
    """The bound of one pair: of the run's trunks, and after the search in every way."""

    p: str
    q: str
    n: int
    start: float
    bounds: dict[str, float]


@numba.njit(cache=False, nogil=True, error_model="numpy")  # type: ignore[untyped-decorator]
def changes(regions: FloatArray, offsets: IntArray, target: FloatArray, lines: int) -> tuple[float, float]:
    """Areas lost and added (theory §8) where closed regions, ragged (s, 2), are to tile a polygon ``target`` (t, 2)."""
    count, total = len(offsets) - 1, len(regions)
    low = min(regions[:, 1].min(), target[:, 1].min())
    step = (max(regions[:, 1].max(), target[:, 1].max()) - low) / lines
    x, owner, turn = (
        np.empty(total + len(target)),
        np.empty(total + len(target), np.int64),
        np.empty(total + len(target)),
    )
    lost, added = 0.0, 0.0
    for line in range(lines):
        y, crossings = low + (line + 0.5) * step, 0
        for i in range(count + 1):
            polygon = target if i == count else regions[offsets[i] : offsets[i + 1]]
            for k in range(len(polygon)):
                a, b = polygon[k - 1], polygon[k]
                if (a[1] <= y) != (b[1] <= y):
                    x[crossings] = a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1])
                    owner[crossings], turn[crossings] = i, -1 if b[1] > a[1] else 1
                    crossings += 1
        winding = np.zeros(count + 1)
        order = np.argsort(x[:crossings])
        for k in range(crossings - 1):
            at = order[k]
            winding[owner[at]] += turn[at]
            width = x[order[k + 1]] - x[at]
            whole, apart, lacking = 0.0, 0.0, 0.0
            for i in range(count):
                whole += winding[i]
                apart += max(winding[i], 0.0)
                lacking += max(-winding[i], 0.0)
            if winding[count] != 0.0:
                lost += width * max(whole - 1.0, 0.0)
                added += width * max(1.0 - whole, 0.0)
            else:
                lost += width * apart
                added += width * lacking
    return lost * step, added * step


def bound(pair: TrunkPair, trunks: FloatArray, bends: FloatArray) -> float:
    """The worse shape's bound on conjugate ``trunks`` (2, n, 2) whose edges have ``bends`` (n, b), heights above them.

    −1 where a bent trunk crosses itself.
    """
    p, windows_p, q, windows_q = pair.windowed_outlines
    bounds = []
    for points, windows, side in ((p, windows_p, 0), (q, windows_q, 1)):
        source, target = trunks[side], trunks[1 - side]
        # Above an edge is where the upper part is: to the left of it in T and in T̄, both in corresponding order.
        backs = _bent(target, bends)
        outline = np.concatenate(backs)
        if not is_simple(outline):
            return -1.0
        if side == 1:
            source, target, backs = source[::-1].copy(), target[::-1].copy(), [back[::-1] for back in backs]
        n = len(source)
        arcs, offsets = np.empty((len(points) + 5 * n, 2)), np.empty(n + 1, dtype=np.int64)
        placed_arcs(points, windows, source.copy(), target.copy(), arcs, offsets)
        regions = []
        for i in range(n):
            # The way back along edge i of the target; read backwards, its corners i and i + 1 are n − 1 − i and before.
            if side == 0:
                back = np.concatenate([backs[i], target[(i + 1) % n][None]])
            else:
                back = np.concatenate([target[i][None], backs[(n - 2 - i) % n]])
            regions.append(np.concatenate([arcs[offsets[i] : offsets[i + 1]], back[::-1][1:-1]]))
        starts = np.concatenate([[0], np.cumsum([len(region) for region in regions])])
        lost, added = changes(np.concatenate(regions), starts, outline, LINES)
        bounds.append((1.0 - lost) / (1.0 + added))
    return float(min(bounds))


def _bent(trunk: FloatArray, bends: FloatArray) -> list[FloatArray]:
    """(1 + b, 2) for every edge: its first corner and its bends."""
    edges = np.roll(trunk, -1, axis=0) - trunk
    up = np.stack([-edges[:, 1], edges[:, 0]], axis=1) / np.hypot(*edges.T)[:, None]
    count = bends.shape[1]
    parts = []
    for i in range(len(trunk)):
        share = (np.arange(count)[:, None] + 1.0) / (count + 1.0)
        parts.append(np.concatenate([trunk[i][None], trunk[i] + share * edges[i] + bends[i][:, None] * up[i]]))
    return parts


def search(plan: ConstructionPlan, way: Way) -> float:
    """The highest bound that is found from a plan's trunks on."""
    n = plan.trunks.shape[1]
    scale = np.concatenate([np.full(4 * n, MOVE), np.full(n * way.bends, BEND)])

    def cost(x: FloatArray, /) -> float:
        moved = x * scale
        trunks, worst = conjugated(plan.trunks + moved[: 4 * n].reshape(2, n, 2), EDGE_TOLERANCE, 50)
        if not worst <= 100.0 * EDGE_TOLERANCE or np.abs(trunks - plan.trunks).max() > REFINEMENT.slide:
            return 1.0
        if way.convex and not (is_convex(trunks[0]) and is_convex(trunks[1, ::-1])):
            return 1.0
        return -bound(plan.pair, trunks, moved[4 * n :].reshape(n, way.bends))

    start = np.zeros(len(scale))
    least = minimize(cost, start, method="Powell", options={"maxfev": EVALUATIONS, "xtol": 0.01, "ftol": 1e-5})
    return max(-float(least.fun), -cost(start))


def plan_of(transform: Transform) -> ConstructionPlan:
    """The plan that a transform was constructed on."""
    pair = given_pair(transform.p, transform.q, transform.trunk_p, transform.trunk_q, 1.0, REFINEMENT.reach)
    origin = np.zeros((1, 2))
    trunks = [
        [pose.place(i, origin)[0] for i in range(len(transform))] for pose in (transform.pose(0.0), transform.pose(1.0))
    ]
    return plan_on(pair, np.array(trunks), REFINEMENT.bound_lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Search, print the table, write JSON if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--transforms", type=Path, required=True, help="a folder of .riot files")
    parser.add_argument("--pairs", type=int, default=40, help="so many of them, evenly chosen")
    parser.add_argument("--json", type=Path, help="write the figures to this file too")
    chosen = parser.parse_args(arguments)
    paths = sorted(chosen.transforms.rglob("*.riot"))
    if not paths:
        parser.error(f"no .riot file under {chosen.transforms}")
    picked = [paths[k] for k in np.unique(np.linspace(0, len(paths) - 1, chosen.pairs).round().astype(int))]
    pairs = []
    for path in picked:
        try:
            plan = plan_of(load(path))
        except RiotError as error:
            print(f"{path.name}: {error}", file=sys.stderr)
            continue
        start = bound(plan.pair, plan.trunks, np.zeros((plan.trunks.shape[1], 0)))
        bounds = {name: search(plan, way) for name, way in WAYS.items()}
        pairs.append(Bent(plan.pair.p.name, plan.pair.q.name, plan.trunks.shape[1], start, bounds))
        print(
            f"{path.stem}: {start:.4f}, " + ", ".join(f"{b:.4f}" for b in bounds.values()), file=sys.stderr, flush=True
        )
    show(pairs)
    if chosen.json:
        document = {"format": FORMAT, "pairs": [asdict(pair) for pair in pairs]}
        chosen.json.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return 0


def show(pairs: Sequence[Bent]) -> None:
    """Print quantiles of the bound, and of the gain on the control."""
    table = Table(f"{len(pairs)} pairs", box=box.SIMPLE_HEAD, pad_edge=False)
    for name in ("bound: least", "median", "greatest", "gain on the control: median", "90 %", "greatest"):
        table.add_column(name, justify="right")
    rows = {"the run's": np.array([pair.start for pair in pairs])}
    rows |= {name: np.array([pair.bounds[name] for pair in pairs]) for name in WAYS}
    control = rows["straight, convex"]
    for name, values in rows.items():
        gains = np.quantile(values - control, (0.5, 0.9, 1.0))
        cells = [*np.quantile(values, (0.0, 0.5, 1.0)), *gains]
        table.add_row(name, *(f"{value:+.5f}" if k > 2 else f"{value:.5f}" for k, value in enumerate(cells)))
    Console(highlight=False, width=WIDTH).print(table)


if __name__ == "__main__":
    sys.exit(main())
