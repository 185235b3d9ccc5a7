"""Parameters of the convexity of one shape. Ours."""

from __future__ import annotations

from dataclasses import dataclass

from riot.parameters.field import ParameterGroup, parameter


@dataclass(frozen=True)
class ConvexityParameters(ParameterGroup):
    """Solidity and concavities of one shape (ours)."""

    depth: float = parameter(
        0.05,
        at_least=0,
        unit="D_c",
        source="ours: about the depth that a viewer notices at the size of a thumbnail",
        meaning="A concavity counts if it reaches deeper than this below the convex hull.",
    )
