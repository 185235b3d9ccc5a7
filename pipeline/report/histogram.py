"""Distributions of scores: counted in one pass over any number of values, drawn as SVG bars."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from pipeline.report.markup import count, number
from riot.draw.svg import escape
from riot.types import FloatArray, IntArray

CELLS = 10_000
"""Resolution of a distribution over [0, 1]; quantiles are exact to one cell."""

BARS = 50

WIDTH, HEIGHT = 460, 170
"""Of the drawing, in its own units."""

LEFT, RIGHT, BELOW, ABOVE = 46, 14, 22, 8


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


def figure(found: Distribution, title: str, unit: str, logarithmic: bool = False) -> str:
    """A captioned histogram: ``title`` says of what, ``unit`` what is counted (both text).

    ``logarithmic`` draws the decadic logarithm of the counts plus one, for a distribution whose tail is what matters.
    """
    if not found.total:
        return f'<figure class="plot"><figcaption><b>{escape(title)}</b> no values</figcaption></figure>'
    marks = (("median", 0.5), ("90\N{NARROW NO-BREAK SPACE}%", 0.9), ("99\N{NARROW NO-BREAK SPACE}%", 0.99))
    quantiles = ", ".join(f"{name} {number(found.quantile(share))}" for name, share in marks)
    summary = f"{count(found.total)} {unit}; {quantiles}, greatest {number(found.greatest)}"
    scale = " (logarithmic)" if logarithmic else ""
    return (
        f'<figure class="plot"><svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img">'
        f"<title>{escape(f'Histogram of {title}: {summary}')}</title>{_bars(found, unit, logarithmic)}</svg>"
        f"<figcaption><b>{escape(title)}</b> {escape(summary)}{scale}</figcaption></figure>"
    )


def _bars(found: Distribution, unit: str, logarithmic: bool) -> str:
    per_bar = found.cells.reshape(BARS, -1).sum(axis=1)
    tall = np.log10(per_bar + 1.0) if logarithmic else per_bar.astype(np.float64)
    ticks = _ticks(int(per_bar.max()), logarithmic)
    top = max(float(tall.max()), max(where for where, _ in ticks))
    wide, high = WIDTH - LEFT - RIGHT, HEIGHT - BELOW - ABOVE
    base = ABOVE + high
    parts = []
    for where, name in ticks:
        y = base - high * where / top
        parts.append(f'<path class="grid" d="M{LEFT} {y:.1f}h{wide}"/>')
        parts.append(f'<text x="{LEFT - 6}" y="{y + 3.5:.1f}" text-anchor="end">{name}</text>')
    for k in range(BARS):
        if not per_bar[k]:
            continue
        x, height = LEFT + wide * k / BARS, max(high * tall[k] / top, 1.0)
        said = f"{k / BARS:.2f} to {(k + 1) / BARS:.2f}: {count(int(per_bar[k]))} {unit}"
        parts.append(
            f'<rect class="bar" x="{x + 0.5:.1f}" y="{base - height:.1f}" width="{wide / BARS - 1:.1f}" '
            f'height="{height:.1f}"><title>{escape(said)}</title></rect>'
        )
    for k in range(6):
        x = LEFT + wide * k / 5
        parts.append(f'<text x="{x:.1f}" y="{HEIGHT - 5}" text-anchor="middle">{k / 5:.1f}</text>')
    return "".join(parts)


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
