"""Measures of kept detail: 1 and 0 for the same outline, blind to motions, aware of rounding off and of waves."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from blobs import blob_polygon
from hypothesis import given, settings
from hypothesis import strategies as st

from riot.transform.fidelity import bending_energy, bending_ratio, direction_error
from riot.transform.tuning import SMOOTHING_SCALE
from riot.types import FloatArray

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def circle(radius: float) -> FloatArray:
    angle = np.arange(720) * (math.pi / 360)
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def rounded(points: FloatArray, radius: float) -> FloatArray:
    """The polygon with its convex corners rounded off."""
    polygon = shapely.Polygon(points).buffer(-radius).buffer(radius, quad_segs=32)
    return np.array(shapely.orient_polygons(polygon).exterior.coords)[:-1]


def waved(points: FloatArray, height: float) -> FloatArray:
    """The polygon with waves of this height on it."""
    ring = shapely.LinearRing(points)
    at = np.arange(0.0, ring.length, 0.005)
    samples = shapely.get_coordinates(shapely.line_interpolate_point(ring, at))
    ahead = np.roll(samples, -1, axis=0) - np.roll(samples, 1, axis=0)
    normal = np.stack([ahead[:, 1], -ahead[:, 0]], axis=1) / np.hypot(*ahead.T)[:, None]
    return np.asarray(samples + height * np.sin(2.0 * np.pi * at / 0.2)[:, None] * normal)


@given(st.integers(0, 1000), st.floats(0.0, 6.0), st.integers(0, 170))
@settings(max_examples=10)
def test_the_same_outline_keeps_all(seed: int, angle: float, start: int) -> None:
    outline = blob_polygon(seed)
    again = np.roll(outline, start, axis=0)
    assert bending_ratio(again, outline) == pytest.approx(1.0, abs=2e-2)
    assert direction_error(again, outline) < 0.02
    c, s = math.cos(angle), math.sin(angle)
    turned = outline @ np.array([[c, s], [-s, c]])
    assert bending_energy(turned) == pytest.approx(bending_energy(outline), rel=1e-6)


def test_a_circle_bends_as_a_circle_does() -> None:
    assert bending_energy(circle(0.5)) == pytest.approx(2.0 * math.pi / 0.5, rel=0.02)


def test_a_corner_bends_as_its_smoothing_does() -> None:
    expected = 4.0 * (math.pi / 2.0) ** 2 / (2.0 * math.sqrt(math.pi) * SMOOTHING_SCALE)
    assert bending_energy(SQUARE) == pytest.approx(expected, rel=0.25)


def test_rounding_off_takes_energy_and_waves_add_some_and_both_change_directions() -> None:
    blunt, wavy = rounded(SQUARE, 0.1), waved(SQUARE, 0.01)
    assert bending_ratio(blunt, SQUARE) < 0.7
    assert bending_ratio(wavy, SQUARE) > 1.1
    assert direction_error(SQUARE, SQUARE) < 1e-9
    assert direction_error(rounded(SQUARE, 0.05), SQUARE) < direction_error(blunt, SQUARE)
    assert direction_error(waved(SQUARE, 0.005), SQUARE) < direction_error(wavy, SQUARE)


def test_detail_that_is_displaced_is_kept() -> None:
    notch = np.array([[0.0, 0.0], [0.4, 0.0], [0.5, 0.1], [0.6, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    moved = notch + np.array([[0.05, 0.0] if 0.3 < x < 0.7 and y < 0.5 else [0.0, 0.0] for x, y in notch])
    gone = notch[[0, 4, 5, 6]]
    assert direction_error(moved, notch) < 0.3 * direction_error(gone, notch)
