"""Parameters of candidate vertices and trunks. Paper §4.1."""

from __future__ import annotations

from dataclasses import dataclass

from riot.parameters.field import ParameterGroup, parameter


@dataclass(frozen=True)
class TrunkParameters(ParameterGroup):
    """Candidate vertices and trunks (paper §4.1)."""

    spacing: float = parameter(
        15.0,
        above=0,
        source="paper §4.1",
        meaning="Sparse boundary points are closer than d_space = L_c / spacing.",
    )
    sparse_tolerance: float = parameter(
        0.03, at_least=0, unit="L_c", meaning="Douglas–Peucker tolerance of the sparse points' features."
    )
    local: float = parameter(50.0, above=0, meaning="The local outside angle is taken over L_c / local on either side.")
    tau_s: float = parameter(
        0.1,
        above=0,
        unit="√area",
        source="paper §4.1",
        meaning="Douglas–Peucker tolerance of the simplified boundary.",
    )
    tau_c: float = parameter(
        0.3,
        at_least=0,
        at_most=1,
        source="paper §4.1",
        meaning="Candidate vertices have a greater congruency score than this.",
    )
    sigma_c: float = parameter(0.1, above=0, unit="D_c", source="paper §4.1", meaning="Width of the congruency score.")
    min_congruent: float = parameter(
        0.03,
        at_least=0,
        unit="perimeters",
        source="paper §4.1",
        meaning="The two congruent arcs at a candidate vertex are together longer than this.",
    )
    min_inside: float = parameter(
        0.9,
        at_least=0,
        at_most=1,
        source="paper §4.1",
        meaning="Least share of a trunk edge that lies inside the shape.",
    )
    min_area: float = parameter(
        0.01,
        at_least=0,
        at_most=1,
        unit="areas",
        source="paper §4.1",
        meaning="Exterior pieces have more area than this; the shape has 1.",
    )
    max_arc: float = parameter(
        0.5,
        above=0,
        at_most=1,
        unit="perimeters",
        source="paper §4.1",
        meaning="Exterior pieces have less boundary than this.",
    )
    max_overlap: float = parameter(
        0.1,
        at_least=0,
        unit="L_c",
        source="paper §4.1",
        meaning="Neighbouring congruent arcs overlap by less than this on the boundary between them.",
    )
    neck_width: float = parameter(
        0.2,
        at_least=0,
        unit="D_c",
        source="paper §4.1",
        meaning="Quick trunks leave out points cut off by necks narrower than this.",
    )
    max_vertices: int = parameter(
        32,
        at_least=3,
        meaning="No trunk has more vertices. The number of candidate vertices bounds them first: at most 27 on MPEG-7, "
        "where no trunk has more than 10.",
    )
    max_trunks: int = parameter(
        50_000,
        at_least=1,
        meaning="No shape has more trunks, against symmetric stars; all of a number of vertices that passes it, and of "
        "greater numbers, are left out.",
    )
