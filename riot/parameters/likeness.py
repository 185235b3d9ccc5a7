"""Parameters of the likeness of shapes. Ours."""

from __future__ import annotations

from dataclasses import dataclass

from riot.parameters.field import ParameterGroup, parameter


@dataclass(frozen=True)
class LikenessParameters(ParameterGroup):
    """How alike shapes are: near-duplicates of a collection, and the margin of a result (ours)."""

    mirrored: bool = parameter(True, meaning="Shapes are alike, too, if one is like the mirror image of the other.")
    near_duplicate: float = parameter(
        0.1,
        at_least=0,
        unit="likeness distance",
        source="ours: noise of .01 moves half of MPEG-7 by less than .085 (benchmarks/likeness.py --threshold)",
        meaning="Two shapes no farther apart than this are near-duplicates, as are shapes that such pairs join.",
    )
