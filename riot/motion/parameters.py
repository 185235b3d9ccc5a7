"""Parameters of motion planning; all ours, lengths in units of the longer side of the larger shape.

Fabrication gives them in mm for a longer side of 120 mm; the values are makers' rules, not our own prints.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class MotionParameters:
    """Clearances of the pieces, and how long to search."""

    gap: float = 0.35 / 120.0
    """Outline gap between neighbouring pieces, in units of the longer side of the larger shape: every piece is shrunk
    by half of it."""
    relief: float = 3.8 / 120.0
    """Radius of the disc around a hinge in which its two pieces cannot meet: their knuckles take turns in height
    there (pin of 3 mm, clearance, wall of 1.6 mm, outline gap)."""
    samples: int = 300
    """Random poses for one stretch of the chain, after all regular orders have failed."""
    seed: int = 0
    """Of the random poses."""
