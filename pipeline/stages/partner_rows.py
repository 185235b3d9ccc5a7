"""Rows of searches for partners: the best of each shape, and how good the last of them is (ours)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pipeline.plan.sub_block import SubBlock
from pipeline.stages.qcrs import COLUMNS
from pipeline.store.artifact import AnyArray, Artifact
from riot.types import FloatArray, IntArray

Rows = Mapping[str, AnyArray]
"""Pairs of a shape i that is searched for and a partner j, by column; some functions need i and score only."""

NONE_KNOWN: Rows = {"i": np.empty(0, np.int32), "score": np.empty(0)}
"""No partners."""

SEARCHED = {"searched": np.int32, "least": np.float64}
"""Of an exact search, by name, the types of what it says of each shape that was searched for: its number, and the score
of the last of its best partners that are known then, 0 where there are fewer. No other partner scores more."""

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
    columns = {name: column[order] for name, column in rows.items()}
    columns["promising"] = promising[np.argsort(promising[:, 0], kind="stable")]
    if all(SEARCHED.keys() <= artifact.arrays.keys() for artifact in artifacts):
        known = [{name: np.empty(0, kind) for name, kind in SEARCHED.items()}, *(a.arrays for a in artifacts)]
        searched = {name: np.concatenate([arrays[name] for arrays in known]) for name in SEARCHED}
        by_shape = np.argsort(searched["searched"], kind="stable")
        columns |= {name: array[by_shape] for name, array in searched.items()}
    return Artifact(columns)


def counting(found: Artifact, searched: IntArray, known: Rows, shapes: int, count: int) -> Artifact:
    """The rows of an exact search for the shapes ``searched``, of ``shapes``, that count beside the ``known`` ones.

    A partner counts that scores no less than the last of the ``count`` best of the known ones and of those found.
    Therefore the rows do not depend on how they were found, and whoever has them knows what all others are below.
    """
    least = last_of_best([known, found.arrays], shapes, count)
    rows = not_below({name: found.arrays[name] for name in COLUMNS}, least)
    rows |= {"promising": np.empty((0, 2), np.int32), "searched": searched.astype(np.int32), "least": least[searched]}
    return Artifact(rows, found.document)


def not_below(rows: Rows, least: FloatArray) -> dict[str, AnyArray]:
    """The rows that score no less than their shape's ``least`` (shapes,)."""
    good = rows["score"] >= least[rows["i"]]
    return {name: column[good] for name, column in rows.items()}


def last_of_best(pieces: Sequence[Rows], shapes: int, count: int) -> FloatArray:
    """`worst_of_best` of several pieces together, whose rows are in any order."""
    i, score = (np.concatenate([piece[name] for piece in pieces]) for name in ("i", "score"))
    order = np.lexsort((-score, i))
    return worst_of_best(i[order], score[order], shapes, count)


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
