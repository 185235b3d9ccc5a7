"""How well a silhouette was read: numbers that tell a wrong outline from a right one, and words for a person (ours)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

LEAST_KEPT = 0.8
"""Share of the object below which a shape is doubtful: a part that people see is gone."""

MOST_COVERED = 0.95
"""Share of the page above which a shape is doubtful: it is the page itself, rather than an object on it."""

LEAST_SEPARATION = 0.7
"""Otsu's criterion below which a shape is doubtful: grey values that are spread evenly have 0.75."""

MOST_ROUGHNESS = 0.5
"""Roughness above which a shape is doubtful: the outline is noise, or finer than the pixels."""

MOST_CHANGED = 0.1
"""Share of the area which a repair may change; above it a shape is doubtful."""

MUCH_COVERED = 0.85
"""Share of the page above which a shape is doubtful that touches all its sides: a tightly cut object leaves more."""

ALL_SIDES = 4

FRAME = "a frame around the object is left out"
LINE = "a line across the page is left out"
SHADED = "the page is not evenly light"
CHECKED = "a checkerboard stands for transparency"
REMARKS = (FRAME, LINE, SHADED, CHECKED)
"""What may be done to find an object; files know them by their order."""


@dataclass(frozen=True)
class ReadingQuality:
    """How well the outline of a shape was read.

    Parameters
    ----------
    kept : float
        Share of the object's area that is in the shape, which is its largest connected part; 1 if nothing was dropped.
    covered : float
        Share of the page that the shape covers; nan if there is no page.
    sides : int
        How many of the four sides of the page it touches.
    separation : float
        Otsu's criterion: variance between object and background over all variance of the picture's values, 0 … 1;
        nan if nothing had to be separated.
    dropped : int
        Connected parts that were dropped, specks apart.
    roughness : float
        How much longer the traced outline is than the shape's corners joined by straight lines, less 1; nan if nothing
        was traced.
    changed : float
        Share of the area that the repair of an outline which crosses itself added or took.
    remarks : tuple of str
        What else was done to find the object.
    """

    kept: float = 1.0
    covered: float = math.nan
    sides: int = 0
    separation: float = math.nan
    dropped: int = 0
    roughness: float = math.nan
    changed: float = 0.0
    remarks: tuple[str, ...] = ()

    @property
    def doubts(self) -> tuple[str, ...]:
        """Why the outline may be wrong, in words; empty if there is no reason.

        >>> ReadingQuality(kept=0.5, dropped=1).doubts
        ('only 50% of the object is kept: 1 other part does not touch it, or by a corner only',)
        """
        return tuple(self._doubts())

    @property
    def doubtful(self) -> bool:
        """Whether a person should look before the shape is used.

        >>> ReadingQuality(separation=0.99).doubtful
        False
        """
        return bool(self.doubts)

    def _doubts(self) -> Iterator[str]:
        if self.kept < LEAST_KEPT:
            parts = "1 other part does" if self.dropped == 1 else f"{self.dropped or 'small'} other parts do"
            yield f"only {self.kept:.0%} of the object is kept: {parts} not touch it, or by a corner only"
        if self.covered > MOST_COVERED:
            yield f"it covers {self.covered:.0%} of the page"
        elif self.sides == ALL_SIDES and self.covered > MUCH_COVERED:
            yield "it touches the border of the page on all sides"
        if self.separation < LEAST_SEPARATION:
            yield f"object and background are not clearly separate (Otsu's criterion {self.separation:.2f})"
        if self.roughness > MOST_ROUGHNESS:
            yield f"the outline is ragged: {1.0 + self.roughness:.1f} times as long as its corners joined"
        if self.changed > MOST_CHANGED:
            yield f"the outline crosses itself, and its repair changed {self.changed:.0%} of the area"
