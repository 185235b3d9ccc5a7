"""What the modes of QCRS cost on one collection, how many of the best partners are found, and the plot of both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib
from matplotlib.figure import Figure


@dataclass(frozen=True)
class Growth:
    """CPU milliseconds of one of ``shapes`` shapes, of which ``asked`` looked for partners.

    ``index_ms`` is the part of both searches that the index takes; ``recall`` the mean share of the best partners that
    the approximate mode finds, ``least_recall`` the least of a shape, ``low_scores`` the share of those found that
    score too low.
    """

    shapes: int
    asked: int
    all_ms: float
    index_ms: float
    exact_ms: float
    approximate_ms: float
    recall: float
    least_recall: float
    low_scores: float
    peak_mb: float

    @property
    def exact(self) -> float:
        """The exact search, of all pairs."""
        return (self.index_ms + self.exact_ms) / self.all_ms

    @property
    def approximate(self) -> float:
        """The approximate search, of all pairs."""
        return (self.index_ms + self.approximate_ms) / self.all_ms

    @property
    def sentence(self) -> str:
        """All of it in a line."""
        return (
            f"{self.shapes:>6} shapes, {self.asked} asked: all {self.all_ms:8.1f} ms a shape, "
            f"index {self.index_ms:.2f}, topk {self.exact_ms:7.2f} ({self.exact:.3f} of all), "
            f"approximate {self.approximate_ms:6.2f} ({self.approximate:.3f}), "
            f"recall {self.recall:.4f}, least {self.least_recall:.2f}, too low {self.low_scores:.4f}, "
            f"{self.peak_mb:.0f} MB"
        )


def draw(table: Sequence[Growth], path: Path) -> None:
    """Costs against the number of shapes, both logarithmic, and the recall below."""
    matplotlib.rcParams["svg.hashsalt"] = "recall"
    figure = Figure(figsize=(6.4, 5.6), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[3, 1])
    shapes = [row.shapes for row in table]
    for mark, label, cost in (
        ("o", "all, by a sample of pairs", [row.all_ms for row in table]),
        ("s", "topk", [row.index_ms + row.exact_ms for row in table]),
        ("D", "approximate", [row.index_ms + row.approximate_ms for row in table]),
    ):
        above.loglog(shapes, cost, f"{mark}-", label=label)
    above.set_ylabel("CPU time of one shape, ms")
    above.legend(frameon=False)
    below.semilogx(shapes, [row.recall for row in table], "D-", color="C2")
    below.axhline(0.99, color="0.5", linestyle="--")
    below.set_ylim(min(0.98, *(row.recall for row in table)) - 0.005, 1.002)
    below.set_ylabel("recall")
    below.set_xticks(shapes, [f"{size:,}" for size in shapes])
    below.minorticks_off()
    below.set_xlabel("shapes in the collection, N")
    for axes in (above, below):
        axes.grid(visible=True, color="0.9")
    figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None, dpi=120)
