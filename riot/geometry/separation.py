"""Object and page: the ways to tell them apart in a picture, and the choice among them (ours, on Otsu's threshold).

The plain way, by opacity or by grey value, is taken where its result is clear. Where it is not, other ways are tried
(`riot.geometry.background`, `riot.geometry.frames`), and the one that separates best is taken.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy import ndimage

from riot.geometry import background, frames
from riot.geometry.levels import Levels, two_levels, weak_level
from riot.geometry.picture import Picture
from riot.geometry.quality import ALL_SIDES, FRAME, LINE, MUCH_COVERED, ReadingQuality
from riot.types import BoolArray, FloatArray, IntArray

_CLEAR = 0.9
"""Score from which the plain way is taken without a look at others. Ours: all of MPEG-7 is above it."""

_TWO_LEVELS = 0.97
"""Otsu's criterion of a picture that has two levels and little else: no other way can see more in it. Ours."""

_SPLIT = 0.4
"""Share of the border from which the other side of a separation may as well be the object. Ours."""

_BETTER = 0.05
"""By how much more another way must score. Ours: what is clear enough stays as it is."""

_COLOURS_AGREE = 0.75
"""Share of the colours' variance that a separation by grey values must explain. Ours."""

_SAME = 0.01
"""Share of an object's area by which two candidates may differ and see the same. Ours."""

_SPECK = 1e-3
"""Parts that are smaller than this share of the object are specks. Ours."""

_TOUCHED = 0.005
"""Share of a side of the page that an object must take to touch it. Ours: a corner of a few pixels does not."""


_OF_PIXELS = ("filled", "_sizes_and_labels", "component")
"""What is computed of a candidate's pixels, once."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A way to see the picture: the object's share of each pixel, its pixels, and how clearly they are separate.

    Parameters
    ----------
    ramp : (rows, columns) float64
        0 … 1.
    light : (rows, columns) bool
        Pixels of the object, and of other parts.
    criterion : float
        Otsu's.
    lost : float
        Share of the object that seems to count as page, 0 … 1.
    remarks : tuple of str
        What was done to see it so.
    confirmed : ReadingQuality, optional
        That of a clearer candidate which sees the same object.
    levels : Levels, optional
        Those of the field that it was separated by.
    """

    ramp: FloatArray
    light: BoolArray
    criterion: float
    lost: float = 0.0
    remarks: tuple[str, ...] = ()
    confirmed: ReadingQuality | None = None
    levels: Levels | None = None

    def known(self, **changes: Any) -> Candidate:
        """The same object, of which more is known: what was found of its pixels stays."""
        other = replace(self, **changes)
        other.__dict__.update({name: self.__dict__[name] for name in _OF_PIXELS if name in self.__dict__})
        return other

    @cached_property
    def filled(self) -> BoolArray:
        """Pixels that the outside cannot reach over edges or corners, so that contours never touch themselves."""
        outside, _ = ndimage.label(np.pad(~self.light, 1, constant_values=True), structure=np.ones((3, 3)))
        return np.asarray(outside[1:-1, 1:-1] != outside[0, 0], dtype=np.bool_)

    @cached_property
    def _sizes_and_labels(self) -> tuple[IntArray, Any]:
        labels, _ = ndimage.label(self.filled)
        sizes: IntArray = np.bincount(labels.ravel()).astype(np.int64)
        sizes[0] = 0
        return sizes, labels

    @cached_property
    def component(self) -> BoolArray:
        """The component, connected over edges, with the most pixels; of equals the first in reading order."""
        sizes, labels = self._sizes_and_labels
        return self.filled if len(sizes) == 2 else np.asarray(labels == int(sizes.argmax()), dtype=np.bool_)

    @cached_property
    def quality(self) -> ReadingQuality:
        """How well the object is separate."""
        if self.confirmed is not None:
            return replace(self.confirmed, remarks=self.remarks)
        sizes, _ = self._sizes_and_labels
        total, largest = int(sizes.sum()), int(sizes.max(initial=0))
        inside = self.component
        sides = (inside[0], inside[-1], inside[:, 0], inside[:, -1])
        return ReadingQuality(
            kept=largest / total if total else 0.0,
            covered=largest / self.light.size,
            sides=sum(bool(side.mean() > _TOUCHED) for side in sides),
            separation=self.criterion,
            dropped=int((sizes > _SPECK * largest).sum()) - 1,
            remarks=self.remarks,
        )

    @cached_property
    def score(self) -> float:
        """0 … 1: how likely it is that a person sees the same object."""
        border = border_of(self.component).mean()
        quality = self.quality
        page = quality.covered > MUCH_COVERED and (quality.sides == ALL_SIDES or frames.is_rectangle(self.component))
        return float(quality.separation * quality.kept * (1.0 - border) * (1.0 - self.lost) * (0.5 if page else 1.0))


