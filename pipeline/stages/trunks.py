"""The trunks of a batch of shapes that QCRS compares (paper §4.1, §5.2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.planning import after_each
from pipeline.stages.shape_arrays import ErrorRow, attempt_each
from pipeline.stages.stage import Column, Ragged, Stage, TableColumns
from pipeline.stages.trunk_arrays import no_trunks, pack_trunks
from pipeline.store.artifact import AnyArray, Artifact
from riot import scores
from riot.geometry.shape import Shape

if TYPE_CHECKING:
    from riot.scores.trunks import Trunks


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: None) -> Artifact:
    """Batch of shapes → arrays of `pack_trunks`, and ``sparse`` (k,) int64: numbers of sparse points.

    And ``leaves`` (l, 16) int32 from ``leaf_offsets`` (k + 1,) int64, every shape's trunks gathered for the search.
    """
    (batch,), (settings, necks, variant) = inputs, parameters
    errors: list[ErrorRow] = []

    def compare(shape: Shape) -> Trunks:
        return scores.trunks.compared_trunks(
            shape, variant, settings, lambda: scores.reversibility.reversibility(shape, necks)
        )

    trunks = attempt_each(batch, compare, errors)
    # Whatever keeps a shape from having sparse points is an error of its trunks, too, and told there.
    sparse = attempt_each(batch, lambda shape: len(scores.vertices.sparse_points(shape, settings)), [])
    leaves = [scores.leaves.gather_leaves(no_trunks() if stack is None else stack) for stack in trunks]
    arrays: dict[str, AnyArray] = {
        "leaves": np.concatenate(leaves),
        "leaf_offsets": np.cumsum([0, *map(len, leaves)], dtype=np.int64),
    }
    return Artifact(
        {**pack_trunks(trunks), **arrays, "sparse": np.array([count or 0 for count in sparse], dtype=np.int64)},
        {"errors": errors},
    )


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each batch."""
    return after_each(progress, "trunks", "ingest")


def _counts(artifact: Artifact) -> Mapping[str, Any]:
    return {"sparse_points": artifact.arrays["sparse"], "trunks": np.diff(artifact.arrays["trunk_offsets"])}


def _trunks(artifact: Artifact) -> Mapping[str, Any]:
    arrays = artifact.arrays
    counts, offsets, total = np.diff(arrays["trunk_offsets"]), arrays["offsets"], len(arrays["areas"])
    return {
        "index": np.repeat(np.arange(len(counts)), counts),
        "trunk": np.arange(total) - np.repeat(arrays["trunk_offsets"][:-1], counts),
        "n": np.diff(offsets),
        "area": arrays["areas"],
        "perimeter": np.add.reduceat(arrays["edges"], offsets[:-1]) if total else np.empty(0),
        "vertices": Ragged(offsets, arrays["vertices"]),
    }


STAGE = Stage(
    name="trunks",
    unit="batches of shapes",
    after=("ingest",),
    parameters=("trunks", "reversibility", "qcrs.variant"),
    items=items,
    run=run,
    scope="batch",
    bundle=8,
    tables=(
        TableColumns(
            "shapes",
            (
                Column("sparse_points", "int32", "sparse boundary points, candidates for trunk vertices", "count"),
                Column(
                    "trunks",
                    "int32",
                    "trunks that QCRS compares (tuned: full ones, else quick ones); with none, its every QCRS is 0",
                    "count",
                ),
            ),
            _counts,
            after="features",
        ),
        TableColumns(
            "trunks",
            (
                Column("trunk", "int32", "number within the shape", "trunk number"),
                Column("n", "int8", "vertices", "count"),
                Column("area", "float64", "area of the trunk; the shape's is 1", "unit-area frame"),
                Column("perimeter", "float64", "sum of the edge lengths", "unit-area frame"),
                Column("vertices", "list<int32>", "vertices, counter-clockwise", "index of boundary point"),
            ),
            _trunks,
            "Quick trunks, by shape and then by number of vertices and area.",
        ),
    ),
)
