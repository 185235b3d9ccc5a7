"""What the stage ``near_duplicates`` knows of a collection: clusters, which pairs are alike, and surprise (ours)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipeline.store.artifact import AnyArray
from riot import scores
from riot.parameters import LikenessParameters
from riot.types import FloatArray, IntArray

if TYPE_CHECKING:
    from riot.scores.likeness import DescriptorIndex


@dataclass(frozen=True, eq=False)
class Collected:
    """The descriptors of a collection of shapes.

    Parameters
    ----------
    index : DescriptorIndex
    number : (positions,) int64
        A shape's place in the index; −1 where it has no descriptor.
    cluster : (positions,) int64
        The first position of a shape's cluster of near-duplicates: its own where it has no descriptor.
    elongation : (d,) float64
        Of each shape of the index.
    perimeter : (positions,) float64
        Of each shape of unit area; the greatest of all where it has no descriptor.
    """

    index: DescriptorIndex
    number: IntArray
    cluster: IntArray
    elongation: FloatArray
    perimeter: FloatArray

    @classmethod
    def of(cls, things: Mapping[str, AnyArray], count: int) -> Collected:
        """A collection of ``count`` positions from the stage's arrays; without arrays no shape has a descriptor."""
        number, cluster = np.full(count, -1, dtype=np.int64), np.arange(count)
        if not things:
            return cls(scores.likeness.DescriptorIndex.build([]), number, cluster, np.empty(0), np.zeros(count))
        number[things["positions"]] = np.arange(len(things["positions"]))
        cluster[things["positions"]] = things["cluster"]
        perimeter = np.full(count, np.max(things["perimeter"], initial=0.0))
        perimeter[things["positions"]] = things["perimeter"]
        index = scores.likeness.DescriptorIndex.from_arrays(things)
        return cls(index, number, cluster, np.asarray(things["elongation"]), perimeter)

    def surprise(self, i: IntArray, j: IntArray, *, mirrored: bool) -> FloatArray:
        """(k,) surprise of the pairs (i, j) of positions; 0 where one has no descriptor. About 5 µs each."""
        surprise = np.zeros(len(i))
        a, b = self.number[i], self.number[j]
        order = np.argsort(a, kind="stable")
        order = order[np.minimum(a, b)[order] >= 0]
        for rows in np.split(order, np.flatnonzero(np.diff(a[order])) + 1):
            if len(rows):
                distance = self._distances(int(a[rows[0]]), b[rows], mirrored)
                surprise[rows] = scores.surprise.surprise(distance, self.elongation[a[rows]], self.elongation[b[rows]])
        return surprise

    def distinct(self, pairs: IntArray, worth: FloatArray, likeness: LikenessParameters) -> IntArray:
        """Rows, ascending, of the pairs (k, 2) of which none that is worth as much or more is a near-duplicate.

        Two pairs are near-duplicates if each shape of the one is a near-duplicate of a shape of the other. Among equals
        the first counts.
        """
        kept: dict[tuple[int, int], list[int]] = defaultdict(list)
        for row in np.argsort(-worth, kind="stable").tolist():
            # Near-duplicates are in one cluster, whose shapes need not all be near-duplicates of one another.
            i, j = sorted(pairs[row].tolist(), key=lambda position: int(self.cluster[position]))
            others = kept[int(self.cluster[i]), int(self.cluster[j])]
            if not any(self._alike((i, j), pairs[other].tolist(), likeness) for other in others):
                others.append(row)
        return np.array(sorted(row for rows in kept.values() for row in rows), dtype=np.int64)

    def _alike(self, pair: tuple[int, int], other: Sequence[int], likeness: LikenessParameters) -> bool:
        return any(
            all(self._near(one, another, likeness) for one, another in zip(pair, turned, strict=True))
            for turned in (other, other[::-1])
        )

    def _near(self, one: int, another: int, likeness: LikenessParameters) -> bool:
        if one == another:
            return True
        if self.cluster[one] != self.cluster[another]:
            return False
        numbers = self.number[[another]]
        distance = self._distances(int(self.number[one]), numbers, likeness.mirrored)
        return bool(distance[0] <= likeness.near_duplicate)

    def _distances(self, number: int, others: IntArray, mirrored: bool) -> FloatArray:
        index = self.index
        return index.subset(others).distances(index.descriptor(number), mirrored=mirrored)
