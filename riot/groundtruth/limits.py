"""Limits that make an exact pair look like two silhouettes, and let the miner find it with a margin (ours).

Lengths and areas are in the unit-area frame, angles in radians.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely

from riot.geometry.polyline import edge_lengths, simplify
from riot.parameters.field import ParameterGroup, parameter
from riot.types import FloatArray
from riot.units import L_C


@dataclass(frozen=True)
class PairLimits(ParameterGroup):
    """Limits of exact pairs; a generator draws pairs until one keeps all of them.

    >>> PairLimits(least_depth=0.05).least_depth
    0.05
    """

    least_trunk_angle: float = parameter(
        math.radians(40), above=0, below=math.pi, unit="rad", meaning="Least angle of both trunks."
    )
    greatest_trunk_angle: float = parameter(
        math.radians(158), above=0, below=math.pi, unit="rad", meaning="Greatest angle of both trunks."
    )
    least_hinge_angle: float = parameter(
        math.radians(60), above=0, unit="rad", meaning="Least angle of the assembled shape at a hinge."
    )
    greatest_hinge_angle: float = parameter(
        math.radians(325), below=2 * math.pi, unit="rad", meaning="Greatest angle of the assembled shape at a hinge."
    )
    corner_tolerance: float = parameter(
        0.11,
        at_least=0,
        unit="√area",
        meaning="Douglas–Peucker tolerance of the outline whose corners the hinges are near; it shrinks where such "
        "pairs are rare.",
    )
    corner_distance: float = parameter(
        0.03,
        at_least=0,
        unit="√area",
        meaning="Every hinge is within this distance of a corner of the simplified outline, so that a search that "
        "starts from feature points can meet it.",
    )
    least_area: float = parameter(0.02, at_least=0, unit="areas", meaning="Least area of an exterior piece.")
    least_depth: float = parameter(
        0.13,
        at_least=0,
        unit="√area",
        meaning="Least depth of an exterior piece over its trunk edge: more than the paper's τ_s, so that the "
        "simplified piece keeps a convex point.",
    )
    clearance: float = parameter(
        0.02,
        above=0,
        unit="√area",
        meaning="Half the least width of a limb or piece, and of the mouth of a bay.",
    )
    greatest_arc: float = parameter(
        0.45, above=0, at_most=1, unit="perimeters", meaning="Greatest boundary length of an exterior piece."
    )
    greatest_perimeter: float = parameter(2.0 * L_C, above=0, unit="√area", meaning="Greatest perimeter of a shape.")

    def allow_piece(self, arc: FloatArray) -> bool:
        """Whether an exterior piece, (k, 2) from one end of its trunk edge to the other, is deep, large and wide."""
        edge = (arc[-1] - arc[0]) / math.dist(arc[0], arc[-1])
        depth = np.abs((arc - arc[0]) @ [-edge[1], edge[0]]).max()
        polygon = shapely.Polygon(arc)
        return bool(
            depth >= self.least_depth
            and polygon.area >= self.least_area
            and _is_connected(polygon.buffer(-self.clearance))
        )

    def allow_outline(self, outline: FloatArray, arcs: list[FloatArray]) -> bool:
        """Whether an outline, (m, 2), of these arcs is simple, not too long, and wide everywhere."""
        perimeter = float(edge_lengths(outline).sum())
        longest = max(float(np.hypot(*np.diff(arc, axis=0).T).sum()) for arc in arcs)
        if perimeter > self.greatest_perimeter or longest > self.greatest_arc * perimeter:
            return False
        polygon = shapely.Polygon(outline)
        return (
            polygon.is_valid
            and _is_connected(polygon.buffer(-self.clearance))
            and len(polygon.buffer(self.clearance).interiors) == 0
        )

    def allow_hinges(self, outline: FloatArray, trunk: FloatArray, tolerance: float) -> bool:
        """Whether every vertex of the trunk, (n, 2), is near a corner of the outline simplified with ``tolerance``."""
        corners = outline[simplify(outline, tolerance)]
        gaps = np.hypot(*(trunk[:, None, :] - corners[None, :, :]).transpose(2, 0, 1)).min(axis=1)
        return bool(gaps.max() <= self.corner_distance)


def _is_connected(polygon: shapely.Geometry) -> bool:
    return bool(polygon.geom_type == "Polygon" and not polygon.is_empty)
