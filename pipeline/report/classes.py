"""The classes of a run: the best transform of each, and a matrix of what becomes what. Ours."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from pipeline.report.environment import render
from pipeline.report.gallery import INDEX, REPORT, STYLE, listed_classes
from pipeline.report.pictures import HEIGHT, WIDTH, silhouette
from pipeline.report.rows import TransformRow
from pipeline.report.run import ReportedRun, ShapeClass
from pipeline.report.words import plain_words
from pipeline.tables.messages import several
from riot.errors import needs_extra

with needs_extra("mine"):
    from markupsafe import Markup

CLASSES = "classes.html"

LEAST = 2
"""A page needs so many classes."""

COLOUR_MAP, TONES = "viridis", 8
"""A colour map of matplotlib that is read in grey and by colour-blind eyes, and how many of its colours a cell has."""


@dataclass(frozen=True)
class ClassBest:
    """A class, the silhouette of its first shape, and its best transform; None = there is none, and ``why``."""

    words: str
    silhouette: Markup
    best: TransformRow | None
    transforms: int
    why: str


@dataclass(frozen=True)
class Cell:
    """The best transform of two classes, how many they have, and its tone; or, without one, ``span`` empty places."""

    row: TransformRow | None
    transforms: int = 0
    tone: int = 0
    span: int = 1


@dataclass(frozen=True)
class Tone:
    """A colour, as ``#rrggbb``, and the IoU from which and up to which it stands."""

    colour: str
    least: float
    greatest: float


def classes_page(run: ReportedRun, rows: Sequence[TransformRow]) -> str:
    """The page of a run's classes; ``rows`` are the transforms that have a page, best first."""
    of_pair: dict[frozenset[str], list[TransformRow]] = {}
    for row in rows:
        if row.class_p and row.class_q:
            of_pair.setdefault(frozenset((row.class_p, row.class_q)), []).append(row)
    best = {pair: max(found, key=lambda row: row.iou) for pair, found in of_pair.items()}
    tones = _tones([row.iou for row in best.values()])
    names = [kind.name for kind in run.classes]
    listed = listed_classes(rows)
    return render(
        "classes.html",
        name=run.name,
        bests=[_class_best(kind, rows) for kind in run.classes],
        names=[(plain_words(name), listed.index(name) if name in listed else None) for name in names],
        matrix=[_cells(name, names, of_pair, best, tones) for name in names],
        pairs=len(best),
        tones=tones,
        index=INDEX,
        report=REPORT,
        style=STYLE,
        size=(WIDTH, HEIGHT),
    )


def _class_best(kind: ShapeClass, rows: Sequence[TransformRow]) -> ClassBest:
    own = [row for row in rows if kind.name in row.classes]
    why = f"None of its {several(kind.selected, 'selected pair')} is among the transforms"
    return ClassBest(
        plain_words(kind.name),
        silhouette(kind.outline) if len(kind.outline) else Markup(),
        own[0] if own else None,
        len(own),
        why if kind.selected else "None of its pairs was selected",
    )


def _cells(
    name: str,
    names: Sequence[str],
    of_pair: Mapping[frozenset[str], Sequence[TransformRow]],
    best: Mapping[frozenset[str], TransformRow],
    tones: Sequence[Tone],
) -> list[Cell]:
    """The cells of a row; places without a transform are joined."""
    cells: list[Cell] = []
    for other in names:
        pair = frozenset((name, other))
        if pair in best:
            row = best[pair]
            tone = next(k for k, tone in enumerate(tones) if row.iou <= tone.greatest)
            cells.append(Cell(row, len(of_pair[pair]), tone))
        elif cells and cells[-1].row is None:
            cells[-1] = Cell(None, span=cells[-1].span + 1)
        else:
            cells.append(Cell(None))
    return cells


def _tones(values: Sequence[float]) -> list[Tone]:
    """Colours for values from the least to the greatest, in steps of whole hundredths."""
    import matplotlib  # half a second, which a run without classes does not wait for

    if not values:
        return []
    low, high = math.floor(100 * min(values)), math.ceil(100 * max(values))
    step = max(1, math.ceil((high - low) / TONES))
    count = max(1, math.ceil((high - low) / step))
    colours = matplotlib.colormaps[COLOUR_MAP].resampled(count)
    edges = [(low + step * k) / 100 for k in range(count)] + [high / 100]
    return [
        Tone(matplotlib.colors.to_hex(colours(k)), least, greatest)
        for k, (least, greatest) in enumerate(pairwise(edges))
    ]
