"""Ingest: pictures, vector files and sample definitions become shapes (paper §6)."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path, PurePath
from typing import Any

import numpy as np

from pipeline.datasets.item import SAMPLE_PREFIX, SOURCE, Item
from pipeline.datasets.reading import open_item
from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages import quality_columns
from pipeline.stages.qualities import pack_qualities
from pipeline.stages.shape_arrays import ErrorRow, attempt, pack_shapes
from pipeline.stages.stage import Column, Stage, TableColumns
from pipeline.store.artifact import Artifact
from riot import geometry
from riot.parameters import ShapeParameters


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Sequence[Item]) -> Artifact:
    """One batch of items → arrays of `pack_shapes` and `pack_qualities`, and a row for each failure."""
    (settings,) = parameters
    assert isinstance(settings, ShapeParameters)
    errors: list[ErrorRow] = []
    for item in spec:
        check_unchanged(item)
    shapes = [
        attempt(index, lambda item=item: open_item(item, settings), errors)  # type: ignore[misc]
        for index, item in enumerate(spec)
    ]
    for row in errors:
        row["message"] = _without_path(row["message"], str(spec[row["index"]].source))
    return Artifact({**pack_shapes(shapes), **pack_qualities(shapes)}, {"errors": errors})


def _without_path(message: str, source: str) -> str:
    return message.replace(source, SOURCE).replace(PurePath(source).name, SOURCE)


def check_unchanged(item: Item) -> None:
    """Raise RuntimeError if a file changed since the run was planned: its key would name other bytes."""
    if item.source.startswith(SAMPLE_PREFIX):
        return
    if hashlib.sha256(Path(item.source).read_bytes()).hexdigest() != item.digest:
        raise RuntimeError(f"{item.name}: the file changed while the run went on; start the run again")


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each batch."""
    recipe = progress.recipes["ingest"]
    batches = [(batch, progress.items[batch.start : batch.stop]) for batch in progress.batches]
    return [
        recipe.item(recipe.parts([item.digest for item in members]), spec=members, members=batch)
        for batch, members in batches
    ]


def shape_key(progress: Progress, position: int) -> str:
    """The content key of a single shape; it does not depend on the shape's batch."""
    return progress.recipes["ingest"].parts([progress.items[position].digest]).key()


def _outlines(artifact: Artifact) -> Mapping[str, Any]:
    offsets = artifact.arrays["offsets"].tolist()
    outlines = [artifact.arrays["points"][low:high] for low, high in pairwise(offsets)]
    extents = [np.ptp(points, axis=0) if len(points) else (math.nan, math.nan) for points in outlines]
    features = np.concatenate([[0], np.cumsum(artifact.arrays["feature"])])[offsets]
    return {
        "points": np.diff(offsets),
        "features": np.diff(features),
        "perimeter": [math.fsum(geometry.polyline.edge_lengths(np.asarray(points))) for points in outlines],
        "width": [float(width) for width, _ in extents],
        "height": [float(height) for _, height in extents],
        "outline": [geometry.wkb.outline_wkb(np.asarray(points)) if len(points) else None for points in outlines],
        **quality_columns.columns(artifact),
    }


STAGE = Stage(
    name="ingest",
    unit="batches of pictures",
    after=(),
    parameters=("shape",),
    items=items,
    run=run,
    scope="batch",
    bundle=4,
    tables=(
        TableColumns(
            "shapes",
            (
                Column("points", "int32", "boundary points", "count"),
                Column("features", "int32", "main feature points among them", "count"),
                Column("perimeter", "float64", "length of the boundary", "unit-area frame"),
                Column("width", "float64", "extent in x", "unit-area frame"),
                Column("height", "float64", "extent in y", "unit-area frame"),
                Column("outline", "polygon", "the outline, centroid at the origin, as WKB", "unit-area frame"),
                *quality_columns.COLUMNS,
            ),
            _outlines,
        ),
    ),
)
