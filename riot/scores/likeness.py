"""Likeness of shapes: a distance between descriptors, an index of them, near-duplicates, and margins. Ours.

The distance is a metric of descriptors: it compares the outlines at the best cyclic shift of their samples and the
regions at the best rotation. Both searches are exact, over all shifts, by cross-correlation of spectra (Fourier).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from riot.scores.descriptor import (
    CHANNELS,
    OUTLINE_FREQUENCIES,
    REGION_FREQUENCIES,
    RINGS,
    ComplexArray,
    Descriptor,
)
from riot.types import FloatArray, IntArray

OUTLINE_SHIFTS, REGION_SHIFTS = 256, 64
"""Cyclic shifts of an outline, by arc length, and of a region, by angle, that are compared. Ours: twice as many shifts
of the outline as it has samples halve what a moved start changes."""

REGION_WEIGHT = 0.2
"""Weight of the region against the outline. Ours: recognition of MPEG-7 hardly changes from .1 to .3."""


@dataclass(frozen=True)
class Margin:
    """How much nearer a result is to its input than to the nearest other thing of a collection.

    Parameters
    ----------
    value : float
        1 − distance to the input / distance to the nearest other; 1 is perfect, ≤ 0 is mistaken for something else;
        nan if the collection has no other thing.
    nearest : int
        Number of the nearest other shape in the index; −1 without one.
    recognised : bool
        Whether the nearest shape but the input is the same thing; of an input that is alone, whether the value is
        above 0.
    """

    value: float
    nearest: int
    recognised: bool


@dataclass(frozen=True, eq=False)
class DescriptorIndex:
    """Descriptors of a collection, stacked for search.

    Parameters
    ----------
    outline, region : (k, 11, 17), (k, 8, 13) complex128
        The fields of the descriptors.
    """

    outline: ComplexArray
    region: ComplexArray

    def __len__(self) -> int:
        return len(self.outline)

    @classmethod
    def array_names(cls) -> tuple[str, ...]:
        """The names of the arrays that `to_arrays` gives."""
        return tuple(field.name for field in fields(cls))

    def to_arrays(self) -> dict[str, FloatArray]:
        """Plain arrays by name, for storage: real and imaginary parts along one more axis."""
        spectra = {name: getattr(self, name) for name in self.array_names()}
        return {name: np.stack([values.real, values.imag], axis=-1) for name, values in spectra.items()}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, npt.NDArray[Any]]) -> DescriptorIndex:
        """Undo `to_arrays`."""
        return cls(*(arrays[name][..., 0] + 1j * arrays[name][..., 1] for name in cls.array_names()))

    @classmethod
    def build(cls, descriptors: Sequence[Descriptor]) -> DescriptorIndex:
        """Stack descriptors, numbered in their order.

        >>> from riot.scores.descriptor import descriptor
        >>> len(DescriptorIndex.build([descriptor(house), descriptor(kite)]))
        2
        """
        outline = [item.outline for item in descriptors]
        region = [item.region for item in descriptors]
        return cls(
            np.array(outline, np.complex128).reshape(-1, CHANNELS, OUTLINE_FREQUENCIES),
            np.array(region, np.complex128).reshape(-1, RINGS, REGION_FREQUENCIES),
        )

    def descriptor(self, number: int) -> Descriptor:
        """The descriptor of this number."""
        return Descriptor(self.outline[number], self.region[number])

    def subset(self, numbers: IntArray) -> DescriptorIndex:
        """The index of these numbers, in their order."""
        return DescriptorIndex(self.outline[numbers], self.region[numbers])

    def distances(self, query: Descriptor, *, mirrored: bool = False) -> FloatArray:
        """(k,) `distance` of a descriptor to each of the index; 15 ms for 3,400.

        >>> from riot.scores.descriptor import descriptor
        >>> DescriptorIndex.build([descriptor(house), descriptor(kite)]).distances(descriptor(kite)).round(2).tolist()
        [0.27, 0.0]
        """
        outline = _least_distances(self.outline, query.outline, OUTLINE_SHIFTS, mirrored)
        return outline + REGION_WEIGHT * _least_distances(self.region, query.region, REGION_SHIFTS, mirrored)

    def nearest(
        self, query: Descriptor, count: int, *, exclude: Collection[int] = (), mirrored: bool = False
    ) -> tuple[IntArray, FloatArray]:
        """Numbers and distances of the ``count`` nearest, nearest first, among equals the lower number.

        ``exclude`` are numbers that do not count. Raises ValueError if ``count`` < 1.

        >>> from riot.scores.descriptor import descriptor
        >>> numbers, _ = DescriptorIndex.build([descriptor(house), descriptor(kite)]).nearest(descriptor(house), 1)
        >>> numbers.tolist()
        [0]
        """
        if count < 1:
            raise ValueError(f"nearest({count=}): ask for one shape at least")
        distances = self.distances(query, mirrored=mirrored)
        order = np.argsort(distances, kind="stable")
        order = order[~np.isin(order, np.array(list(exclude), dtype=np.int64))][:count]
        return order, distances[order]


def distance(a: Descriptor, b: Descriptor, *, mirrored: bool = False) -> float:
    """Distance of two descriptors: symmetric, 0 for the same outline, and it obeys the triangle inequality.

    Rotation and start vertex change it by no more than the resolution of the samples (on MPEG-7 by 0.01 in the median
    and 0.05 at most); with ``mirrored`` mirroring does not, either. Rounding leaves up to 1e-7 of a distance of 0.

    >>> from riot.scores.descriptor import descriptor
    >>> round(distance(descriptor(house), descriptor(kite)), 2)
    0.27
    """
    return float(DescriptorIndex.build([b]).distances(a, mirrored=mirrored)[0])


def margin(
    result: Descriptor, original: int, index: DescriptorIndex, groups: IntArray, *, mirrored: bool = False
) -> Margin:
    """How much nearer ``result`` is to its input, number ``original``, than to the nearest shape of another group.

    ``groups`` (k,) int64 are the things that the index shows: classes, or clusters of near-duplicates.

    >>> from riot.scores.descriptor import descriptor
    >>> index = DescriptorIndex.build([descriptor(house), descriptor(kite)])
    >>> recognised = margin(descriptor(house), 0, index, np.array([0, 1]))
    >>> round(recognised.value, 6), recognised.nearest
    (1.0, 1)
    """
    distances = index.distances(result, mirrored=mirrored)
    others = np.flatnonzero(groups != groups[original])
    if len(others) == 0:
        return Margin(float("nan"), -1, True)
    nearest = int(others[np.argmin(distances[others])])
    least = float(distances[nearest])
    same = groups == groups[original]
    same[original] = same.sum() == 1
    value = 1.0 - float(distances[original]) / least if least > 0 else float("-inf")
    return Margin(value, nearest, float(distances[same].min()) < least)


def near_duplicates(index: DescriptorIndex, threshold: float, *, mirrored: bool = False) -> IntArray:
    """(k,) the cluster of each shape, by the lowest number in it: chains of pairs at most ``threshold`` apart.

    Single linkage: the partition does not depend on the order of the shapes.

    >>> from riot.scores.descriptor import descriptor
    >>> near_duplicates(DescriptorIndex.build([descriptor(house), descriptor(kite), descriptor(house)]), 0.05).tolist()
    [0, 1, 0]
    """
    cluster = np.arange(len(index))
    # Shifts and mirroring change no amplitude, hence amplitudes bound the distance from below.
    amplitudes = [
        np.abs(spectra).reshape(len(index), spectra[:1].size or 1) * weight
        for spectra, weight in ((index.outline, 1.0), (index.region, REGION_WEIGHT))
    ]
    for number in range(len(index) - 1):
        bound = sum(np.sqrt(np.square(values[number + 1 :] - values[number]).sum(axis=1)) for values in amplitudes)
        candidates = number + 1 + np.flatnonzero(bound <= threshold)
        distances = index.subset(candidates).distances(index.descriptor(number), mirrored=mirrored)
        for near in candidates[distances <= threshold]:
            low, high = sorted((cluster[number], cluster[near]))
            cluster[cluster == high] = low
    return cluster


def _least_distances(spectra: ComplexArray, query: ComplexArray, shifts: int, mirrored: bool) -> FloatArray:
    """(k,) least L2 distance of the query to each of ``spectra`` over all cyclic shifts."""
    squares = (np.square(spectra.real) + np.square(spectra.imag)).sum(axis=(1, 2))
    most = np.full(len(spectra), -np.inf)
    # The channels of a mirrored shape are the shape's in reverse, whose spectrum is the conjugate.
    for other in (query, query.conj()) if mirrored else (query,):
        # Not by BLAS, whose sums depend on the number of rows and threads.
        products = np.einsum("kcf,cf->kf", spectra, other.conj())
        products[:, 1:] /= 2
        most = np.maximum(most, shifts * np.fft.irfft(products, shifts, axis=1).max(axis=1))
    own = np.square(query.real).sum() + np.square(query.imag).sum()
    least: Any = np.sqrt(np.maximum(squares + own - 2 * most, 0.0))
    return np.asarray(least, dtype=np.float64)
