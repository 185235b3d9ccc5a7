"""Parameters of the way from a silhouette to a shape. Paper §6.

Paper, here and in the other groups: Li et al., *Construction and Fabrication of Reversible Shape Transforms*, ACM TOG
37(6), 190, 2018. Every shape has unit area, so that lengths are absolute: ``L_c = 2√π`` is the perimeter and
``D_c = 2/√π`` the diameter of the circle of unit area.
"""

from __future__ import annotations

from dataclasses import dataclass

from riot.parameters.field import ParameterGroup, parameter


@dataclass(frozen=True)
class ShapeParameters(ParameterGroup):
    """Silhouette → shape (paper §6)."""

    spacing: float = parameter(
        100.0,
        above=0,
        source="paper §6",
        meaning="Consecutive boundary points are closer than L_c / spacing.",
    )
    feature_tolerance: float = parameter(
        0.006,
        at_least=0,
        unit="L_c",
        meaning="Douglas–Peucker tolerance for the main feature points.",
    )
    vertex_tolerance: float = parameter(
        5e-5,
        at_least=0,
        unit="L_c",
        meaning="Vertices of a polygon stay boundary points unless the outline without them is off by less than this; "
        "the outlines of pictures and SVG files are known no better than their sampling.",
    )
    max_pixels: int = parameter(64_000_000, at_least=1, unit="pixels", meaning="A picture with more pixels is refused.")
    min_pixels: int = parameter(64, at_least=1, unit="pixels", meaning="An object with fewer pixels is refused.")
    smoothing: float = parameter(
        1.0,
        at_least=0,
        unit="pixels",
        meaning="Standard deviation of the blur that takes the stair-case off binary pictures.",
    )
