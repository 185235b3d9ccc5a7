"""Parameters of the quick cross-reversibility score. Paper §5.2; the variant ``tuned`` is ours."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

from riot.parameters.field import ParameterGroup, parameter


@dataclass(frozen=True)
class QcrsParameters(ParameterGroup):
    """Quick cross-reversibility score (paper §5.2)."""

    sigma_e: float = parameter(0.1, above=0, unit="D_c", source="paper §5.2", meaning="Width of the edge term.")
    sigma_angle: float = parameter(
        math.pi / 6, above=0, unit="rad", source="paper §5.2", meaning="Width of the angle term."
    )
    sigma_area: float = parameter(0.1, above=0, unit="areas", source="paper §5.2", meaning="Width of the area term.")
    epsilon: float = parameter(
        0.0,
        at_least=0,
        unit="score in [0, 1]",
        source="ours",
        meaning="By how much a score may be too low, to be found sooner. 0: scores are exact.",
    )


QcrsVariant = Literal["paper", "tuned"]
"""Which trunks QCRS compares: ``paper``: quick trunks. ``tuned``: the full trunks of CRS (ours)."""

QCRS_VARIANTS: Mapping[QcrsVariant, QcrsParameters] = MappingProxyType(
    {"paper": QcrsParameters(), "tuned": QcrsParameters(sigma_area=0.3)}
)
"""Sigmas of each variant. On full trunks the terms of edges and angles are those of CRS. The greater σ_A, the more QCRS
orders pairs as CRS does and the longer the search takes; this one costs what the paper variant does on MPEG-7."""
