"""The trunks of one batch of shapes that QCRS compares."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pipeline.stages.items import ErrorRow, attempt, count_shapes, unpack_shape
from pipeline.stages.trunk_arrays import NO_TRUNKS, pack_trunks
from pipeline.store.artifact import AnyArray, Artifact
from riot.geometry.shape import Shape
from riot.scores.leaves import gather_leaves
from riot.scores.reversibility import reversibility
from riot.scores.trunks import Trunks, compared_trunks
from riot.scores.vertices import sparse_points


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: None) -> Artifact:
    """Batch of shapes → arrays of `pipeline.stages.trunk_arrays.pack_trunks`, and ``sparse`` (k,) int64: point counts.

    And ``leaves`` (l, 16) int32 from ``leaf_offsets`` (k + 1,) int64, every shape's trunks gathered for the search.
    """
    (batch,), (settings, necks, variant) = inputs, parameters
    errors: list[ErrorRow] = []
    found: list[Trunks | None] = []
    sparse = np.zeros(count_shapes(batch), dtype=np.int64)
    for index in range(count_shapes(batch)):
        shape = unpack_shape(batch, index)
        if shape is None:
            found.append(None)
            continue

        def trunks(shape: Shape = shape) -> Trunks:
            return compared_trunks(shape, variant, settings, lambda: reversibility(shape, necks))

        found.append(attempt(index, trunks, errors))
        points = attempt(index, lambda shape=shape: sparse_points(shape, settings), [])  # type: ignore[misc]
        sparse[index] = 0 if points is None else len(points)
    leaves = [gather_leaves(NO_TRUNKS if each is None else each) for each in found]
    arrays: dict[str, AnyArray] = {
        "leaves": np.concatenate(leaves),
        "leaf_offsets": np.cumsum([0, *(len(each) for each in leaves)], dtype=np.int64),
    }
    return Artifact({**pack_trunks(found), **arrays, "sparse": sparse}, {"errors": errors})
