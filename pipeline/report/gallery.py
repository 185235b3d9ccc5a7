"""The gallery: all transforms of a run as a plain list of links, which a script makes one to filter and sort. Ours."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from pipeline.report.environment import render, style_sheet
from pipeline.report.pictures import HEIGHT, WIDTH
from pipeline.report.rows import TransformRow

INDEX, STYLE = "index.html", "style.css"
REPORT = "../report.html"


@dataclass(frozen=True)
class SortOrder:
    """A way to sort: its words, the number that it sorts by (nan comes last), and whether the greatest is the best."""

    words: str
    value: Callable[[TransformRow], float]
    greatest_first: bool = False


ORDERS: Mapping[str, SortOrder] = {
    "rank": SortOrder("rank", lambda row: row.rank),
    "recognised": SortOrder("recognised (margin)", lambda row: row.margin, greatest_first=True),
    "iou": SortOrder("fidelity (IoU)", lambda row: row.iou, greatest_first=True),
    "strain": SortOrder("least strain", lambda row: row.rms_strain),
    "surprise": SortOrder("surprise", lambda row: row.surprise, greatest_first=True),
    "bound": SortOrder("bound of the IoU", lambda row: min(row.bound_p, row.bound_q), greatest_first=True),
    "change": SortOrder("change / least", lambda row: row.change_ratio),
    "crs": SortOrder("CRS", lambda row: row.crs, greatest_first=True),
    "qcrs": SortOrder("QCRS", lambda row: row.qcrs, greatest_first=True),
    "hausdorff": SortOrder("Hausdorff distance", lambda row: row.hausdorff),
    "distance": SortOrder("mean distance", lambda row: max(row.mean_distance_p, row.mean_distance_q)),
    "bending": SortOrder("bending", lambda row: max(row.bending_p, row.bending_q)),
    "direction": SortOrder("directions off", lambda row: max(row.direction_p, row.direction_q)),
    "limbs": SortOrder("limbs kept (clDice)", lambda row: row.cldice, greatest_first=True),
    "n": SortOrder("pieces", lambda row: row.n),
}
"""Of two shapes the worse one counts, as everywhere. A page offers those of which the run has values."""


@dataclass(frozen=True)
class GalleryItem:
    """A transform of the list, and what the script reads: values by `ORDERS`, numbers of classes, and marks.

    Marks are one letter each: f = swings flat, l = lifts, a = approximate, p = has a puzzle.
    """

    row: TransformRow
    values: str
    classes: str
    marks: str


@dataclass(frozen=True)
class Filters:
    """What the form offers: classes, numbers of pieces, the least IoU, and tick boxes (name, mark, words)."""

    classes: Sequence[str]
    pieces: Sequence[int]
    least_iou: float
    boxes: Sequence[tuple[str, str, str]]


def index(name: str, rows: Sequence[TransformRow], printed: frozenset[int] = frozenset(), classes: str = "") -> str:
    """The page of all transforms; ``name`` is the collection's, ``printed`` are ranks that have a puzzle.

    ``classes`` is the address of the page of classes, if there is one.
    """
    filters = _filters(rows, bool(printed))
    numbers = {kind: k for k, kind in enumerate(filters.classes)}
    return render(
        "gallery.html",
        name=name,
        items=[_item(row, numbers, row.rank in printed) for row in rows],
        filters=filters,
        orders={name: order for name, order in ORDERS.items() if any(math.isfinite(order.value(row)) for row in rows)},
        names=list(ORDERS),
        report=REPORT,
        classes_page=classes,
        style=STYLE,
        size=(WIDTH, HEIGHT),
    )


def files() -> dict[str, str]:
    """The texts of the files that all pages of the gallery share, by name."""
    return {STYLE: style_sheet("wall.css", "classes.css", "gallery.css", "transform.css")}


def listed_classes(rows: Sequence[TransformRow]) -> list[str]:
    """The classes of the shapes of ``rows``, in order: the form and its addresses name them by their numbers."""
    return sorted({kind for row in rows for kind in row.classes})


def _item(row: TransformRow, classes: Mapping[str, int], printed: bool) -> GalleryItem:
    marks = {None: "", True: "f", False: "l"}[row.swings_flat] + "a" * row.approximate + "p" * printed
    values = " ".join(_value(order.value(row)) for order in ORDERS.values())
    return GalleryItem(row, values, " ".join(str(classes[kind]) for kind in row.classes), marks)


def _filters(rows: Sequence[TransformRow], printed: bool) -> Filters:
    least = min((row.iou for row in rows if math.isfinite(row.iou)), default=0.0)
    boxes = (
        ("flat", "f", "swings flat", any(row.swings_flat is not None for row in rows)),
        ("exact", "!a", "exact", any(row.approximate for row in rows)),
        ("puzzle", "p", "has a puzzle", printed),
    )
    return Filters(
        listed_classes(rows),
        sorted({row.n for row in rows}),
        math.floor(100 * least) / 100,
        [box[:3] for box in boxes if box[3]],
    )


def _value(value: float) -> str:
    return f"{value:.5g}" if math.isfinite(value) else "-"
