"""What one way of finding partners costs on one collection, and the plot of such costs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure

MARKS = "osD^v"


@dataclass(frozen=True)
class Cost:
    """What one way of finding partners costs on one collection.

    ``estimated``: only ``pairs_scored`` of the pairs ran, and the seconds are those of all, in proportion. Of
    ``cpu_s``, ``prepare_cpu_s`` went into reading stacks of trunks and laying them out.
    """

    way: str
    shapes: int
    pairs: int
    pairs_scored: int
    wall_s: float
    cpu_s: float
    prepare_cpu_s: float
    estimated: bool

    @property
    def ms_per_pair(self) -> float:
        """CPU milliseconds, without preparing, for each pair of the collection, whether it had to be scored or not."""
        return 1e3 * (self.cpu_s - self.prepare_cpu_s) / self.pairs if self.pairs else float("nan")


def draw(costs: Sequence[Cost], path: Path) -> None:
    """CPU seconds against the number of shapes, both logarithmic; hollow marks are estimates."""
    matplotlib.rcParams["svg.hashsalt"] = "growth"
    figure = Figure(figsize=(6.4, 4.4), layout="constrained")
    axes = figure.subplots()
    for mark, way in zip(MARKS, dict.fromkeys(cost.way for cost in costs), strict=False):
        of = [cost for cost in costs if cost.way == way]
        shapes, seconds = [cost.shapes for cost in of], [cost.cpu_s - cost.prepare_cpu_s for cost in of]
        estimated = any(cost.estimated for cost in of)
        label = f"QCRS, {way}" + (", estimated" if estimated else "")
        axes.loglog(shapes, seconds, f"{mark}-", label=label, markerfacecolor="white" if estimated else None)
        power = 2 if way == "all pairs" else 1
        if len(of) > 1 and power == 2:
            span = np.array([shapes[0], shapes[-1]], dtype=np.float64)
            axes.loglog(span, seconds[0] * (span / span[0]) ** 2, "--", color="0.5", label="in proportion to N²")
    sizes = sorted({cost.shapes for cost in costs})
    axes.set_xticks(sizes, [f"{size:,}" for size in sizes])
    axes.minorticks_off()
    axes.set_xlabel("shapes in the collection, N")
    axes.set_ylabel("CPU time of scoring, seconds")
    axes.grid(visible=True, color="0.9")
    axes.legend(frameon=False)
    figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None, dpi=120)
