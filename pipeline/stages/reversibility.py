"""Reversibility scores of a batch of shapes (paper §5.1)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.planning import after_each
from pipeline.stages.shape_arrays import ErrorRow, attempt_each
from pipeline.stages.stage import Column, Stage, TableColumns
from pipeline.store.artifact import Artifact
from riot import scores


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: None) -> Artifact:
    """Batch of shapes → ``score``, ``s1``, ``s2``, ``waist`` (k,) float64 (nan without a shape), necks ragged."""
    (batch,), (settings,) = inputs, parameters
    errors: list[ErrorRow] = []
    ratings = attempt_each(batch, lambda shape: scores.reversibility.reversibility(shape, settings), errors)
    counts = [0 if rating is None else len(rating.necks) for rating in ratings]
    present = [rating for rating in ratings if rating is not None]
    arrays = {
        name: np.array([math.nan if rating is None else getattr(rating, name) for rating in ratings], dtype=np.float64)
        for name in ("score", "s1", "s2", "waist")
    }
    arrays["neck_offsets"] = np.concatenate([np.zeros(1, np.int64), np.cumsum(counts, dtype=np.int64)])
    arrays["necks"] = np.concatenate([np.empty((0, 2), np.int64), *(rating.necks for rating in present)])
    arrays["neck_ratio"] = np.concatenate([np.empty(0), *(rating.neck_ratio for rating in present)])
    return Artifact(arrays, {"errors": errors})


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each batch."""
    return after_each(progress, "reversibility", "ingest")


def _scores(artifact: Artifact) -> Mapping[str, Any]:
    columns = {name: artifact.arrays[name] for name in ("score", "s1", "s2", "waist")}
    return {**columns, "necks": np.diff(artifact.arrays["neck_offsets"])}


STAGE = Stage(
    name="reversibility",
    unit="batches of shapes",
    after=("ingest",),
    parameters=("reversibility",),
    items=items,
    run=run,
    scope="batch",
    bundle=16,
    tables=(
        TableColumns(
            "reversibility",
            (
                Column("score", "float64", "S_r = min(s1, s2)", "score in [0, 1]"),
                Column("s1", "float64", "of the perimeter, equation 9", "score in [0, 1]"),
                Column("s2", "float64", "of the waists, equation 10", "score in [0, 1]"),
                Column("waist", "float64", "largest neck ratio among the waists, nan without a waist", "1"),
                Column("necks", "int32", "necks found", "count"),
            ),
            _scores,
            "Reversibility score of every shape (paper §5.1); nan where it could not be computed.",
        ),
    ),
)
