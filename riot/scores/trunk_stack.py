"""The trunks of many shapes in one set of arrays, as QCRS compares them (paper §5.2; layout ours)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from riot.kernels.bounds import CORNER_VALUES, FEATURES, QCRS_LEAF, TILE_LEAVES
from riot.kernels.forest import Forest
from riot.kernels.leaves import facing, features, lay_out
from riot.scores.leaves import gather_leaves
from riot.scores.ragged import joined, joined_offsets, running
from riot.scores.trunks import Trunks
from riot.types import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class TrunkStack:
    """The trunks of many shapes, concatenated.

    Parameters
    ----------
    starts : (shapes + 1,) int64
        Offsets of every shape's trunks.
    offsets : (t + 1,) int64
        Offsets of every trunk's corners in the following three.
    edges, alphas, betas : (s,) float64
        Edge lengths, trunk angles α, and β = 2π − θ − α.
    areas : (t,) float64
        Trunk areas; within a shape ordered by (n, area).
    leaf_starts : (shapes + 1,) int64
        Offsets of every shape's leaves.
    leaves : (l, 16) int32
        Similar trunks of one n, numbered within their shapes, in order of n (`riot.kernels.leaves`): the search goes
        through them. They decide how long it takes, and nothing else.
    """

    starts: IntArray
    offsets: IntArray
    edges: FloatArray
    alphas: FloatArray
    betas: FloatArray
    areas: FloatArray
    leaf_starts: IntArray
    leaves: npt.NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.starts) - 1

    def shape(self, number: int) -> TrunkStack:
        """The trunks of one shape, as a stack."""
        low, high = self.starts[number], self.starts[number + 1]
        first, last = self.offsets[low], self.offsets[high]
        leaves = self.leaves[self.leaf_starts[number] : self.leaf_starts[number + 1]]
        return TrunkStack(
            np.array([0, high - low], dtype=np.int64),
            self.offsets[low : high + 1] - first,
            self.edges[first:last].copy(),
            self.alphas[first:last].copy(),
            self.betas[first:last].copy(),
            self.areas[low:high].copy(),
            np.array([0, len(leaves)], dtype=np.int64),
            leaves.copy(),
        )

    @cached_property
    def shapes(self) -> tuple[TrunkStack, ...]:
        """Every shape's trunks, as a stack, which keeps what is laid out of it."""
        return tuple(self.shape(number) for number in range(len(self)))

    @cached_property
    def forest(self) -> Forest:
        """These trunks, laid out for the search."""
        if not self.edges.flags.writeable:
            # Copies: the kernels that lay out would compile a second time for read-only arrays.
            return replace(self, **{name: np.array(array) for name, array in self.to_arrays().items()}).forest
        shape = np.repeat(np.arange(len(self)), np.diff(self.leaf_starts))
        trunks = (self.leaves + self.starts[shape, None]).astype(np.int32)
        n = np.diff(self.offsets)[trunks[:, 0]]
        new = np.ones(len(n), dtype=bool)
        new[1:] = (n[1:] != n[:-1]) | (shape[1:] != shape[:-1])
        first = np.flatnonzero(new)
        groups = np.searchsorted(shape[first], np.arange(len(self) + 1))
        return lay_out_forest(self, trunks, np.append(first, len(n)), groups)

    @cached_property
    def extremes(self) -> tuple[float, float, int]:
        """The longest edge, the greatest alpha or beta without its sign, and the greatest n."""
        edge, alpha, beta = (
            float(max(values.max(initial=0.0), -values.min(initial=0.0)))
            for values in (self.edges, self.alphas, self.betas)
        )
        return edge, max(alpha, beta), int(np.diff(self.offsets).max(initial=3))

    def to_arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Plain arrays by field name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, npt.NDArray[Any]]) -> TrunkStack:
        """Undo `to_arrays`."""
        return cls(**{field.name: arrays[field.name] for field in fields(cls)})


def stack(trunks: Sequence[Trunks], leaves: Sequence[npt.NDArray[np.int32]] | None = None) -> TrunkStack:
    """Concatenate the trunks of several shapes; without ``leaves`` they are gathered by `gather_leaves`.

    >>> from riot.scores.trunks import quick_trunks
    >>> len(stack([quick_trunks(house), quick_trunks(kite)]))
    2
    """
    leaves = [gather_leaves(shape_trunks) for shape_trunks in trunks] if leaves is None else leaves
    return TrunkStack(
        starts=running(np.array([len(shape_trunks) for shape_trunks in trunks], dtype=np.int64)),
        offsets=joined_offsets([shape_trunks.offsets for shape_trunks in trunks]),
        edges=joined(trunks, "edges"),
        alphas=joined(trunks, "alphas"),
        betas=joined(trunks, "betas"),
        areas=joined(trunks, "areas"),
        leaf_starts=running(np.array([len(shape_leaves) for shape_leaves in leaves], dtype=np.int64)),
        leaves=np.concatenate([np.empty((0, QCRS_LEAF), np.int32), *leaves]),
    )


