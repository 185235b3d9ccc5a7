"""Parameters of motion planning; all ours.

Fabrication gives lengths in mm for a longer side of 120 mm; the values are makers' rules, not our own prints.
"""

from __future__ import annotations

from dataclasses import dataclass

from riot.parameters.field import ParameterGroup, parameter


@dataclass(frozen=True)
class MotionParameters(ParameterGroup):
    """Clearances of the pieces, and how long to search."""

    gap: float = parameter(
        0.00292,
        above=0,
        below=0.5,
        unit="longer sides",
        meaning="Outline gap between neighbouring pieces: every piece is shrunk by half of it (0.35 mm of 120 mm).",
    )
    relief: float = parameter(
        0.0316,
        above=0,
        below=0.5,
        unit="longer sides",
        meaning="Radius of the disc around a hinge in which its two pieces cannot meet: their knuckles take turns in "
        "height there (3.8 mm of 120 mm: pin of 3 mm, clearance, wall of 1.6 mm, outline gap).",
    )
    samples: int = parameter(
        300,
        at_least=0,
        meaning="Random poses for one part of the motion of the chain, after all regular orders have failed.",
    )
    seed: int = parameter(0, at_least=0, meaning="Seed of the random poses.")
