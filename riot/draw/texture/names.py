"""The names of textures: the sides of the pieces and the patterns (ours).

This module loads no other, so that commands and configurations can name textures without loading what paints them.
"""

from __future__ import annotations

from typing import Literal, get_args

Side = Literal["p", "q"]
SIDES: tuple[Side, ...] = get_args(Side)
"""The front of the pieces, which shows P, and their back, which shows Q."""

Pattern = Literal["bands", "stripes", "checks"]
PATTERNS: tuple[Pattern, ...] = get_args(Pattern)
