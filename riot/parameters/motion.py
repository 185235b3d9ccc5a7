"""Parameters of motion planning; all ours, lengths in units of the longer side of the larger shape.

Fabrication gives them in mm for a longer side of 120 mm; the values are makers' rules, not our own prints.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class MotionParameters:
    """Clearances of the pieces, and how long to search."""

    gap: float = 0.00292
    """Outline gap between neighbouring pieces: every piece is shrunk by half of it (0.35 mm of 120 mm)."""
    relief: float = 0.0316
    """Radius of the disc around a hinge in which its two pieces cannot meet: their knuckles take turns in height
    there (3.8 mm of 120 mm: pin of 3 mm, clearance, wall of 1.6 mm, outline gap)."""
    samples: int = 300
    """Random poses for one stretch of the chain, after all regular orders have failed."""
    seed: int = 0
    """Of the random poses."""

    def __post_init__(self) -> None:
        for name in ("gap", "relief"):
            value = getattr(self, name)
            if not 0.0 < value < 0.5:
                raise ValueError(f"{name}: must be greater than 0 and less than 0.5, got {value}")
        for name in ("samples", "seed"):
            if getattr(self, name) < 0:
                raise ValueError(f"{name}: must be 0 or more, got {getattr(self, name)}")
