"""Parameters of the reversibility score of one shape. Paper §5.1."""

from __future__ import annotations

from dataclasses import dataclass

from riot.errors import ParameterError
from riot.parameters.field import ParameterGroup, parameter


@dataclass(frozen=True)
class ReversibilityParameters(ParameterGroup):
    """Reversibility score of one shape (paper §5.1)."""

    sigma_pa: float = parameter(
        1.0, above=0, source="paper §5.1", meaning="Width of the term that favours a perimeter like a circle's."
    )
    sigma_w: float = parameter(
        4.0,
        above=0,
        source="paper §5.1",
        meaning="Width of the term that favours a waist as wide as the way around it.",
    )
    waist_low: float = parameter(
        0.8,
        above=0,
        source="paper §5.1",
        meaning="A neck is a waist if the ratio of the two arcs' lengths between its ends is not less than this.",
    )
    waist_high: float = parameter(
        1.2, above=0, source="paper §5.1", meaning="A neck is a waist if this ratio is not greater than this."
    )
    simplify: float = parameter(
        0.01, at_least=0, unit="L_c", meaning='Douglas–Peucker tolerance of the "slightly simplified" boundary.'
    )

    def check_together(self) -> None:
        """The lower ratio of waists is less than the higher one."""
        if self.waist_low >= self.waist_high:
            raise ParameterError(
                "waist_low", f"must be less than waist_high ({self.waist_high:g}), got {self.waist_low:g}"
            )
