"""Distributions of scores: counted in one pass over any number of values, and laid out as bars."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from pipeline.report.formats import THIN, count, number
from riot.types import FloatArray, IntArray

CELLS = 10_000
"""Resolution of a distribution over [0, 1]; quantiles are exact to one cell."""

BARS = 50
"""Bars of a histogram over [0, 1] (ours)."""

WIDTH, HEIGHT = 460, 170
"""Of the drawing, in its own units."""

LEFT, RIGHT, BELOW, ABOVE = 46, 14, 22, 8

MARKS = (("median", 0.5), (f"90{THIN}%", 0.9), (f"99{THIN}%", 0.99))
"""Quantiles that the summary names."""


@dataclass(frozen=True, eq=False)
class Distribution:
    """How often values of [0, 1] fell into each of `CELLS` equal cells (int64); the least and the greatest value."""

    cells: IntArray
    least: float
    greatest: float

    @property
    def total(self) -> int:
        """Number of values."""
        return int(self.cells.sum())

    def quantile(self, share: float) -> float:
        """The value below which ``share`` of all lie, to one cell's width; nan without values."""
        if not self.total:
            return float("nan")
        reached = np.searchsorted(np.cumsum(self.cells), share * self.total)
        middle = (min(int(reached), CELLS - 1) + 0.5) / CELLS
        return float(min(max(middle, self.least), self.greatest))


def distribution(chunks: Iterable[FloatArray]) -> Distribution:
    """Count arrays of scores, one after another; values that are not finite are left out."""
    cells = np.zeros(CELLS, dtype=np.int64)
    least, greatest = float("inf"), float("-inf")
    for chunk in chunks:
        values = np.asarray(chunk, dtype=np.float64)
        values = values[np.isfinite(values)]
        if not len(values):
            continue
        least, greatest = min(least, float(values.min())), max(greatest, float(values.max()))
        index = np.clip((values * CELLS).astype(np.int64), 0, CELLS - 1)
        cells += np.bincount(index, minlength=CELLS)
    return Distribution(cells, least, greatest)


@dataclass(frozen=True)
class Tick:
    """A horizontal line at ``y`` of the drawing, or a label at ``x``."""

    words: str
    x: float = 0.0
    y: float = 0.0


@dataclass(frozen=True)
class Bar:
    """A bar of the drawing: its upper left corner, its size, and how many values of which range it stands for."""

    x: float
    y: float
    width: float
    height: float
    words: str


@dataclass(frozen=True)
class Histogram:
    """A captioned histogram, laid out in a drawing of ``width`` by ``height``; without values it has no bars."""

    title: str
    total: int
    summary: str = ""
    logarithmic: bool = False
    bars: tuple[Bar, ...] = ()
    ticks: tuple[Tick, ...] = ()
    labels: tuple[Tick, ...] = ()
    width: int = WIDTH
    height: int = HEIGHT
    left: int = LEFT
    wide: int = WIDTH - LEFT - RIGHT


def histogram(values: Distribution, title: str, unit: str, logarithmic: bool = False) -> Histogram:
    """Lay out a distribution: ``title`` says of what, ``unit`` what is counted.

    ``logarithmic`` draws the decadic logarithm of the counts plus one, for a distribution whose tail is what matters.

    >>> [bar.words for bar in histogram(distribution([np.array([0.5, 0.51, 0.9])]), "IoU", "pairs").bars]
    ['0.50 to 0.52: 2 pairs', '0.90 to 0.92: 1 pairs']
    """
    if not values.total:
        return Histogram(title, 0)
    quantiles = ", ".join(f"{name} {number(values.quantile(share))}" for name, share in MARKS)
    summary = f"{count(values.total)} {unit}; {quantiles}, greatest {number(values.greatest)}"
    per_bar = values.cells.reshape(BARS, -1).sum(axis=1)
    tall = np.log10(per_bar + 1.0) if logarithmic else per_bar.astype(np.float64)
    ticks = _ticks(int(per_bar.max()), logarithmic)
    top = max(float(tall.max()), max(value for value, _ in ticks))
    wide, high = WIDTH - LEFT - RIGHT, HEIGHT - BELOW - ABOVE
    base = ABOVE + high
    bars = []
    for k in np.flatnonzero(per_bar).tolist():
        height = max(high * float(tall[k]) / top, 1.0)
        words = f"{k / BARS:.2f} to {(k + 1) / BARS:.2f}: {count(int(per_bar[k]))} {unit}"
        bars.append(Bar(LEFT + wide * k / BARS + 0.5, base - height, wide / BARS - 1, height, words))
    return Histogram(
        title,
        values.total,
        summary,
        logarithmic,
        tuple(bars),
        tuple(Tick(words, y=base - high * value / top) for value, words in ticks),
        tuple(Tick(f"{k / 5:.1f}", x=LEFT + wide * k / 5) for k in range(6)),
    )


def _ticks(most: int, logarithmic: bool) -> list[tuple[float, str]]:
    """Where the horizontal lines lie, in the scale of the bars, and what they say."""
    if logarithmic:
        decades = range(0, len(str(most)))
        return [(float(np.log10(10.0**k + 1.0)), count(10**k)) for k in decades]
    step = 10 ** (len(str(most)) - 1)
    if most / step < 2:
        step = max(step // 5, 1)
    elif most / step < 5:
        step = max(step // 2, 1)
    return [(float(value), count(value)) for value in range(0, most + 1, step)]
