"""What textures are called: their sides and patterns. Apart from what paints, which takes long to import. Ours."""

from __future__ import annotations

from typing import Literal, get_args

Side = Literal["p", "q"]
SIDES: tuple[Side, ...] = get_args(Side)
"""The front of the pieces, which shows P, and their back, which shows Q."""

Pattern = Literal["bands", "stripes", "checks"]
PATTERNS: tuple[Pattern, ...] = get_args(Pattern)
