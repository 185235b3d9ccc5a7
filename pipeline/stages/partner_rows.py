"""Rows of searches for partners: the best of each shape, and how good the last of them is (ours)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pipeline.plan.sub_block import SubBlock
from pipeline.stages.qcrs import COLUMNS
from pipeline.store.artifact import Artifact
from riot.types import FloatArray, IntArray

TYPES = {"score": np.float64, "n": np.int8, "shift": np.int8}
"""Types of columns; the others are int32."""


def best_rows(columns: Mapping[str, Any], count: int) -> dict[str, Any]:
    """The ``count`` best rows of each i that score above 0, best first, and among equals by j."""
    order = np.lexsort((columns["j"], -columns["score"], columns["i"]))
    i = columns["i"][order]
    order = order[(np.arange(len(i)) - np.searchsorted(i, i) < count) & (columns["score"][order] > 0)]
    return {name: columns[name][order].astype(TYPES.get(name, np.int32)) for name in COLUMNS}


def join(artifacts: Sequence[Artifact], lost: Sequence[SubBlock] = ()) -> Artifact:
    """The artifact of a query from those of some of its shapes each, in any order; ``lost`` shapes have no rows."""
    empty = {name: np.empty(0, TYPES.get(name, np.int32)) for name in COLUMNS}
    pieces = [{**empty, "promising": np.empty((0, 2), np.int32)}, *(artifact.arrays for artifact in artifacts)]
    rows = {name: np.concatenate([arrays[name] for arrays in pieces]) for name in pieces[0]}
    order = np.argsort(rows["i"], kind="stable")  # all rows of an i are in one artifact, the best first
    promising = rows.pop("promising")
    compared = sum(int(artifact.document["compared"]) for artifact in artifacts)
    columns = {name: column[order] for name, column in rows.items()}
    in_order = promising[np.argsort(promising[:, 0], kind="stable")]
    return Artifact({**columns, "promising": in_order}, {"compared": compared})


def worst_of_best(i: IntArray, score: FloatArray, shapes: int, count: int) -> FloatArray:
    """(shapes,) the score of each shape's partner number ``count``; 0 for a shape that has fewer.

    ``i`` ascends, and each i's scores descend.

    >>> worst_of_best(np.array([0, 0, 2]), np.array([0.9, 0.8, 0.7]), 3, 2).tolist()
    [0.8, 0.0, 0.0]
    """
    last = np.searchsorted(i, np.arange(shapes)) + count - 1
    enough = last < np.searchsorted(i, np.arange(shapes), side="right")
    least = np.zeros(shapes)
    least[enough] = score[last[enough]]
    return least
