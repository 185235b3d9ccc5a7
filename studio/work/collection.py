"""A mined collection: its shapes as a wall of silhouettes, and the best partners of one of them or of another shape."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
from msgspec import Struct

from pipeline.match.search import MinedRun, Query, match, open_mined, trunks_as_mined
from pipeline.match.shapes import read_shapes
from riot.construction.plan_search import find_plans
from riot.construction.plan_transform import construct_plans
from riot.errors import RiotError
from riot.geometry.polyline import simplify
from riot.geometry.shape import Shape
from riot.parameters import ConstructParameters, RefineParameters
from riot.scores.index import TrunkIndex
from riot.scores.trunk_stack import stack
from riot.transform import shape_document
from studio.work.answer import Made, kept
from studio.work.material import once
from studio.work.material import shape as known_shape
from studio.work.reading import ShapeFile, shape_file

OUTLINE_TOLERANCE = 0.008
"""Douglas–Peucker tolerance of silhouettes on the wall, in the unit-area frame: a quarter of a pixel at 80."""

PREVIEW = RefineParameters(candidates=8, sketched=6, refined=1)
"""How a preview is found: a search of a tenth of a second."""


class Listing(Struct, frozen=True):
    """The shapes of a collection by number: name, number of the class, reversibility."""

    dataset: str
    classes: list[str]
    shapes: list[tuple[str, int, float | None]]


@dataclass(frozen=True)
class Partner:
    """A shape by number, and its QCRS with what was asked for."""

    shape: int
    qcrs: float


@cache
def mined_run(folder: Path) -> MinedRun:
    """The run in a folder; raises `pipeline.errors.StartError` if it is not whole."""
    return open_mined(folder)


@cache
def trunk_index(folder: Path) -> TrunkIndex:
    """The index over its trunks."""
    return mined_run(folder).index(lambda words: None)


@cache
def collection_shapes(folder: Path) -> Mapping[int, Shape]:
    """All its shapes by number."""
    mined = mined_run(folder)
    return read_shapes(mined, range(len(mined.names)))


def list_collection(folder: Path) -> Listing:
    """Names, classes and reversibility of all shapes; opens the run, reads its shapes and its index."""
    mined = mined_run(folder)
    collection_shapes(folder)
    trunk_index(folder)
    classes = sorted(set(mined.classes))
    scores = _reversibility(folder, len(mined.names))
    numbers = [classes.index(name) for name in mined.classes]
    return Listing(mined.dataset, classes, list(zip(mined.names, numbers, scores, strict=True)))


def silhouettes(folder: Path, first: int, count: int) -> list[str]:
    """Outlines of so many shapes as SVG path data in thousandths, y downwards; empty where there is no shape."""
    shapes = collection_shapes(folder)
    last = min(first + count, len(mined_run(folder).names))
    return [path_data(shapes[number]) if number in shapes else "" for number in range(first, last)]


def path_data(shape: Shape) -> str:
    """An outline as SVG path data.

    >>> path_data(house)
    'm0 -740l-500 500v750h1000v-750z'
    """
    corners = np.round(shape.points[simplify(shape.points, OUTLINE_TOLERANCE)] * [1000.0, -1000.0]).astype(int)
    moves = np.diff(corners, axis=0).tolist()
    x, y = corners[0].tolist()
    return f"m{x} {y}" + "".join(_line(dx, dy) for dx, dy in moves) + "z"


def collection_shape(folder: Path, number: int) -> ShapeFile:
    """A shape of the collection as an input; KeyError if there is none of this number."""
    return shape_file(shape_document.to_document(collection_shapes(folder)[number]))


def partners_of_number(folder: Path, number: int, count: int) -> list[Partner]:
    """The best partners of a shape of the collection; KeyError if there is none of this number."""
    return _partners(folder, collection_shapes(folder)[number], mined_run(folder).digests[number], count)


def partners_of_input(folder: Path, files: Mapping[str, bytes], digest: str, count: int) -> list[Partner]:
    """The best partners of a shape that was given."""
    return _partners(folder, known_shape(files, digest), "", count)


def preview(folder: Path, own: int | str, files: Mapping[str, bytes], other: int) -> Made | None:
    """A small transform of a shape, by number or of this digest, with one of the collection; None if there is none."""
    shapes = collection_shapes(folder)
    shape = shapes[own] if isinstance(own, int) else known_shape(files, own)
    try:
        plans, unplanned = find_plans(shape, shapes[other], PREVIEW)
        return kept(construct_plans(plans, unplanned, ConstructParameters()), thumbnail=True)
    except RiotError:
        return None


def _partners(folder: Path, shape: Shape, digest: str, count: int) -> list[Partner]:
    mined = mined_run(folder)
    trunks = once(("trunks", folder, shape_key(shape)), lambda: trunks_as_mined(mined, shape))
    result = match(mined, trunk_index(folder), Query(shape.name, digest, trunks, stack([trunks])), count)
    numbers, scores = result.scores.j.tolist(), result.scores.score.tolist()
    return [Partner(number, round(score, 4)) for number, score in zip(numbers, scores, strict=True)]


def shape_key(shape: Shape) -> bytes:
    """What tells shapes apart."""
    return shape.points.tobytes()


def _line(dx: int, dy: int) -> str:
    if dy == 0:
        return f"h{dx}"
    return f"v{dy}" if dx == 0 else f"l{dx} {dy}"


def _reversibility(folder: Path, count: int) -> list[float | None]:
    table = folder / "reversibility.parquet"
    scores: list[float | None] = [None] * count
    if table.exists():
        rows = pq.ParquetFile(table).read(columns=["shape", "score"]).to_pydict()
        for number, score in zip(rows["shape"], rows["score"], strict=True):
            scores[number] = None if score is None or math.isnan(score) else round(score, 4)
    return scores
