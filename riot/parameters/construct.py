"""Parameters of construction. All ours but the method ``laplacian``, which is the paper's (§4.3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from riot.parameters.field import ParameterGroup, parameter


@dataclass(frozen=True)
class ConstructParameters(ParameterGroup):
    """Construction (theory §8; all ours but the method "laplacian")."""

    method: Literal["exact", "laplacian"] = parameter(
        "exact",
        source="exact: ours; laplacian: paper §4.3",
        meaning="exact: the trunk is partitioned. laplacian: the paper's; pieces overlap and leave gaps.",
    )
    attempts: int = parameter(
        2,
        at_least=1,
        meaning="The most promising plans are constructed until so many succeed; the least deformed is taken.",
    )
    spacing: float = parameter(400.0, above=0, meaning="Points of the partition's mesh are L_c / spacing apart.")
    tolerance: float = parameter(
        0.02,
        at_least=0,
        unit="mesh spacings",
        meaning="Douglas–Peucker tolerance by which the dissection's arcs are simplified.",
    )
    max_cut_off: float = parameter(
        0.01,
        at_least=0,
        unit="areas",
        meaning="Greatest area of cells' parts that are cut off from their trunk edge and go to a neighbour.",
    )
    max_lost_contact: float = parameter(
        0.3, at_least=0, meaning="Greatest share of a trunk edge that other pieces may cover."
    )
    snap: float = parameter(
        0.1, at_least=0, unit="D_c", meaning="Given trunk vertices may lie this far from the outline."
    )
    lines: int = parameter(
        512, at_least=1, meaning="Scanlines of the gaps and overlaps by which the method laplacian ends its rounds."
    )
