"""How well shapes were read, as columns of `shapes`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from pipeline.stages.qualities import COUNTS, NUMBERS, qualities
from pipeline.stages.stage import Column
from pipeline.store.artifact import Artifact

COLUMNS = (
    Column("kept", "float64", "share of the object's area that is in the shape, its largest part", "1"),
    Column("covered", "float64", "share of the page that it covers; null = no page, as of polygons", "1"),
    Column("sides", "int32", "sides of the page that it touches, 0 to 4", "count"),
    Column("separation", "float64", "Otsu's criterion: how clearly object and page separate; null = no picture", "1"),
    Column("dropped", "int32", "parts that do not touch it and were dropped, specks apart", "count"),
    Column("roughness", "float64", "how much longer the traced outline is than its corners joined, less 1", "1"),
    Column("changed", "float64", "share of the area that the repair of a self-crossing outline changed", "1"),
    Column("remarks", "string", "what else was done to find the object, empty = nothing"),
    Column("doubts", "string", "why a person should look at the outline, empty = no reason"),
)


def columns(artifact: Artifact) -> Mapping[str, Any]:
    """`COLUMNS` of a batch."""
    known = qualities(artifact)
    return {
        **{name: [_null(getattr(of, name)) for of in known] for name in (*NUMBERS, *COUNTS)},
        "remarks": ["; ".join(of.remarks) for of in known],
        "doubts": ["; ".join(of.doubts) for of in known],
    }


def _null(value: float) -> float | None:
    return None if math.isnan(value) else value
