"""Units of length: every shape has unit area, so that these are absolute (paper §6)."""

from __future__ import annotations

import math

L_C = 2.0 * math.sqrt(math.pi)
"""Perimeter of the unit-area circle, the unit of boundary lengths."""

D_C = 2.0 / math.sqrt(math.pi)
"""Diameter of the unit-area circle, the unit of straight distances."""
