"""How well the shapes of a batch were read, as arrays of the artifacts of ingest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pipeline.store.artifact import AnyArray, Artifact
from riot import geometry
from riot.geometry.quality import ReadingQuality
from riot.geometry.shape import Shape
from riot.types import BoolArray

NUMBERS = ("kept", "covered", "separation", "roughness", "changed")
COUNTS = ("sides", "dropped")


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


def _remarks(bits: int) -> tuple[str, ...]:
    return tuple(remark for number, remark in enumerate(geometry.quality.REMARKS) if bits >> number & 1)
