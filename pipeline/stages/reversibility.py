"""Reversibility scores of one batch of shapes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from pipeline.stages.items import ErrorRow, attempt, count_shapes, unpack_shape
from pipeline.store.artifact import Artifact
from riot.scores.reversibility import Reversibility, reversibility


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: None) -> Artifact:
    """Batch of shapes → ``score``, ``s1``, ``s2``, ``waist`` (k,) float64 (nan without a shape), necks ragged."""
    (batch,), (settings,) = inputs, parameters
    errors: list[ErrorRow] = []
    found: list[Reversibility | None] = []
    for index in range(count_shapes(batch)):
        shape = unpack_shape(batch, index)
        found.append(
            None if shape is None else attempt(index, lambda shape=shape: reversibility(shape, settings), errors)  # type: ignore[misc]
        )
    counts = [0 if one is None else len(one.necks) for one in found]
    present = [one for one in found if one is not None]
    arrays = {
        name: np.array([math.nan if one is None else getattr(one, name) for one in found], dtype=np.float64)
        for name in ("score", "s1", "s2", "waist")
    }
    arrays["neck_offsets"] = np.concatenate([np.zeros(1, np.int64), np.cumsum(counts, dtype=np.int64)])
    arrays["necks"] = np.concatenate([np.empty((0, 2), np.int64), *(one.necks for one in present)])
    arrays["neck_ratio"] = np.concatenate([np.empty(0), *(one.neck_ratio for one in present)])
    return Artifact(arrays, {"errors": errors})
