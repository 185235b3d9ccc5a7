"""Centre lines: the same shape keeps all of it, a lost limb costs its length, not its area."""

from __future__ import annotations

import math

import numpy as np
import pytest
from blobs import blob_polygon
from hypothesis import given, settings
from hypothesis import strategies as st

from riot.transform.centreline import CentreLineOverlap, centre_line, centre_line_overlap
from riot.transform.deformation import overlap_ratio
from riot.transform.tuning import CENTRE_LINE_STEP
from riot.types import FloatArray


def with_limb(width: float, length: float) -> FloatArray:
    """A unit square with a bar on its right side."""
    low, high = 0.5 - width / 2, 0.5 + width / 2
    right = 1.0 + length
    return np.array(
        [[0.0, 0.0], [1.0, 0.0], [1.0, low], [right, low], [right, high], [1.0, high], [1.0, 1.0], [0.0, 1.0]]
    )


@given(st.integers(0, 1000), st.integers(0, 170))
@settings(max_examples=10)
def test_the_same_shape_keeps_its_whole_centre_line(seed: int, start: int) -> None:
    outline = blob_polygon(seed)
    assert centre_line_overlap(np.roll(outline, start, axis=0), outline) == CentreLineOverlap(1.0, 1.0)


@given(st.integers(0, 1000), st.integers(1, 1000))
@settings(max_examples=10)
def test_precision_and_recall_change_places_with_the_shapes(seed: int, other: int) -> None:
    a, b = blob_polygon(seed), blob_polygon(other)
    there, back = centre_line_overlap(a, b), centre_line_overlap(b, a)
    assert (there.precision, there.recall) == (back.recall, back.precision)
    assert 0.0 <= there.dice == back.dice <= 1.0


@pytest.mark.parametrize("width", [0.04, 0.08])
def test_a_lost_limb_is_seen_however_thin(width: float) -> None:
    body, whole = with_limb(width, 0.0), with_limb(width, 1.0)
    assert overlap_ratio(body, whole) > 0.92
    lost, added = centre_line_overlap(body, whole), centre_line_overlap(whole, body)
    assert lost.precision > 0.99 and lost.recall < 0.75
    assert added.recall > 0.99 and added.precision < 0.75


def test_the_centre_line_of_a_bar_is_its_middle() -> None:
    bar = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 0.25], [0.0, 0.25]])
    line = centre_line(bar)
    middle = line[(line[:, 0] > 0.3) & (line[:, 0] < 3.7)]
    assert middle[:, 1] == pytest.approx(0.125, abs=CENTRE_LINE_STEP)
    assert len(middle) == pytest.approx(3.4 / CENTRE_LINE_STEP, abs=2)


def test_dice_is_the_harmonic_mean() -> None:
    assert CentreLineOverlap(0.5, 1.0).dice == pytest.approx(2 / 3)
    assert CentreLineOverlap(0.0, 0.0).dice == 0.0
    assert math.isclose(CentreLineOverlap(0.9, 0.9).dice, 0.9)