def of_sizes(trunks: TrunkStack, least: int, most: int) -> TrunkStack:
    """The trunks with ``least`` to ``most`` vertices, in the same order and the same leaves.

    >>> from riot.scores.trunks import quick_trunks
    >>> np.unique(np.diff(of_sizes(stack([quick_trunks(house)]), 3, 3).offsets)).tolist()
    [3]
    """
    sizes = np.diff(trunks.offsets)
    kept = (sizes >= least) & (sizes <= most)
    of_kept = np.repeat(kept, sizes)
    before = running(kept)  # of each trunk, how many kept ones come earlier
    # A leaf has trunks of one n, numbered within their shape.
    first = np.repeat(trunks.starts[:-1], np.diff(trunks.leaf_starts))
    kept_leaves = kept[trunks.leaves[:, 0] + first]
    first = first[kept_leaves, None]
    return TrunkStack(
        starts=before[trunks.starts],
        offsets=running(sizes[kept]),
        edges=trunks.edges[of_kept],
        alphas=trunks.alphas[of_kept],
        betas=trunks.betas[of_kept],
        areas=trunks.areas[kept],
        leaf_starts=running(kept_leaves)[trunks.leaf_starts],
        leaves=(before[trunks.leaves[kept_leaves] + first] - before[first]).astype(np.int32),
    )


def of_trunks(trunks: TrunkStack, kept: npt.NDArray[np.bool_]) -> TrunkStack:
    """The trunks of which ``kept`` (t,) is true, numbered anew within their shapes; not gathered into leaves.

    >>> from riot.scores.trunks import quick_trunks
    >>> houses = stack([quick_trunks(house)])
    >>> len(of_trunks(houses, houses.areas > np.median(houses.areas)).areas) < len(houses.areas)
    True
    """
    sizes = np.diff(trunks.offsets)
    corners = np.repeat(kept, sizes)
    return TrunkStack(
        starts=running(kept)[trunks.starts],
        offsets=running(sizes[kept]),
        edges=trunks.edges[corners],
        alphas=trunks.alphas[corners],
        betas=trunks.betas[corners],
        areas=trunks.areas[kept],
        leaf_starts=np.zeros(len(trunks) + 1, dtype=np.int64),
        leaves=np.empty((0, QCRS_LEAF), np.int32),
    )


def lay_out_forest(
    trunks: TrunkStack, leaves: npt.NDArray[np.int32], first: npt.NDArray[Any], groups: npt.NDArray[Any]
) -> Forest:
    """Lay out trunks for the search.

    ``leaves`` (l, 16) are numbers among all trunks, ``first`` (g + 1,) the first leaf of each group of one n,
    ``groups`` the first group of each shape or cell.
    """
    n = np.diff(trunks.offsets)[leaves[:, 0]]
    counts, sizes = np.diff(first), n[first[:-1]]
    tiles, begins = running(-(-counts // TILE_LEAVES)), running(counts * QCRS_LEAF * CORNER_VALUES * sizes)
    values = features(trunks.offsets, trunks.edges, trunks.alphas, trunks.betas, trunks.areas)
    laid = np.empty((len(n), FEATURES, QCRS_LEAF), dtype=np.float32)
    boxes = np.zeros((int(tiles[-1]), 2 * FEATURES, TILE_LEAVES), dtype=np.float32)
    lay_out(leaves, first.astype(np.int64), tiles, values, laid, boxes)
    del values
    corners = np.empty(int(begins[-1]), dtype=np.float32)
    facing(
        leaves,
        running(QCRS_LEAF * CORNER_VALUES * n),
        trunks.offsets,
        trunks.edges,
        trunks.alphas,
        trunks.betas,
        corners,
    )
    forest = Forest(
        groups=groups.astype(np.int64),
        sizes=sizes,
        leaves=first.astype(np.int64),
        tiles=tiles,
        begins=begins,
        trunks=leaves,
        features=laid,
        boxes=boxes,
        facing=corners,
        starts=trunks.starts,
        offsets=trunks.offsets,
        edges=trunks.edges,
        alphas=trunks.alphas,
        betas=trunks.betas,
        areas=trunks.areas,
    )
    return read_only(forest)


def read_only(forest: Forest) -> Forest:
    """The same forest by read-only views: compiled kernels know one type of forest, that of a mapped file."""
    views = {name: array.view() for name, array in forest._asdict().items()}
    for view in views.values():
        view.flags.writeable = False
    return Forest(**views)
