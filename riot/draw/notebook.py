"""Shapes, trunks, plans and transforms as a notebook shows them: HTML that holds a picture each. Ours.

A picture is an image of its own, so that its styles and ids meet those of no other; it has no background, and colours
that show on light and on dark pages. A transform swings, also where scripts are not trusted; where they are, it gets a
slider.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from string import Template
from urllib.parse import quote

import numpy as np

from riot.construction.plan import ConstructionPlan
from riot.draw.animate import MOTION_STYLE, loop_times, swing_of
from riot.draw.panels import outline_with_trunk, sketch, thin_outline
from riot.draw.scene import Mark, Region, Scene, around, extent, moved
from riot.draw.svg import document, naming, whole
from riot.draw.svg_text import escape
from riot.draw.tuning import GRID_COLUMNS, GRID_SCALE, GRID_TRUNKS, NOTEBOOK_PIXELS, NOTEBOOK_SCALE
from riot.geometry.shape import Shape
from riot.scores.trunks import Trunks
from riot.transform.transform import Transform

_UNQUOTED = " !$'()*+,-./:;=?@[]^_`{|}~"
"""What a data URL within double quotes may hold as it is."""


def shape_svg(shape: Shape) -> str:
    """The outline of a shape, filled, as an SVG file without background.

    >>> shape_svg(house)[:4]
    '<svg'
    """
    outline = thin_outline(shape)
    scene = _scene(_title(shape), [Region((outline,), "silhouette"), Region((outline,), "outline")])
    return document(scene, _width(scene), background=False)


def shape_html(shape: Shape) -> str:
    """The picture of `shape_svg` with the shape's name below.

    >>> "<figcaption" in shape_html(house)
    True
    """
    return figure_html(shape_svg(shape), _title(shape), shape.name)


def trunks_html(shape: Shape, trunks: Trunks, numbers: Sequence[int]) -> str:
    """The trunks of these numbers, each on the shape that has them.

    >>> from riot import trunks
    >>> "trunks 0, 5 of" in trunks_html(house, trunks(house), [0, 5])
    True
    """
    words = f"trunks {', '.join(map(str, numbers))} of {len(trunks)}" if numbers else "no trunks"
    if shape.name:
        words = f"{shape.name}: {words}"
    if not numbers:
        return figure_html(shape_svg(shape), words, words)
    outline = thin_outline(shape)
    low, high = outline.min(axis=0), outline.max(axis=0)
    step = 1.15 * (high - low)
    marks: list[Mark] = []
    for k, trunk in enumerate(numbers):
        row, column = divmod(k, GRID_COLUMNS)
        cell = outline_with_trunk(outline, shape.points[trunks.of(trunk)])
        marks += moved(cell, column * step[0], -row * step[1])
    scene = _scene(words, marks, GRID_SCALE)
    return figure_html(document(scene, _width(scene, GRID_SCALE), background=False), words, words)


def evenly(trunks: int) -> list[int]:
    """Numbers of at most `GRID_TRUNKS` among so many trunks, from the first to the last.

    >>> evenly(3), len(evenly(1000))
    ([0, 1, 2], 12)
    """
    return sorted({round(number) for number in np.linspace(0, trunks - 1, min(trunks, GRID_TRUNKS)).tolist()})


def plan_html(plan: ConstructionPlan) -> str:
    """The corresponding trunks of a plan, each on its shape.

    >>> from riot import alternatives
    >>> "highest IoU" in plan_html(alternatives(house, kite)[0])
    True
    """
    p, q = plan.pair.p, plan.pair.q
    # Edge j of one trunk corresponds to edge j of the other, and has its colour.
    sides = [outline_with_trunk(thin_outline(shape), trunk) for shape, trunk in ((p, plan.trunk_p), (q, plan.trunk_q))]
    boxes = [extent(marks, ()) for marks in sides]
    marks = [*sides[0], *moved(sides[1], boxes[0][2] - boxes[1][0] + 0.25, 0.0)]
    words = f"{p.name or 'P'} ⇄ {q.name or 'Q'}: trunks of {len(plan.trunk_p)} vertices, highest IoU {plan.bound:.3f}"
    scene = _scene(words, marks)
    return figure_html(document(scene, _width(scene), background=False), words, words)


def transform_html(transform: Transform, caption: str) -> str:
    """The transform swinging from P to Q and back, with a slider where scripts run.

    >>> transform_html(transform, "house ⇄ kite").count("<script>")
    1
    """
    prefix = naming(sketch(transform).pieces)
    swing = swing_of(transform, prefix)
    x0, y0, x1, y1 = swing.scene.box
    width = round(NOTEBOOK_PIXELS * min(1.0, (x1 - x0) / (y1 - y0)))
    picture = whole(swing.scene, swing.body, prefix, width, style=MOTION_STYLE, background=False)
    times = {name: f"{seconds:.4g}" for name, seconds in loop_times(transform).items()}
    script = f"<script>{_template('slider.js').substitute(times)}</script>\n"
    return figure_html(picture, swing.scene.title, caption, script)


def figure_html(svg: str, title: str, caption: str, controls: str = "") -> str:
    """An SVG file as an image on a page, with a caption; ``controls`` is HTML between them.

    >>> figure_html('<svg width="2" height="1"></svg>', "nothing", "").count("data:image/svg+xml")
    1
    """
    width, height = (svg.partition(f'{name}="')[2].partition('"')[0] for name in (" width", " height"))
    return _template("figure.html").substitute(
        source=f"data:image/svg+xml,{quote(svg, safe=_UNQUOTED)}",
        width=width,
        height=height,
        title=escape(title),
        controls=controls,
        caption=escape(caption),
    )


@cache
def _template(name: str) -> Template:
    return Template((Path(__file__).with_name("templates") / name).read_text(encoding="utf-8"))


def _title(shape: Shape) -> str:
    return f"{shape.name or 'shape'}, {len(shape.points)} boundary points"


def _scene(title: str, marks: list[Mark], scale: float = NOTEBOOK_SCALE) -> Scene:
    pen = 1.0 / scale
    return Scene(title, around([extent(marks, ())], 4.0 * pen), pen, (), tuple(marks))


def _width(scene: Scene, scale: float = NOTEBOOK_SCALE) -> int:
    """Pixels of a unit are the same in all pictures, so that shapes compare, unless one is too large."""
    x0, y0, x1, y1 = scene.box
    fitting = min(scale, 2 * NOTEBOOK_PIXELS / (x1 - x0), NOTEBOOK_PIXELS / (y1 - y0))
    return max(1, math.floor(fitting * (x1 - x0)))
