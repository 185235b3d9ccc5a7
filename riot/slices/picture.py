"""Pictures of a stack: the object, its slices stacked, the same turned; every slice before and after, flat. Ours."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from riot.draw.files import write_scene
from riot.draw.palette import LIGHT, PIECES, hue
from riot.draw.panels import deformation_marks, sketch
from riot.draw.raster import png_bytes
from riot.draw.scene import Bitmap, Label, Mark, Region, Scene, extent, moved
from riot.draw.solid import Body, Eye, View, mesh, prisms, render
from riot.fabricate.export.paper import rings
from riot.slices.cut import Slice, Stack
from riot.slices.make import Puzzle, SliceOutcome
from riot.transform.deformation import overlap_ratios
from riot.transform.transform import Transform

ACROSS = 560
"""The longest of the three views is so many pixels wide or high."""

TURNED_APART = 1.0
"""Turned slices stand so many thicknesses apart."""

EYE = Eye(math.radians(-60.0), math.radians(24.0))

_MARGIN, _CAPTION, _LETTERS = 40, 60, 21.0
_OBJECT = "#b9bec6"
_GAP, _LINE = 0.25, 13.0
_PENS_ACROSS = 1100.0
_NAME_LENGTH = 28


def draw_overview(stack: Stack, outcomes: Sequence[SliceOutcome], path: Path) -> None:
    """Draw the object, the stack of its slices, and the same slices turned inside out, as PNG; the same bytes always.

    Object and stack stand as the file has them; turned slices lie one over the other.
    A slice that could not be made is grey, and is missing from the turned ones.
    """
    turned_lift = (1.0 + TURNED_APART) * stack.thickness
    slices, turned = [], []
    for outcome in outcomes:
        if outcome.puzzle is None:
            slices.append(_prism(outcome.slice))
            continue
        slices += _pieces(outcome.puzzle, 0.0, outcome.slice.low)
        turned += _pieces(outcome.puzzle, 1.0, (outcome.slice.number - 1) * turned_lift)
    groups = [
        (_upright(stack, [Body(*mesh(stack.solid), _OBJECT)]), stack.name),
        (_upright(stack, slices), f"{len(stack.slices)} slices of {stack.thickness:g} mm, along {stack.along}"),
        (turned, "turned inside out"),
    ]
    longest = max(
        stack.height, *(float(np.ptp(np.concatenate([b.points for b in g]), axis=0).max()) for g, _ in groups if g)
    )
    views = [(render(bodies, longest / ACROSS, EYE), words) for bodies, words in groups if bodies]
    scene = _side_by_side(views)
    path.write_bytes(png_bytes(scene, round(scene.box[2])))


def draw_slices(outcomes: Sequence[SliceOutcome], path: Path) -> None:
    """Draw every slice that was made, a row each, lowest last: the outline and what it becomes, the pieces as the slice
    and as its counterpart, and the counterpart; the suffix (svg, png, pdf) chooses the format."""
    write_scene(path, lambda: slices_scene(outcomes))


def slices_scene(outcomes: Sequence[SliceOutcome]) -> Scene:
    """The picture of `draw_slices` before it has a format; shapes have unit area."""
    rows = [(outcome.slice, outcome.puzzle) for outcome in reversed(outcomes) if outcome.puzzle is not None]
    panels = [_panels(puzzle.transform) for _, puzzle in rows]
    boxes = [[extent(panel, ()) for panel in row] for row in panels]
    widths = [max(row[k][2] - row[k][0] for row in boxes) + _GAP for k in range(4)]
    width = sum(widths) + _GAP
    pen = width / _PENS_ACROSS
    marks: list[Mark] = []
    top = -_GAP
    for (slice_, puzzle), row, row_boxes in zip(rows, panels, boxes, strict=True):
        tall = max(y1 - y0 for _, y0, _, y1 in row_boxes)
        left = _GAP
        for k, (panel, (x0, y0, x1, y1), words) in enumerate(
            zip(row, row_boxes, _captions(slice_, puzzle), strict=True)
        ):
            middle = left + 0.5 * (widths[k] - _GAP)
            marks += moved(panel, middle - 0.5 * (x0 + x1), top - 0.5 * tall - 0.5 * (y0 + y1))
            marks.append(Label(middle, top - tall - 1.6 * _LINE * pen, words, "note"))
            left += widths[k]
        top -= tall + 2.0 * _LINE * pen + _GAP
    title = f"{len(rows)} slices, their pieces, and what they turn into"
    return Scene(title, (0.0, top, width, 0.0), pen, (), tuple(marks))


def _captions(slice_: Slice, puzzle: Puzzle) -> tuple[str, str, str, str]:
    iou_p, iou_q = overlap_ratios(puzzle.transform)
    name = puzzle.counterpart[:_NAME_LENGTH]
    return f"slice {slice_.number}", f"IoU {iou_p:.3f}", f"IoU {iou_q:.3f}", name


def _panels(transform: Transform) -> list[list[Mark]]:
    drawn = sketch(transform)
    return [
        deformation_marks(drawn, "p"),
        _dissection(drawn, 0.0),
        _dissection(drawn, 1.0),
        deformation_marks(drawn, "q"),
    ]


def _dissection(drawn: Transform, t: float) -> list[Mark]:
    pieces = drawn.parts(drawn.pose(t))
    return [Region((points,), f"piece{hue(i, len(pieces))}") for i, points in enumerate(pieces)]


def _pieces(puzzle: Puzzle, t: float, lift: float) -> list[Body]:
    """The solids of a puzzle closed as the slice (t = 0), in its place, or as the counterpart (1), about the z-axis."""
    built = puzzle.built
    transform, design = puzzle.transform, built.design
    pose = transform.pose(t)
    shift = transform.p.to_source[:, 2] if t == 0.0 else np.zeros(2)
    bodies = []
    pieces = [part for part in built.parts if part.kind == "piece"]
    for i, part in enumerate(pieces):
        points, triangles = part.mesh()
        flat = design.place(pose, i, points[:, :2]) + shift
        colour = PIECES[hue(i, len(pieces))]
        bodies.append(Body(np.column_stack([flat, points[:, 2] + lift]), triangles, colour))
    return bodies


def _upright(stack: Stack, bodies: Sequence[Body]) -> list[Body]:
    return [replace(body, points=stack.upright(body.points)) for body in bodies]


def _prism(slice_: Slice) -> Body:
    return Body(*prisms([(slice_.low, slice_.high, rings(slice_.outline))]), LIGHT["shade"])


def _side_by_side(views: Sequence[tuple[View, str]]) -> Scene:
    """The views on one ground, each with a line below; the unit is the pixel."""
    marks: list[Mark] = []
    left, top = _MARGIN, 0
    for view, words in views:
        rows, columns = view.pixels.shape[:2]
        marks.append(Bitmap(view.pixels, (left, _CAPTION, left + columns, _CAPTION + rows)))
        marks.append(Label(left + 0.5 * columns, 0.4 * _CAPTION, words, size=_LETTERS))
        left, top = left + columns + _MARGIN, max(top, rows)
    title = "; ".join(words for _, words in views)
    return Scene(title, (0.0, 0.0, float(left), float(top + _MARGIN + _CAPTION)), 1.0, (), tuple(marks))
