"""The pages for reference: both shapes, the chain and the swing; then parts, steps, warnings and sizes. Ours."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import shapely

from riot.draw.palette import hue
from riot.draw.scene import Mark, Scene
from riot.fabricate.export.instructions import (
    end_in_words,
    magnet_size,
    pins_in_words,
    shape_names,
    sizes,
    steps,
    warnings,
)
from riot.fabricate.export.paper import region_mark, sheet, text
from riot.fabricate.export.poses import chain, closed, drawn, fit, frames_of, ratio, size_of

if TYPE_CHECKING:
    from riot.fabricate.model import Design

WIDTH, HEIGHT = 210.0, 297.0
"""A4, mm."""

PAGE_MARGIN_MM = 15.0
ROWS, COLUMNS = 2, 4
"""Of the poses of the swing."""

_SHAPES_MM = 84.0
_CHAIN_MM = 46.0
"""Greatest heights of the pictures; the swing takes what they leave."""

_APART_MM = 4.0

_LETTERS = 104
"""Of a line of text."""


def page_scenes(design: Design) -> list[Scene]:
    """The pages, in mm: pictures, and lists."""
    return [sheet("assembly", WIDTH, HEIGHT, marks) for marks in (_pictures(design), *_lists(design))]


def _pictures(design: Design) -> list[Mark]:
    """The first page."""
    names = shape_names(design)
    width, top = WIDTH - 2 * PAGE_MARGIN_MM, HEIGHT - PAGE_MARGIN_MM
    summary = f"{len(design.pieces)} pieces, {pins_in_words(design)}; the chain {design.motion.words}"
    marks: list[Mark] = [
        text(PAGE_MARGIN_MM, top - 5.0, f"{names[0]} ⇄ {names[1]}", 6.5, weight="bold"),
        text(PAGE_MARGIN_MM, top - 11.5, summary, 3.2, "note"),
    ]
    top -= 20.0

    half = 0.5 * (width - 10.0)
    shut = [closed(design, t) for t in (0.0, 1.0)]
    scale = min(fit(frames, design, half, _SHAPES_MM) for frames in shut)
    high = max(size_of(frames, design)[1] for frames in shut) * scale
    for k, (frames, name) in enumerate(zip(shut, names, strict=True)):
        middle = PAGE_MARGIN_MM + 0.5 * half + k * (half + 10.0)
        marks += drawn(design, frames, scale, middle, top - 0.5 * high, numbers=True)
        marks.append(text(middle, top - high - 7.0, name, 3.6, anchor="middle", weight="bold"))
    marks.append(text(0.5 * WIDTH, top - high - 7.0, ratio(scale), 2.8, "note", "middle"))
    top -= high + 17.0

    laid = chain(design)
    scale = fit(laid, design, width, _CHAIN_MM)
    high = size_of(laid, design)[1] * scale
    marks += drawn(design, laid, scale, 0.5 * WIDTH, top - 0.5 * high, numbers=True, hinges=True)
    words = f"the chain, seen from the front: {names[0]}'s outline below, {names[1]}'s above"
    marks.append(text(0.5 * WIDTH, top - high - 7.0, words, 2.8, "note", "middle"))
    joint = "pin hinge" if design.placement is None else "hinge printed in place"
    kinds = f"● {joint}   ○ open ends" + ("   ◎ telescopic hinge" if design.motion.lifted else "")
    marks.append(text(0.5 * WIDTH, top - high - 11.5, kinds, 2.8, "note", "middle"))
    top -= high + 21.0

    return marks + _swing(design, top)


def _swing(design: Design, top: float) -> list[Mark]:
    """Poses of the motion in rows, all at one scale."""
    names, width = shape_names(design), WIDTH - 2 * PAGE_MARGIN_MM
    times = np.linspace(0.0, 1.0, ROWS * COLUMNS)
    groups = [frames_of(design, design.motion.pose_at(float(t))) for t in times]
    sizes = np.array([size_of(frames, design) for frames in groups]).reshape(ROWS, COLUMNS, 2)
    wide, high = sizes[..., 0].sum(axis=1), sizes[..., 1].max(axis=1)
    marks: list[Mark] = []
    height_left = top - PAGE_MARGIN_MM - ROWS * _APART_MM - 4.0
    scale = min((width - _APART_MM * (COLUMNS - 1)) / float(wide.max()), height_left / float(high.sum()), 1.0)
    for row in range(ROWS):
        x, space = PAGE_MARGIN_MM, (width - scale * float(wide[row])) / (COLUMNS - 1)
        tall = scale * float(high[row])
        for column in range(COLUMNS):
            own = scale * float(sizes[row, column, 0])
            frames = groups[row * COLUMNS + column]
            marks += drawn(design, frames, scale, x + 0.5 * own, top - 0.5 * tall, hinges=True)
            x += own + space
        top -= tall + _APART_MM
    marks.append(text(0.5 * WIDTH, top - 3.0, f"the swing from {names[0]} to {names[1]}", 2.8, "note", "middle"))
    return marks


def _lists(design: Design) -> list[list[Mark]]:
    """The pages after the first: parts, pins, steps, warnings; as many as there need to be."""
    lines: list[tuple[str, str]] = [("head", "Parts")]
    for piece in design.pieces:
        x0, y0, x1, y1 = piece.footprint.bounds  # with its knuckles
        wide, high = x1 - x0, y1 - y0
        ends = f"{end_in_words(design, piece.start)}, then {end_in_words(design, piece.end)}"
        lines.append(("row", f"{piece.index + 1}\t1 × {piece.name}\t{wide:.0f} × {high:.0f} mm\t{ends}"))
    if design.placement is not None:
        box = f"{design.placement.width:.0f} × {design.placement.depth:.0f} mm"
        lines.append(("row", f"\t1 × chain\t{box}\tall pieces in one print: nothing to insert, turn it free"))
    lines += [("row", f"\t{pin.count} × pin\t⌀ {pin.diameter:g} × {pin.length:g} mm\t") for pin in design.pins]
    if design.sleeves:
        lines.append(("row", f"\t{design.sleeves} × sleeve\t\tof telescopic hinges"))
    if count := sum(len(piece.pockets) for piece in design.pieces):
        lines.append(("row", f"\t{count} × magnet\t{magnet_size(design)}\tdiscs, in the walls of the free ends"))
    lines += [("gap", ""), ("head", "Steps"), *_numbered(steps(design))]
    lines += [("gap", ""), ("head", "Warnings"), *(_numbered(warnings(design)) or [("text", "none")])]
    lines += [("gap", ""), ("head", "Sizes"), *(("text", line) for line in sizes(design))]

    pages: list[list[Mark]] = [[]]
    y = HEIGHT - PAGE_MARGIN_MM
    for kind, words in lines:
        step = {"head": 9.0, "gap": 3.0}.get(kind, 5.4)
        if y - step < PAGE_MARGIN_MM:
            pages.append([])
            y = HEIGHT - PAGE_MARGIN_MM
        y -= step
        if kind == "head":
            pages[-1].append(text(PAGE_MARGIN_MM, y, words, 4.4, weight="bold"))
            y -= 1.2
        elif kind == "row":
            pages[-1] += _row(design, y, words.split("\t"))
        elif kind == "text":
            pages[-1].append(text(PAGE_MARGIN_MM, y, words, 3.1))
    return pages


def _row(design: Design, y: float, cells: Sequence[str]) -> list[Mark]:
    marks: list[Mark] = []
    if cells[0]:
        swatch = shapely.box(PAGE_MARGIN_MM, y - 0.8, PAGE_MARGIN_MM + 4.0, y + 2.8)
        marks.append(region_mark(swatch, f"piece{hue(int(cells[0]) - 1, len(design.pieces))}"))
    marks += [text(PAGE_MARGIN_MM + x, y, words, 3.1) for x, words in zip((7.0, 14.0, 44.0, 76.0), cells, strict=True)]
    return marks


def _numbered(texts: Sequence[str]) -> list[tuple[str, str]]:
    lines = []
    for number, words in enumerate(texts, start=1):
        first, *more = textwrap.wrap(words, _LETTERS)
        lines += [("text", f"{number}.  {first}"), *(("text", f"     {line}") for line in more)]
    return lines
