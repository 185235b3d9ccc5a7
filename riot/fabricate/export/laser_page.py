"""The page for the laser: the sheets, what each colour means, and how cut parts become a puzzle. Ours."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np
import shapely

from riot.draw.palette import LASER_COLOURS
from riot.draw.scene import Line, Mark, Region, Scene
from riot.fabricate.export.flat import laser_kinds, laser_notes
from riot.fabricate.export.flat_parts import flat_parts, sheets_of_a_layer, stack_mm
from riot.fabricate.export.laser_sheet import LaserSheet, laser_sheets
from riot.fabricate.export.page import HEIGHT, PAGE_MARGIN_MM, WIDTH
from riot.fabricate.export.paper import region_mark, rings, sheet, text

if TYPE_CHECKING:
    from riot.fabricate.model import Design

TASKS = {"engrave": "fill: numbers and arrows", "score": "a line on the surface", "cut": "through, holes first"}
MOST_SHEETS = 4
"""Sheets that are shown; the others look like them."""

_LETTERS = 100
MOST_MM = 110.0
"""Greatest height of their pictures."""


def laser_page(design: Design) -> Scene:
    """One page: layers and colours, sheets, and steps for either way of joining the pieces."""
    kind = laser_kinds(design)[-2]  # layers where they can be made, else outlines; strips come last
    sheets = laser_sheets(flat_parts(design, kind), design.parameters)
    top = HEIGHT - PAGE_MARGIN_MM - 5.0
    marks: list[Mark] = [text(PAGE_MARGIN_MM, top, "Cut it with a laser", 6.0, weight="bold")]
    top -= 9.0
    for number, (layer, colour) in enumerate(LASER_COLOURS.items()):
        words = f"{layer}: {TASKS[layer]} · {colour}, layer {number:02d} of LightBurn"
        if layer == "engrave":
            swatch = shapely.box(PAGE_MARGIN_MM, top - 0.8, PAGE_MARGIN_MM + 6.0, top + 1.6)
            marks.append(region_mark(swatch, "laser-engrave"))
        else:
            stroke = np.array([[PAGE_MARGIN_MM, top + 0.4], [PAGE_MARGIN_MM + 6.0, top + 0.4]])
            marks.append(Line(stroke, f"laser-{layer}"))
        marks.append(text(PAGE_MARGIN_MM + 9.0, top - 0.8, words, 3.2))
        top -= 5.6
    top -= 3.0
    shown = sheets[:MOST_SHEETS]
    room = (WIDTH - 2 * PAGE_MARGIN_MM - 6.0 * (len(shown) - 1)) / len(shown)
    scale = min(room / sheets[0].width, MOST_MM / sheets[0].height)
    for k, laser_sheet in enumerate(shown):
        marks += _picture(laser_sheet, PAGE_MARGIN_MM + k * (scale * laser_sheet.width + 6.0), top, scale)
    top -= scale * sheets[0].height + 5.0
    caption = f"laser-{kind}: {len(sheets)} sheet{'s' if len(sheets) > 1 else ''} of {design.parameters.sheet_mm:g} mm"
    marks.append(text(PAGE_MARGIN_MM, top, caption, 3.0, "note"))
    top -= 9.0
    for heading, sentences in _sections(design):
        marks.append(text(PAGE_MARGIN_MM, top, heading, 4.4, weight="bold"))
        top -= 6.4
        for number, sentence in enumerate(sentences, start=1):
            for k, line in enumerate(textwrap.wrap(sentence, _LETTERS)):
                marks.append(text(PAGE_MARGIN_MM, top, f"{number}.  {line}" if k == 0 else f"     {line}", 3.1))
                top -= 4.8
        top -= 3.0
    return sheet("laser", WIDTH, HEIGHT, marks)


def _sections(design: Design) -> list[tuple[str, list[str]]]:
    parameters = design.parameters
    first = [
        "Cut laser-coupon first. Push its lamellas together: the space that is left, divided by the number on it, is "
        "the kerf. Try the pin in the holes.",
        "If your program allows for the kerf, take the files without -kerf, else those with it; "
        f"they are for {parameters.kerf_mm:g} mm (--kerf).",
    ]
    sections = [("First", first)]
    if "layers" in laser_kinds(design):
        height = stack_mm(design, "layers")
        copies = sheets_of_a_layer(design, "layers")
        each = "one part" if copies == 1 else f"{copies} equal parts"
        steps = [
            f"Every piece is a stack of {each} for each of its layers: B below, T on top. Glue them "
            "with a pin in the holes and the arrows one way; keep glue off the knuckles.",
            "Sand the knuckles a little where they meet: they must turn on each other.",
            f"Join the pieces by rods ⌀ {parameters.pin_mm:g} mm, {height:g} mm long: tight in the lower knuckle, "
            "loose in the upper one. A drop of glue or a cap on top keeps it.",
        ]
        sections.append((f"With pins: laser-layers, {height:g} mm thick", steps))
    steps = [
        f"Glue the {sheets_of_a_layer(design, 'outlines')} equal parts of each piece (laser-outlines) together.",
        "Cut the strips (laser-strips) from cloth, felt or strong tape, and fold them along the middle.",
        "Put the pieces side by side as the second shape wants them, and glue each strip over the walls of the two "
        "pieces that it names, from scored mark to scored mark, with its fold on the corner.",
        *laser_notes(design),
    ]
    sections.append((f"With strips: laser-outlines, {stack_mm(design, 'outlines'):g} mm thick", steps))
    return sections


def _picture(laser_sheet: LaserSheet, x: float, top: float, scale: float) -> list[Mark]:
    """A sheet at a scale, its upper left corner at (x, top)."""
    shift = np.array([x, top - scale * laser_sheet.height])
    frame = shapely.box(0.0, 0.0, laser_sheet.width, laser_sheet.height)
    marks: list[Mark] = [Region(tuple(scale * ring + shift for ring in rings(frame)), "rule")]
    for part in laser_sheet.parts:
        marks.append(Region(tuple(scale * ring + shift for ring in rings(part.region)), "laser-cut"))
        if not part.engraved.is_empty:
            marks.append(Region(tuple(scale * ring + shift for ring in rings(part.engraved)), "laser-engrave"))
        scored = shapely.get_parts(part.scored)
        marks += [Line(scale * shapely.get_coordinates(line) + shift, "laser-score") for line in scored]
    return marks
