"""Rows of a block of pairs: between two groups of batches, batch by batch, and of one group with itself (ours).

A collection that has grown is cut into other groups. What an older block has of two batches is taken from there: a
pair's score depends on its two shapes alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.errors import PayloadError
from pipeline.plan.sub_block import Sides
from pipeline.store.artifact import AnyArray, Artifact
from riot.types import IntArray

Columns = Mapping[str, AnyArray]

STARTS = ("row_starts", "column_starts")
"""In a block's artifact: the numbers of the first rows of its batches, and of the first columns; at last, of all."""


@dataclass(frozen=True)
class Reused:
    """Rows of two batches in an older block: the numbers of the batches here, the input that is the block, and the
    numbers of the batches there."""

    here: tuple[int, int]
    block: int
    there: tuple[int, int]


@dataclass(frozen=True)
class ReusingBlock:
    """A block of which older blocks have something. They are no part of its key, as they change no result."""

    sides: Sides
    reused: tuple[Reused, ...]


def block_rows(
    inputs: Sequence[Any], spec: Sides | ReusingBlock, score: Callable[[Any, Any, bool], Columns]
) -> Artifact:
    """Rows of all pairs of a block, by batch; i and j are local to its sides. Inputs are read as they are needed.

    ``score`` makes the rows of two inputs, the last argument says whether of one with itself, i and j local to them.
    """
    sides, reused = (spec.sides, spec.reused) if isinstance(spec, ReusingBlock) else (spec, ())
    first, second = sides.numbers
    starts = side_starts(inputs, sides)
    of_rows, of_columns = starts.values()
    older = {piece.here: piece for piece in reused}
    pieces: list[dict[str, AnyArray]] = []
    for a, row in enumerate(first):
        for b, column in enumerate(second):
            if sides.same and b < a:
                continue
            columns = _older(inputs, older.get((a, b))) or score(inputs[row], inputs[column], row == column)
            pieces.append({**columns, "i": columns["i"] + of_rows[a], "j": columns["j"] + of_columns[b]})
    rows = {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}
    rows |= {name: rows[name].astype(np.int32) for name in ("i", "j")}
    return Artifact({**rows, **starts})


def side_starts(inputs: Sequence[Any], sides: Sides) -> dict[str, IntArray]:
    """The arrays `STARTS` of a block."""
    lengths = ([0, *(len(inputs[number]) for number in side)] for side in sides.numbers)
    return {name: np.cumsum(counts, dtype=np.int64) for name, counts in zip(STARTS, lengths, strict=True)}


def ordered(artifact: Artifact) -> Artifact:
    """The same with rows ordered by (i, j)."""
    order = np.lexsort((artifact.arrays["j"], artifact.arrays["i"]))
    return Artifact(
        {name: array if name in STARTS else array[order] for name, array in artifact.arrays.items()}, artifact.document
    )


def is_block(artifact: Artifact) -> bool:
    """Whether an artifact is a block, and not a batch."""
    return STARTS[0] in artifact.arrays


def _older(inputs: Sequence[Any], piece: Reused | None) -> Columns | None:
    """The rows of two batches in an older block, i and j local to the batches; None if it cannot be read any more."""
    if piece is None:
        return None
    try:
        arrays = inputs[piece.block].arrays
    except (KeyError, OSError, PayloadError):
        return None
    spans = [arrays[name][number : number + 2].tolist() for name, number in zip(STARTS, piece.there, strict=True)]
    inside = _within(arrays["i"], *spans[0]) & _within(arrays["j"], *spans[1])
    rows = {name: array[inside] for name, array in arrays.items() if name not in STARTS}
    return {**rows, "i": rows["i"] - spans[0][0], "j": rows["j"] - spans[1][0]}


def _within(numbers: IntArray, low: int, high: int) -> Any:
    return (numbers >= low) & (numbers < high)
