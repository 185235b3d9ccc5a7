"""The reversibility score: how likely a shape has partners, by roundness, necks and waists (paper §5.1)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from riot.geometry.polyline import TOUCH, arc_length, shifted, simplify
from riot.geometry.shape import Shape
from riot.kernels.segments import find_necks
from riot.kernels.simplify import TIE
from riot.parameters import ReversibilityParameters, TrunkParameters
from riot.types import BoolArray, FloatArray, IntArray
from riot.units import D_C, L_C

HALF_DISC = math.pi / 2.0
"""Neck ratio of the straight side of a half disc: a neck of a lesser ratio cuts off a bump, not a limb. Ours."""


@dataclass(frozen=True, eq=False)
class Reversibility:
    """The reversibility score of a shape, with its terms, necks and waists.

    Parameters
    ----------
    score : float
        ``S_r = min(S1, S2)``, in (0, 1] (paper, equation 11).
    s1 : float
        Roundness: 1 for a disc, falling with the perimeter (equation 9).
    s2 : float
        Waists: 1 without a waist, falling with the largest waist ratio (equation 10).
    waist : float
        The largest neck ratio among the waists; nan without a waist.
    necks : (k, 2) int64
        Boundary indices (p1, p2), each pair once, sorted; one of the two is a concave point.
    neck_ratio : (k,) float64
        Geodesic (along the boundary, the shorter way) over Euclidean distance.
    neck_width : (k,) float64
        Euclidean distance of p1 and p2, in the unit-area frame.
    waists : (k,) bool
        Which necks divide the boundary about evenly.
    """

    score: float
    s1: float
    s2: float
    waist: float
    necks: IntArray
    neck_ratio: FloatArray
    neck_width: FloatArray
    waists: BoolArray


def reversibility(shape: Shape, parameters: ReversibilityParameters | None = None) -> Reversibility:
    """Score one shape, find its necks and waists (paper §5.1).

    A neck starts at a concave vertex p1 of the boundary simplified by Douglas–Peucker and ends at a local maximum
    p2 of ``R(p) = d_geo(p1, p) / d(p1, p)``, the segment p1p2 being inscribed: nowhere outside the closed shape.
    Ours: R is taken at the shape's boundary points (not the simplified ones), and p2 is a local maximum if
    neither of the two boundary points beside it has a greater R, visible from p1 or not. p1's own neighbours are
    not considered (R is 1 there).

    >>> from riot import Shape
    >>> disc = [(np.cos(t), np.sin(t)) for t in np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)]
    >>> round(reversibility(Shape.from_polygon(disc)).score, 3)
    1.0
    >>> round(reversibility(Shape.from_polygon([(0, 0), (9, 0), (9, 1), (0, 1)])).score, 3)
    0.679
    """
    chosen = parameters or ReversibilityParameters()
    points = np.ascontiguousarray(shape.points, dtype=np.float64)
    arc = arc_length(points)
    perimeter = float(arc[-1])
    concave = concave_points(points, chosen.simplify * L_C)
    necks = find_necks(points, arc[:-1], perimeter, concave, TIE, TOUCH)
    # If both ends of a neck are concave, both give the pair: it is kept once.
    lower, upper = np.minimum(necks[:, 0], necks[:, 1]), np.maximum(necks[:, 0], necks[:, 1])
    _, once = np.unique(lower * len(points) + upper, return_index=True)
    necks = necks[np.sort(once)]

    geodesic = np.abs(arc[necks[:, 1]] - arc[necks[:, 0]])
    geodesic = np.minimum(geodesic, perimeter - geodesic)
    across = points[necks[:, 1]] - points[necks[:, 0]]
    width = np.hypot(across[:, 0], across[:, 1])
    ratio = geodesic / width
    balance = geodesic / (perimeter - geodesic)
    waists = (balance >= chosen.waist_low) & (balance <= chosen.waist_high)

    s1 = roundness(perimeter, chosen.sigma_pa)
    waist = float(ratio[waists].max()) if waists.any() else float("nan")
    s2 = float(np.exp(-((waist - 1.0) ** 2) / (2.0 * chosen.sigma_w**2))) if waists.any() else 1.0
    return Reversibility(min(s1, s2), s1, s2, waist, necks, ratio, width, waists)


def roundness(perimeter: float, sigma_pa: float = 1.0) -> float:
    """S1 of a unit-area shape of this perimeter (paper, equation 9).

    >>> round(roundness(3.6), 4)
    0.9999
    """
    excess = perimeter / L_C - 1.0
    return float(np.exp(-(excess**2) / (2.0 * sigma_pa**2)))


def concave_points(points: FloatArray, tolerance: float) -> IntArray:
    """Indices, (c,) int64, sorted, of the concave vertices of a counter-clockwise polygon after Douglas–Peucker.

    >>> concave_points(house.points, 0.01).tolist()
    []
    """
    kept = simplify(points, tolerance)
    corners = points[kept]
    arriving = corners - shifted(corners, -1)
    leaving = shifted(arriving, 1)
    turn = arriving[:, 0] * leaving[:, 1] - arriving[:, 1] * leaving[:, 0]
    lengths = np.hypot(arriving[:, 0], arriving[:, 1])
    scale = lengths * shifted(lengths, 1)
    return np.asarray(kept[turn < -TIE * scale], dtype=np.int64)


def cut_off(shape: Shape, necks: Reversibility, width: float | None = None) -> BoolArray:
    """Boundary points, (m,) bool, cut off by narrow necks (paper §5.2).

    A neck narrower than ``width`` (default ``0.2·D_c``) cuts off the points strictly between its ends on the
    shorter side along the boundary; if both sides are equally long, neither. Ours: a neck whose ratio is below
    that of a half disc cuts off nothing, since that is a bump of the outline and no limb.

    >>> int(cut_off(house, reversibility(house)).sum())
    0
    """
    limit = TrunkParameters().neck_width * D_C if width is None else width
    arc = arc_length(shape.points)
    perimeter = float(arc[-1])
    mask = np.zeros(len(shape.points), dtype=np.bool_)
    narrow = (necks.neck_width < limit) & (necks.neck_ratio >= HALF_DISC)
    for first, second in np.sort(necks.necks[narrow], axis=1):
        between = float(arc[second] - arc[first])
        if abs(2.0 * between - perimeter) <= TIE * perimeter:
            continue
        if 2.0 * between < perimeter:
            mask[first + 1 : second] = True
        else:
            mask[:first] = mask[second + 1 :] = True
    return mask
