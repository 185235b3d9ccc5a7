"""Likeness: a descriptor of a shape's outline and region, a distance between descriptors, and an index of them. Ours.

The distance is a metric of descriptors: it compares the outlines at the best cyclic shift of their samples and the
regions at the best rotation. Both searches are exact, over all shifts, by cross-correlation of spectra (Fourier).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from riot.content import ByContent
from riot.geometry.shape import Shape
from riot.types import FloatArray, IntArray

ComplexArray = npt.NDArray[np.complex128]

SAMPLES, ANGLES = 128, 64
"""Samples of the outline, by arc length, and rays of the region, by angle: so many shifts are compared."""

CHORDS, TRIANGLES = (4, 8, 16, 24, 32), (4, 8, 16, 24, 32, 48)
"""Distances along the outline, in samples, from a sample to both ends of its chord, and of its triangle."""

RINGS, REACH = 8, 2.0
"""Rings of the region around the centroid, and the radius of the last; the area of a shape is 1."""

OUTLINE_FREQUENCIES, REGION_FREQUENCIES = 17, 13
"""Frequencies kept of each spectrum: more change the recognition of MPEG-7 by less than .2 %."""

TRIANGLE_WEIGHT, REGION_WEIGHT = 0.7, 0.2
"""Weights of the triangles against the chords, and of the region against the outline. Ours: on MPEG-7 the rate of
recognition is flat around them (benchmarks/likeness.py)."""


@dataclass(frozen=True, eq=False)
class Descriptor(ByContent):
    """What the distance compares of a shape: spectra, scaled so that squares sum to mean squares.

    Parameters
    ----------
    outline : (11, 17) complex128
        Spectra along the outline of 5 lengths of chords and 6 areas of triangles, each divided by its maximum.
    region : (8, 13) complex128
        Spectra around the centroid of how much of each ring the shape covers.
    """

    outline: ComplexArray
    region: ComplexArray


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
    """

    value: float
    nearest: int


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
    def build(cls, descriptors: Sequence[Descriptor]) -> DescriptorIndex:
        """Stack descriptors, numbered in their order.

        >>> len(DescriptorIndex.build([descriptor(house), descriptor(kite)]))
        2
        """
        outline = [item.outline for item in descriptors]
        region = [item.region for item in descriptors]
        return cls(
            np.array(outline, np.complex128).reshape(-1, len(CHORDS) + len(TRIANGLES), OUTLINE_FREQUENCIES),
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

        >>> DescriptorIndex.build([descriptor(house), descriptor(kite)]).distances(descriptor(kite)).round(2).tolist()
        [0.27, 0.0]
        """
        outline = _least_distances(self.outline, query.outline, SAMPLES, mirrored)
        return outline + REGION_WEIGHT * _least_distances(self.region, query.region, ANGLES, mirrored)

    def nearest(
        self, query: Descriptor, count: int, *, exclude: Collection[int] = (), mirrored: bool = False
    ) -> tuple[IntArray, FloatArray]:
        """Numbers and distances of the ``count`` nearest, nearest first, among equals the lower number.

        ``exclude`` are numbers that do not count. Raises ValueError if ``count`` < 1.

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


def descriptor(shape: Shape) -> Descriptor:
    """Describe a shape; takes about a millisecond.

    The outline: chord lengths, and triangle areas after Alajlan et al., "Shape retrieval using triangle-area
    representation and dynamic space warping" (2007), both divided by the shape's maximum. The region: coverage of
    rings, whose squared difference is the area of the symmetric difference when rings and rays are fine.

    >>> descriptor(house).outline.shape, descriptor(house).region.shape
    ((11, 17), (8, 13))
    """
    return Descriptor(
        _spectrum(_outline_channels(_resampled(shape.points)), OUTLINE_FREQUENCIES),
        _spectrum(_ring_coverage(shape.points), REGION_FREQUENCIES),
    )


def distance(a: Descriptor, b: Descriptor, *, mirrored: bool = False) -> float:
    """Distance of two descriptors: symmetric, 0 for the same outline, and it obeys the triangle inequality.

    Rotation and start vertex change it by no more than the resolution of the samples (on MPEG-7 by 0.01 in the median
    and 0.04 at most); with ``mirrored`` mirroring does not, either. Rounding leaves up to 1e-7 of a distance of 0.

    >>> round(distance(descriptor(house), descriptor(kite)), 2)
    0.27
    """
    return float(DescriptorIndex.build([b]).distances(a, mirrored=mirrored)[0])


def margin(
    result: Descriptor, original: int, index: DescriptorIndex, groups: IntArray, *, mirrored: bool = False
) -> Margin:
    """How much nearer ``result`` is to its input, number ``original``, than to the nearest shape of another group.

    ``groups`` (k,) int64 are the things that the index shows: classes, or clusters of near-duplicates.

    >>> index = DescriptorIndex.build([descriptor(house), descriptor(kite)])
    >>> recognised = margin(descriptor(house), 0, index, np.array([0, 1]))
    >>> round(recognised.value, 6), recognised.nearest
    (1.0, 1)
    """
    distances = index.distances(result, mirrored=mirrored)
    others = np.flatnonzero(groups != groups[original])
    if len(others) == 0:
        return Margin(float("nan"), -1)
    nearest = int(others[np.argmin(distances[others])])
    least = float(distances[nearest])
    return Margin(1.0 - float(distances[original]) / least if least > 0 else float("-inf"), nearest)


def near_duplicates(index: DescriptorIndex, threshold: float, *, mirrored: bool = False) -> IntArray:
    """(k,) the cluster of each shape, by the lowest number in it: chains of pairs at most ``threshold`` apart.

    Single linkage: the partition does not depend on the order of the shapes.

    >>> near_duplicates(DescriptorIndex.build([descriptor(house), descriptor(kite), descriptor(house)]), 0.05).tolist()
    [0, 1, 0]
    """
    cluster = np.arange(len(index))
    # Shifts and mirroring change no amplitude, so that amplitudes bound the distance from below.
    amplitudes = [
        np.abs(spectra).reshape(len(index), -1) * weight
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


def _spectrum(channels: FloatArray, frequencies: int) -> ComplexArray:
    """(c, f) complex spectra of real channels (c, m), whose squares sum to the mean square of the kept frequencies."""
    spectra = np.fft.rfft(channels, axis=1)[:, :frequencies] / channels.shape[1]
    spectra[:, 1:] *= np.sqrt(2)
    return np.asarray(spectra, dtype=np.complex128)


def _resampled(points: FloatArray) -> FloatArray:
    """(SAMPLES, 2) points of equal distance along the outline, from its first point."""
    closed = np.vstack([points, points[:1]])
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
    at = np.arange(SAMPLES) * (lengths[-1] / SAMPLES)
    return np.column_stack([np.interp(at, lengths, closed[:, axis]) for axis in (0, 1)])


def _outline_channels(samples: FloatArray) -> FloatArray:
    """(11, SAMPLES) chord lengths and triangle areas, scaled so that mean squares of a kind weigh as one channel."""
    chords = [
        np.linalg.norm(np.roll(samples, -step, axis=0) - np.roll(samples, step, axis=0), axis=1) for step in CHORDS
    ]
    areas = []
    for step in TRIANGLES:
        before, after = np.roll(samples, step, axis=0) - samples, np.roll(samples, -step, axis=0) - samples
        areas.append(after[:, 0] * before[:, 1] - after[:, 1] * before[:, 0])
    scaled = [np.stack(channels) for channels in (chords, areas)]
    for channels in scaled:
        channels /= np.maximum(np.abs(channels).max(axis=1, keepdims=True), 1e-9) * np.sqrt(len(channels))
    return np.concatenate([scaled[0], TRIANGLE_WEIGHT * scaled[1]])


def _ring_coverage(points: FloatArray) -> FloatArray:
    """(RINGS, ANGLES) share of each cell of rings and rays in the shape, times the root of the ring's area."""
    angle = np.arange(ANGLES) * (2 * np.pi / ANGLES)
    ray = np.column_stack([np.cos(angle), np.sin(angle)])
    # Of each point, by ray: how far to the right of the ray it lies, and how far along.
    right = np.outer(ray[:, 1], points[:, 0]) - np.outer(ray[:, 0], points[:, 1])
    along = np.outer(ray[:, 0], points[:, 0]) + np.outer(ray[:, 1], points[:, 1])
    right_next, along_next = np.roll(right, -1, axis=1), np.roll(along, -1, axis=1)
    rays, edges = np.nonzero((right > 0) != (right_next > 0))
    at, at_next = right[rays, edges], right_next[rays, edges]
    radius = along[rays, edges] + (along_next[rays, edges] - along[rays, edges]) * at / (at - at_next)
    # Crossing a counter-clockwise outline from right to left leaves the shape, so signs count what lies before.
    sign = np.where(at > 0, 1.0, -1.0) * (radius > 0)
    circles = np.linspace(0.0, REACH, RINGS + 1)
    inside = np.stack(
        [np.bincount(rays, sign * np.minimum(radius, circle) ** 2, minlength=ANGLES) for circle in circles]
    )
    areas = np.diff(circles**2)
    return np.asarray(np.diff(inside, axis=0) / areas[:, None] * np.sqrt(np.pi * areas)[:, None], dtype=np.float64)
