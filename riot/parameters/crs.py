"""Parameters of the cross-reversibility score. Paper §4.2."""

from __future__ import annotations

import math
from dataclasses import dataclass

from riot.parameters.field import ParameterGroup, parameter


@dataclass(frozen=True)
class CrsParameters(ParameterGroup):
    """Cross-reversibility score (paper §4.2)."""

    sigma_e: float = parameter(0.1, above=0, unit="D_c", source="paper §4.2", meaning="Width of the edge term.")
    sigma_angle: float = parameter(
        math.pi / 6, above=0, unit="rad", source="paper §4.2", meaning="Width of the angle term."
    )
    sigma_area: float = parameter(0.3, above=0, unit="areas", source="paper §4.2", meaning="Width of the area term.")
    lines: int = parameter(128, at_least=1, meaning="Scanlines of the area term.")
