"""The gallery: all transforms of a run as a plain list of links, which a script makes one to filter and sort. Ours."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath

from pipeline.report.markup import document, number
from pipeline.report.rows import TransformRow
from pipeline.report.thumb import HEIGHT, WIDTH
from pipeline.tables.messages import several
from riot.draw.svg import escape

INDEX, STYLE, SCRIPT = "index.html", "style.css", "gallery.js"
REPORT = "../report.html"


@dataclass(frozen=True)
class Order:
    """A way to sort: its words, the number that it sorts by (nan comes last), and whether the greatest is the best."""

    words: str
    value: Callable[[TransformRow], float]
    greatest_first: bool = False


ORDERS: Mapping[str, Order] = {
    "rank": Order("rank", lambda row: row.rank),
    "iou": Order("IoU", lambda row: row.iou, greatest_first=True),
    "bound": Order("bound of the IoU", lambda row: min(row.bound_p, row.bound_q), greatest_first=True),
    "change": Order("change / least", lambda row: row.change_ratio),
    "crs": Order("CRS", lambda row: row.crs, greatest_first=True),
    "qcrs": Order("QCRS", lambda row: row.qcrs, greatest_first=True),
    "hausdorff": Order("Hausdorff distance", lambda row: max(row.hausdorff_p, row.hausdorff_q)),
    "distance": Order("mean distance", lambda row: max(row.mean_distance_p, row.mean_distance_q)),
    "bending": Order("bending", lambda row: max(row.bending_p, row.bending_q)),
    "direction": Order("directions off", lambda row: max(row.direction_p, row.direction_q)),
    "n": Order("pieces", lambda row: row.n),
}
"""Of two shapes the worse one counts, as everywhere."""


def page_name(row: TransformRow) -> str:
    """File name of the transform's own page in the gallery's folder."""
    return f"{_stem(row)}.html"


def thumb_name(row: TransformRow) -> str:
    """File name of its small picture there."""
    return f"{_stem(row)}.svg"


def index(name: str, rows: Sequence[TransformRow], printed: frozenset[int] = frozenset()) -> str:
    """The page of all transforms; ``name`` is the collection's, ``printed`` are ranks that have a puzzle."""
    classes = sorted({one for row in rows for one in row.classes})
    numbers = {one: place for place, one in enumerate(classes)}
    items = "".join(_item(row, numbers, row.rank in printed) for row in rows)
    listed = f'<ol class="grid">\n{items}</ol>' if rows else '<p class="empty">No transform was constructed.</p>'
    body = (
        f'<header class="top"><p class="kicker"><a href="{REPORT}">{escape(name)}</a></p><h1>Gallery</h1>'
        '<p class="lead">Two shapes each that are the same chain of hinged pieces. '
        "A piece has one colour in both.</p>"
        f"</header>\n<main>{_controls(rows, classes, bool(printed))}{listed}</main>\n"
        f'<footer>Static files: the numbers are those of transforms.parquet, the <a href="{REPORT}">report</a> '
        "tells how they came about.</footer>\n"
    )
    head = f'<link rel="stylesheet" href="{STYLE}"><script defer src="{SCRIPT}"></script>'
    return document(f"{name} · gallery of reversible transforms", head, body)


def _item(row: TransformRow, classes: Mapping[str, int], printed: bool) -> str:
    values = " ".join(_value(order.value(row)) for order in ORDERS.values())
    kinds = " ".join(str(classes[one]) for one in row.classes)
    marks = {None: "", True: "f", False: "l"}[row.swings_flat] + ("a" if row.approximate else "") + "p" * printed
    p, q = escape(row.name_p), escape(row.name_q)
    words = {None: "", True: " · flat", False: " · lifts"}[row.swings_flat]
    if row.approximate:
        words += " · approximate"
    return (
        f'<li data-v="{values}" data-c="{kinds}" data-m="{marks}"><a href="{page_name(row)}">'
        f'<img src="{thumb_name(row)}" alt="{p} and {q}, each of the same {row.n} pieces" '
        f'width="{WIDTH}" height="{HEIGHT}" loading="lazy">'
        f"<b>{p} ⇄ {q}</b><small>IoU {number(row.iou)} · {row.n} pieces{words}</small></a></li>\n"
    )


def _controls(rows: Sequence[TransformRow], classes: Sequence[str], printed: bool) -> str:
    """The form that the script shows and reads; it does nothing without the script, so it is hidden until then."""
    least = math.floor(100 * min((row.iou for row in rows if math.isfinite(row.iou)), default=0.0)) / 100
    pieces = sorted({row.n for row in rows})
    boxes = [
        ("flat", "f", "swings flat", any(row.swings_flat is not None for row in rows)),
        ("exact", "!a", "exact", any(row.approximate for row in rows)),
        ("puzzle", "p", "has a puzzle", printed),
    ]
    ticks = "".join(
        f'<label class="tick"><input type="checkbox" name="{name}" data-mark="{mark}"> {words}</label>'
        for name, mark, words, useful in boxes
        if useful
    )
    kinds = _select("class", [(str(place), escape(one)) for place, one in enumerate(classes)], "all")
    sizes = _select("n", [(str(n), str(n)) for n in pieces], "any")
    orders = "".join(
        f'<option value="{name}" data-sign="{-1 if order.greatest_first else 1}">{order.words}</option>'
        for name, order in ORDERS.items()
    )
    return (
        '<form class="controls" hidden role="search" aria-label="Transforms">'
        '<label class="wide"><span>name or class <kbd>/</kbd></span>'
        '<input type="search" name="q" autocomplete="off"></label>'
        f"<label>class{kinds}</label><label>pieces{sizes}</label>"
        f'<label><span>IoU at least <output>{least:.2f}</output></span><input type="range" name="iou" '
        f'min="{least:.2f}" max="1" step="0.01" value="{least:.2f}"></label>'
        f'<label>sort by<select name="sort">{orders}</select></label>'
        f'<label class="tick"><input type="checkbox" name="reverse"> reversed</label>{ticks}'
        '<button type="reset">Show all</button></form>'
        f'<p class="shown" role="status">{several(len(rows), "transform", "transforms")}</p>'
    )


def _select(name: str, options: Sequence[tuple[str, str]], every: str) -> str:
    listed = "".join(f'<option value="{value}">{words}</option>' for value, words in options)
    return f'<select name="{name}"><option value="">{every}</option>{listed}</select>'


def _value(value: float) -> str:
    return f"{value:.5g}" if math.isfinite(value) else "-"


def _stem(row: TransformRow) -> str:
    return PurePosixPath(row.file).stem