def separate(picture: Picture) -> Candidate:
    """Tell the object of a picture, whose values are not all alike, from its page."""
    if picture.grey.min() == picture.grey.max():  # colours of equal lightness
        dark = np.zeros(picture.grey.shape, dtype=np.bool_)
        plain = Candidate(dark.astype(np.float64), dark, 0.0)
    else:
        plain = _without_frame(by_levels(picture.grey, opaque_object=picture.opaque_object))
    if picture.opaque_object:
        return plain
    plain = plain.known(lost=_lost(picture, plain))
    two_levels_only = plain.criterion >= _TWO_LEVELS and not plain.lost and border_of(plain.component).mean() < _SPLIT
    if _is_object(plain) and (plain.score >= _CLEAR or two_levels_only):
        return plain
    best = plain if _is_object(plain) else plain.known(lost=1.0)
    for candidate in _others(picture, plain):
        if not _is_object(candidate):
            continue
        if _agree(candidate, plain):  # then the plain one's edges are the truer
            clearer = plain.known(confirmed=candidate.quality, lost=0.0)
            best = max(best, clearer, key=lambda seen: seen.score)
        elif candidate.score > best.score + _BETTER:
            best = candidate
        if best.score >= _CLEAR:
            break
    return best


def by_levels(field: FloatArray, *, opaque_object: bool = False) -> Candidate:
    """Separate by Otsu's threshold: the object is the side with less of the border, or what is opaque."""
    levels = two_levels(field)
    ramp = np.clip((field - levels.low) * (1.0 / (levels.high - levels.low)), 0.0, 1.0)
    light = ramp > 0.5
    border = border_of(light)
    most = len(border) - 1 if opaque_object else len(border) // 2  # an opaque page with a hole shows the hole
    if int(border.sum()) > most:
        light, ramp = ~light, 1.0 - ramp
    return Candidate(ramp, light, levels.criterion, levels=levels)


def border_of(mask: BoolArray) -> BoolArray:
    """(2 (rows + columns) − 4,) the outermost pixels.

    >>> len(border_of(np.ones((4, 3), bool)))
    10
    """
    return np.concatenate([mask[0], mask[-1], mask[1:-1, 0], mask[1:-1, -1]])


def _others(picture: Picture, plain: Candidate) -> Iterator[Candidate]:
    values = picture.grey[..., None] if picture.colours is None else picture.colours.astype(np.float64)
    if border_of(plain.light).mean() >= _SPLIT:
        yield Candidate(1.0 - plain.ramp, ~plain.light, plain.criterion, levels=plain.levels)
    grey, seen = picture.grey[..., None], plain
    for _ in range(frames.MOST_LINES):
        mended, without = (frames.without_lines(of, seen.component) for of in (values, grey))
        if mended is None or without is None or without.min() == without.max():
            break
        values, grey = mended, without
        seen = replace(by_levels(grey[..., 0]), remarks=(LINE,))
        yield seen
    for field, remark in background.fields(values):
        if field.min() < field.max():
            yield _without_frame(replace(by_levels(field), remarks=(remark,) if remark else ()))


def _without_frame(candidate: Candidate) -> Candidate:
    inner = frames.inside_frame(candidate.ramp, candidate.light, candidate.component)
    if inner is None:
        return candidate
    ramp, light = inner
    return replace(candidate, ramp=ramp, light=light, remarks=(*candidate.remarks, FRAME))


def _is_object(candidate: Candidate) -> bool:
    """Whether a candidate has an object at all: no line across the page, no single pixels."""
    component = candidate.component
    return bool(component.any()) and not frames.is_line(component) and component.mean() > _SPECK


def _agree(candidate: Candidate, plain: Candidate) -> bool:
    """Whether two candidates see the same object."""
    union = int((candidate.component | plain.component).sum())
    return int((candidate.component ^ plain.component).sum()) <= _SAME * union


def _lost(picture: Picture, plain: Candidate) -> float:
    """Share of the object that separation by grey values seems to lose: parts of other colours or levels."""
    area = int(plain.component.sum())
    if not area:
        return 1.0
    if picture.colours is not None:
        explained = background.explained_variance(picture.colours, plain.light)
        if explained < _COLOURS_AGREE:
            return 1.0 - explained
    assert plain.levels is not None
    weak = weak_level(picture.grey, plain.levels, plain.light)
    if weak is None:
        return 0.0
    union = Candidate(plain.ramp, plain.light | weak.pixels, 1.0)
    if border_of(weak.pixels).any() or frames.is_rectangle(union.component):
        return 0.0  # another page, or a card on which the object lies
    gained = int(union.component.sum())
    return (gained - area) / gained
