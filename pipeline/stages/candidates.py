"""Candidates of the selection: which pairs may be selected, read block by block, or part by part (ours)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from pipeline.stages.collected import Collected
from pipeline.stages.policies import labels
from pipeline.stages.pool import Rows
from pipeline.stages.wishes import WishedShapes
from pipeline.store.artifact import AnyArray, Artifact
from pipeline.store.keys import digest_array, digest_text
from riot.types import BoolArray, FloatArray, IntArray

Starts = Sequence[tuple[int, int]]
"""For every input, the numbers of its first row and column among the shapes."""


@dataclass(frozen=True, eq=False)
class Shapes:
    """What decides, by the shapes alone, whether a pair may be selected: arrays (shapes,).

    Shapes of a class have one number in ``label``. Of ``wishes``, uint8, bit 0 says that a shape may be in a pair, the
    others which wished groups it is in; of each bit of ``needed`` a pair has one.
    """

    label: IntArray
    wishes: npt.NDArray[np.uint8]
    needed: int

    @classmethod
    def of(cls, classes: Sequence[str], wished: WishedShapes) -> Shapes:
        """Those of a collection."""
        wishes = np.ones(len(classes), dtype=np.uint8)
        wishes[list(wished.excluded)] = 0
        for number, group in enumerate(wished.groups, start=1):
            wishes[list(group)] |= np.uint8(1 << number)
        return cls(labels(classes), wishes, sum(2 << number for number in range(len(wished.groups))))

    def only(self, may: BoolArray) -> Shapes:
        """The same, of which no others may be in a pair."""
        return replace(self, wishes=self.wishes & np.where(may, 255, 254).astype(np.uint8))

    def at(self, first: range, second: range) -> Shapes:
        """Those of both sides of a part, one after the other; of one side where both are the same."""
        sides = [slice(side.start, side.stop) for side in dict.fromkeys((first, second))]
        label, wishes = (np.concatenate([array[side] for side in sides]) for array in (self.label, self.wishes))
        return Shapes(label, wishes, self.needed)

    def digest(self) -> str:
        """A digest that does not depend on the other shapes of the collection."""
        _, first, number = np.unique(self.label, return_index=True, return_inverse=True)
        return digest_text(digest_array(first[number]) + digest_array(self.wishes) + str(self.needed))

    def admit(self, i: IntArray, j: IntArray) -> BoolArray:
        """Whether pairs may be selected: shapes of different classes, and as the user wishes."""
        first, second = self.wishes[i], self.wishes[j]
        wished = (first & second & 1 != 0) & ((first | second) & self.needed == self.needed)
        return np.asarray(wished & (self.label[i] != self.label[j]))


@dataclass(frozen=True, eq=False)
class Surprise:
    """The surprise of pairs, of which shape k has ``positions[k]`` in what is ``collected``."""

    collected: Collected
    positions: IntArray
    least: float
    mirrored: bool

    def admit(self, rows: Rows) -> Rows:
        """The pairs that differ enough."""
        i, j = self.positions[rows.i], self.positions[rows.j]
        return rows.at(self.collected.surprise(i, j, mirrored=self.mirrored) >= self.least)


def candidates(
    starts: Starts,
    artifacts: Sequence[Artifact],
    shapes: Shapes,
    pieces: Sequence[int] = (),
    surprise: Surprise | None = None,
) -> Iterator[Rows]:
    """The pairs of some blocks that may be selected, one block at a time: all of them do not fit in memory.

    They have a score above 0, trunks of so many ``pieces``, if any are given, and ``surprise``.
    """
    for rows in read_rows(starts, artifacts):
        rows = rows.at((rows.score > 0) & shapes.admit(rows.i, rows.j))
        if pieces:
            rows = rows.at(np.isin(rows.n, pieces))
        yield rows if surprise is None else surprise.admit(rows)


def read_rows(starts: Starts, artifacts: Sequence[Artifact]) -> Iterator[Rows]:
    """All pairs of some inputs, one input at a time."""
    for (first, second), artifact in zip(starts, artifacts, strict=True):
        arrays = artifact.arrays
        i, j = (arrays[name].astype(np.int64) + start for name, start in (("i", first), ("j", second)))
        yield Rows(i, j, np.asarray(arrays["score"]), arrays["n"].astype(np.int64))


def qcrs_of(i: IntArray, j: IntArray, starts: Starts, artifacts: Sequence[Artifact]) -> FloatArray:
    """(k,) QCRS of the pairs (i, j), looked up in blocks or in parts; 0 where none has the pair.

    A pair enters the pool by its trunks of one n, which may score less.
    """
    score = np.zeros(len(i))
    if len(i) == 0:
        return score
    most = int(j.max()) + 1
    key = i * most + j
    order = np.argsort(key)
    pairs, first = np.unique(key[order], return_index=True)
    found = np.zeros(len(pairs))
    for (row, column), artifact in zip(starts, artifacts, strict=True):
        arrays: Mapping[str, AnyArray] = artifact.arrays
        second = arrays["j"].astype(np.int64) + column
        here = (arrays["i"].astype(np.int64) + row) * most + second
        here[second >= most] = -1
        at = np.minimum(np.searchsorted(pairs, here), len(pairs) - 1)
        same = np.flatnonzero(pairs[at] == here)
        found[at[same]] = arrays["qcrs" if "qcrs" in arrays else "score"][same]
    score[order] = np.repeat(found, np.diff(np.append(first, len(key))))
    return score
