"""Plots of studies, in the colours of all other pictures, through matplotlib's object interface. Ours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from riot.draw.palette import LIGHT, PIECES
from riot.geometry.shape import Shape
from riot.types import FloatArray

SIZE = (6.4, 4.0)
"""Inches of a plot."""

BINS = 40


def axes(x: str, y: str, size: tuple[float, float] = SIZE) -> tuple[Figure, Any]:
    """A figure with one pair of axes, named."""
    figure = Figure(figsize=size, facecolor=LIGHT["paper"], layout="constrained")
    plot = figure.add_subplot()
    plot.set_xlabel(x, color=LIGHT["ink"])
    plot.set_ylabel(y, color=LIGHT["ink"])
    _bare(plot)
    return figure, plot


def histograms(values: Mapping[str, FloatArray], x: str, y: str, logarithmic: bool = False) -> Figure:
    """Histograms over [0, 1] of one or more sets of scores, as steps of different colours."""
    figure, plot = axes(x, y)
    for number, (name, scores) in enumerate(values.items()):
        known = scores[np.isfinite(scores)]
        plot.hist(known, np.linspace(0.0, 1.0, BINS + 1), histtype="step", linewidth=1.6, label=name,
                   color=PIECES[number % len(PIECES)], log=logarithmic)  # fmt: skip
    if len(values) > 1:
        plot.legend(frameon=False)
    return figure


def scatter(
    points: tuple[FloatArray, FloatArray], bands: Sequence[tuple[float, float, float, float]], x: str, y: str
) -> Figure:
    """Two scores of the same pairs, and the quartiles of the second by bins of the first."""
    figure, plot = axes(x, y)
    plot.plot(*points, ".", markersize=2.0, color=LIGHT["shade"], rasterized=True)
    middles, low, middle, high = (np.array(band_values) for band_values in zip(*bands, strict=True))
    plot.fill_between(middles, low, high, color=PIECES[0], alpha=0.25, linewidth=0.0, label="quartiles")
    plot.plot(middles, middle, color=PIECES[0], linewidth=1.8, label="median")
    plot.plot([0.0, 1.0], [0.0, 1.0], color=LIGHT["muted"], linewidth=0.8, linestyle=":")
    plot.set_xlim(0.0, 1.0)
    plot.set_ylim(0.0, 1.0)
    plot.legend(frameon=False, loc="upper left")
    return figure


def boxes(groups: Mapping[str, FloatArray], x: str) -> Figure:
    """One box a group, of its quartiles, with whiskers from the least to the greatest, in the order given."""
    figure, plot = axes(x, "", (SIZE[0], max(2.0, 0.17 * len(groups) + 0.8)))
    names, rows = list(groups), np.arange(1, len(groups) + 1)
    quartiles = np.array([np.nanquantile(groups[name], (0.0, 0.25, 0.5, 0.75, 1.0)) for name in names]).T
    plot.hlines(rows, quartiles[0], quartiles[4], color=LIGHT["muted"], linewidth=0.8)
    plot.barh(rows, quartiles[3] - quartiles[1], 0.6, quartiles[1], color=PIECES[0])
    plot.plot(quartiles[2], rows, "|", color=LIGHT["ink"], markersize=5.0)
    plot.set_yticks(range(1, len(names) + 1), [name or "(none)" for name in names], fontsize=6)
    plot.set_ylim(len(names) + 0.7, 0.3)
    return figure


def along(shapes: Sequence[Shape], captions: Sequence[str]) -> Figure:
    """Shapes side by side, each filling its place, with a caption under each."""
    figure = Figure(figsize=(1.1 * len(shapes), 1.5), facecolor=LIGHT["paper"], layout="constrained")
    for number, (shape, caption) in enumerate(zip(shapes, captions, strict=True)):
        plot = figure.add_subplot(1, len(shapes), number + 1)
        plot.add_patch(Polygon(shape.points, closed=True, facecolor=PIECES[0], edgecolor="none"))
        reach = float(np.abs(shape.points).max())
        plot.set_xlim(-reach, reach)
        plot.set_ylim(-reach, reach)
        plot.set_aspect("equal")
        plot.set_axis_off()
        plot.set_title(caption, fontsize=6, color=LIGHT["ink"], y=-0.25)
    return figure


def curves(points: Mapping[str, Sequence[tuple[float, float]]], x: str, y: str) -> Figure:
    """One line a name through its points, in the order given."""
    figure, plot = axes(x, y)
    for number, (name, line) in enumerate(points.items()):
        plot.plot(*zip(*line, strict=True), "o-", linewidth=1.8, label=name, color=PIECES[number % len(PIECES)])
    plot.legend(frameon=False)
    return figure


def recall(ranks: Mapping[str, FloatArray], most: int) -> Figure:
    """The share of ranks that are at most r, by r from 1 to ``most``; nan ranks are never reached."""
    figure, plot = axes("rank", "share of partners so far")
    depths = np.arange(1, most + 1)
    for number, (name, shape_ranks) in enumerate(ranks.items()):
        reached = np.array([float(np.mean(shape_ranks <= rank)) for rank in depths])
        plot.step(depths, reached, where="post", linewidth=1.8, label=name, color=PIECES[number % len(PIECES)])
    plot.set_xscale("log")
    plot.set_ylim(0.0, 1.02)
    plot.legend(frameon=False, loc="lower right")
    return figure


def bars(names: Sequence[str], values: Mapping[str, Sequence[float]], x: str) -> Figure:
    """Groups of bars on a logarithmic axis; what is not there (nan) has none."""
    figure, plot = axes(x, "", (SIZE[0], 0.5 * len(names) + 1.2))
    high = 0.8 / len(values)
    for number, (label, lengths) in enumerate(values.items()):
        plot.barh([row + number * high for row in range(len(names))], lengths, high, label=label,
                   color=PIECES[number % len(PIECES)])  # fmt: skip
    plot.set_yticks([row + 0.4 - high / 2 for row in range(len(names))], names)
    plot.invert_yaxis()
    plot.set_xscale("log")
    plot.legend(frameon=False)
    return figure


def _bare(plot: Any) -> None:
    for side in ("top", "right"):
        plot.spines[side].set_visible(False)
    plot.tick_params(colors=LIGHT["muted"], labelsize=8)
