"""How well the shapes of a batch were read, as arrays of the artifacts of ingest, and as columns of `shapes`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pipeline.stages.stage import Column
from pipeline.store.artifact import AnyArray, Artifact
from riot import geometry
from riot.geometry.quality import ReadingQuality
from riot.geometry.shape import Shape
from riot.types import BoolArray

NUMBERS = ("kept", "covered", "separation", "roughness", "changed")
COUNTS = ("sides", "dropped")

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


def pack_qualities(shapes: Sequence[Shape | None]) -> dict[str, AnyArray]:
    """(k,) arrays ``quality_NAME`` of the qualities of shapes; of a missing shape as of one of which nothing is known.

    ``quality_doubtful`` is whether it is `ReadingQuality.doubtful`; ``quality_remarks`` has a bit for each of
    `riot.geometry.quality.REMARKS`.
    """
    known = [(shape.quality if shape is not None else None) or ReadingQuality() for shape in shapes]
    remarks = geometry.quality.REMARKS
    return {
        **{f"quality_{name}": np.array([getattr(of, name) for of in known], dtype=np.float64) for name in NUMBERS},
        **{f"quality_{name}": np.array([getattr(of, name) for of in known], dtype=np.int32) for name in COUNTS},
        "quality_doubtful": np.array([of.doubtful for of in known], dtype=np.bool_),
        "quality_remarks": np.array(
            [sum(1 << remarks.index(remark) for remark in of.remarks) for of in known], dtype=np.int32
        ),
    }


def qualities(artifact: Artifact) -> list[ReadingQuality]:
    """The qualities of the shapes of a batch."""
    arrays = {name: artifact.arrays[f"quality_{name}"].tolist() for name in (*NUMBERS, *COUNTS, "remarks")}
    rows = [dict(zip(arrays, row, strict=True)) for row in zip(*arrays.values(), strict=True)]
    return [ReadingQuality(**{**row, "remarks": _remarks(row["remarks"])}) for row in rows]


def doubtful(artifacts: Mapping[int, Artifact], count: int) -> BoolArray:
    """(count,) which shapes are doubtful, of batches by the position of their first shape."""
    mask = np.zeros(count, dtype=np.bool_)
    for start, artifact in artifacts.items():
        of_batch = artifact.arrays["quality_doubtful"]
        mask[start : start + len(of_batch)] = of_batch
    return mask


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


def _remarks(bits: int) -> tuple[str, ...]:
    return tuple(remark for number, remark in enumerate(geometry.quality.REMARKS) if bits >> number & 1)
