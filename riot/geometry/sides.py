"""Straight sides and the corners between them, whose change an eye notices first, as rows of an energy (ours).

A side of length ℓ that bends with curvature κ costs ℓ² ∫ κ² ds; a right angle, or a flat one, between two sides that
changes by δ costs ℓ² δ², ℓ the shorter side. Both are of the kind of a strain energy: squares of pure numbers times an
area. A side that turns or grows as a whole costs nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from riot.geometry import polyline
from riot.types import FloatArray, IntArray
from riot.units import D_C

LEAST_SIDE = 0.2 * D_C
"""Length: a shorter section is no side that an eye sees as straight."""

SIDE_TOLERANCE = 0.005 * D_C
"""Length: a side keeps this close to its chord; about a pixel of the usual pictures."""

MOST_SAG = 0.012
"""Share of the length: the mean distance of a side from its chord, with its sign, is less. Two thirds of the height of
a shallow arc, which is no straight side."""

LEAST_STEP = 1e-3
"""Share of a side's length that a step along it counts at least."""

ANGLE_TOLERANCE = np.radians(8.0)
"""Radians: angles between sides count as right or flat within this."""


@dataclass(frozen=True, eq=False)
class Sides:
    """Straight sides of a closed polygon.

    Parameters
    ----------
    ends : (s, 2) int64
        First and last vertex of each, in the polygon's direction; the last may be past the polygon's end (mod m).
    joints : (j, 2) int64
        Consecutive sides with a right or flat angle between them.
    """

    ends: IntArray
    joints: IntArray


def straight_sides(points: FloatArray) -> Sides:
    """Find the straight sides of a polygon (m, 2) of unit area (ours).

    >>> from riot import Shape
    >>> square = Shape.from_polygon([(0, 0), (1, 0), (1, 1), (0, 1)])
    >>> sides = straight_sides(square.points)
    >>> len(sides.ends), len(sides.joints)
    (4, 4)
    """
    m = len(points)
    kept = polyline.simplify(points, SIDE_TOLERANCE)
    stops = np.append(kept[1:], kept[0] + m)
    chord = points[stops % m] - points[kept]
    lengths = np.hypot(chord[:, 0], chord[:, 1])
    ends = []
    for start, stop, (x, y), length in zip(kept, stops, chord, lengths, strict=True):
        if length < LEAST_SIDE:
            continue
        offset = points[np.arange(start, stop + 1) % m] - points[start]
        across, along = (x * offset[:, 1] - y * offset[:, 0]) / length, (offset @ [x, y]) / length
        if abs(np.trapezoid(across, along)) < MOST_SAG * length**2 and (np.diff(along) > 0.0).all():
            ends.append((start, stop))
    sides = np.array(ends, dtype=np.int64).reshape(-1, 2)
    return Sides(sides, _joints(points, sides))


def _joints(points: FloatArray, sides: IntArray) -> IntArray:
    m = len(points)
    chord = points[sides[:, 1] % m] - points[sides[:, 0]]
    direction = np.arctan2(chord[:, 1], chord[:, 0])
    joints = []
    for first in range(len(sides)):
        second = (first + 1) % len(sides)
        if second == first or sides[first, 1] % m != sides[second, 0]:
            continue
        turn = (direction[second] - direction[first] + np.pi) % (2.0 * np.pi) - np.pi
        if min(abs(abs(turn) - 0.5 * np.pi), abs(turn)) < ANGLE_TOLERANCE:
            joints.append((first, second))
    return np.array(joints, dtype=np.int64).reshape(-1, 2)


def side_rows(points: FloatArray, sides: Sides) -> tuple[IntArray, FloatArray]:
    """Rows of the energy of straight sides: four vertices (r, 4) and a vector for each (r, 4, 2).

    The energy of displacements u (m, 2) is the sum over rows of (Σ_a vector[a] · u[vertex[a]])².

    >>> from riot import Shape
    >>> square = Shape.from_polygon([(0, 0), (1, 0), (1, 1), (0, 1)])
    >>> vertices, vectors = side_rows(square.points, straight_sides(square.points))
    >>> turned = np.stack([-square.points[:, 1], square.points[:, 0]], axis=1)
    >>> bool(np.abs(np.einsum("rax,rax->r", vectors, turned[vertices])).max() < 1e-12)
    True
    """
    m = len(points)
    vertices: list[IntArray] = [np.empty((0, 4), dtype=np.int64)]
    vectors: list[FloatArray] = [np.empty((0, 4, 2))]
    starts, stops = sides.ends[:, 0], sides.ends[:, 1]
    chords = points[stops % m] - points[starts % m]
    lengths = np.hypot(chords[:, 0], chords[:, 1])
    normals = np.stack([-chords[:, 1], chords[:, 0]], axis=1) / lengths[:, None]
    for start, stop, chord, length, normal in zip(starts, stops, chords, lengths, normals, strict=True):
        run = np.arange(start, stop + 1) % m
        # A side that is bent so far that it runs back somewhere is as stiff there as where it hardly goes on.
        step = np.maximum(np.diff(points[run] @ (chord / length)), LEAST_STEP * length)
        before, after = step[:-1], step[1:]
        weight = length / np.sqrt(0.5 * (before + after))
        share = np.stack([weight / before, -weight * (1.0 / before + 1.0 / after), weight / after], axis=1)
        vertices.append(np.stack([run[:-2], run[1:-1], run[2:], run[2:]], axis=1))
        share = np.concatenate([share, np.zeros((len(share), 1))], axis=1)
        vectors.append(share[:, :, None] * normal)
    for first, second in sides.joints:
        shorter = min(lengths[first], lengths[second])
        ends = np.array([starts[first], stops[first], starts[second], stops[second]])
        a, b = normals[first] * (shorter / lengths[first]), normals[second] * (shorter / lengths[second])
        vertices.append(ends[None] % m)
        vectors.append(np.stack([a, -a, -b, b])[None])
    return np.concatenate(vertices), np.concatenate(vectors)
