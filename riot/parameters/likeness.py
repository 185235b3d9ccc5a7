"""Parameters of the likeness of shapes. Ours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from riot.parameters.field import ParameterGroup, parameter


@dataclass(frozen=True)
class LikenessParameters(ParameterGroup):
    """How alike shapes are: near-duplicates of a collection, and the margin of a result (ours)."""

    mirror_images: Literal["alike", "different"] = parameter(
        "alike", meaning="Whether a shape is like its mirror image (alike), or is compared as it is (different)."
    )
    near_duplicate: float = parameter(
        0.1,
        at_least=0,
        unit="likeness distance",
        source="ours: noise of .01 moves half of MPEG-7 by less than .085 (benchmarks/likeness.py --threshold)",
        meaning="Two shapes no farther apart than this are near-duplicates, as are shapes that such pairs join.",
    )

    @property
    def mirrored(self) -> bool:
        """Whether a shape is compared with mirror images, too."""
        return self.mirror_images == "alike"
