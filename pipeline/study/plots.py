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
    found = figure.add_subplot()
    found.set_xlabel(x, color=LIGHT["ink"])
    found.set_ylabel(y, color=LIGHT["ink"])
    _bare(found)
    return figure, found


def histograms(values: Mapping[str, FloatArray], x: str, y: str, logarithmic: bool = False) -> Figure:
    """Histograms over [0, 1] of one or more sets of scores, as steps of different colours."""
    figure, found = axes(x, y)
    for number, (name, each) in enumerate(values.items()):
        known = each[np.isfinite(each)]
        found.hist(known, np.linspace(0.0, 1.0, BINS + 1), histtype="step", linewidth=1.6, label=name,
                   color=PIECES[number % len(PIECES)], log=logarithmic)  # fmt: skip
    if len(values) > 1:
        found.legend(frameon=False)
    return figure


def scatter(
    points: tuple[FloatArray, FloatArray], bands: Sequence[tuple[float, float, float, float]], x: str, y: str
) -> Figure:
    """Two scores of the same pairs, and the quartiles of the second by bins of the first."""
    figure, found = axes(x, y)
    found.plot(*points, ".", markersize=2.0, color=LIGHT["shade"], rasterized=True)
    at, low, middle, high = (np.array(each) for each in zip(*bands, strict=True))
    found.fill_between(at, low, high, color=PIECES[0], alpha=0.25, linewidth=0.0, label="quartiles")
    found.plot(at, middle, color=PIECES[0], linewidth=1.8, label="median")
    found.plot([0.0, 1.0], [0.0, 1.0], color=LIGHT["muted"], linewidth=0.8, linestyle=":")
    found.set_xlim(0.0, 1.0)
    found.set_ylim(0.0, 1.0)
    found.legend(frameon=False, loc="upper left")
    return figure


def boxes(groups: Mapping[str, FloatArray], x: str) -> Figure:
    """One box a group, of its quartiles, with whiskers from the least to the greatest, in the order given."""
    figure, found = axes(x, "", (SIZE[0], max(2.0, 0.17 * len(groups) + 0.8)))
    names, rows = list(groups), np.arange(1, len(groups) + 1)
    quartiles = np.array([np.nanquantile(groups[name], (0.0, 0.25, 0.5, 0.75, 1.0)) for name in names]).T
    found.hlines(rows, quartiles[0], quartiles[4], color=LIGHT["muted"], linewidth=0.8)
    found.barh(rows, quartiles[3] - quartiles[1], 0.6, quartiles[1], color=PIECES[0])
    found.plot(quartiles[2], rows, "|", color=LIGHT["ink"], markersize=5.0)
    found.set_yticks(range(1, len(names) + 1), [name or "(none)" for name in names], fontsize=6)
    found.set_ylim(len(names) + 0.7, 0.3)
    return figure


def along(shapes: Sequence[Shape], captions: Sequence[str]) -> Figure:
    """Shapes side by side, each filling its place, with a caption under each."""
    figure = Figure(figsize=(1.1 * len(shapes), 1.5), facecolor=LIGHT["paper"], layout="constrained")
    for place, (shape, caption) in enumerate(zip(shapes, captions, strict=True)):
        found = figure.add_subplot(1, len(shapes), place + 1)
        found.add_patch(Polygon(shape.points, closed=True, facecolor=PIECES[0], edgecolor="none"))
        reach = float(np.abs(shape.points).max())
        found.set_xlim(-reach, reach)
        found.set_ylim(-reach, reach)
        found.set_aspect("equal")
        found.set_axis_off()
        found.set_title(caption, fontsize=6, color=LIGHT["ink"], y=-0.25)
    return figure


def curves(points: Mapping[str, Sequence[tuple[float, float]]], x: str, y: str) -> Figure:
    """One line a name through its points, in the order given."""
    figure, found = axes(x, y)
    for number, (name, each) in enumerate(points.items()):
        found.plot(*zip(*each, strict=True), "o-", linewidth=1.8, label=name, color=PIECES[number % len(PIECES)])
    found.legend(frameon=False)
    return figure


def recall(ranks: Mapping[str, FloatArray], most: int) -> Figure:
    """The share of ranks that are at most r, by r from 1 to ``most``; nan ranks are never reached."""
    figure, found = axes("rank", "share of partners so far")
    at = np.arange(1, most + 1)
    for number, (name, each) in enumerate(ranks.items()):
        reached = np.array([float(np.mean(each <= rank)) for rank in at])
        found.step(at, reached, where="post", linewidth=1.8, label=name, color=PIECES[number % len(PIECES)])
    found.set_xscale("log")
    found.set_ylim(0.0, 1.02)
    found.legend(frameon=False, loc="lower right")
    return figure


def bars(names: Sequence[str], values: Mapping[str, Sequence[float]], x: str) -> Figure:
    """Groups of bars on a logarithmic axis; what is not there (nan) has none."""
    figure, found = axes(x, "", (SIZE[0], 0.5 * len(names) + 1.2))
    high = 0.8 / len(values)
    for number, (label, each) in enumerate(values.items()):
        found.barh([place + number * high for place in range(len(names))], each, high, label=label,
                   color=PIECES[number % len(PIECES)])  # fmt: skip
    found.set_yticks([place + 0.4 - high / 2 for place in range(len(names))], names)
    found.invert_yaxis()
    found.set_xscale("log")
    found.legend(frameon=False)
    return figure


def _bare(found: Any) -> None:
    for side in ("top", "right"):
        found.spines[side].set_visible(False)
    found.tick_params(colors=LIGHT["muted"], labelsize=8)
