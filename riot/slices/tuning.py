"""Numbers of slicing that no user sets: unit, meaning and source of each. All ours.

What a user may set is an option of `riot slices`, or a parameter of `riot.slices.cut.Cut`.
"""

from __future__ import annotations

GREATEST_COUNT = 200
"""Slices of one object, at most: each is a puzzle of its own."""

SECTIONS_PER_SLICE = 4
"""Sections of every slice at which the stack is compared with the object."""

BETTER_IOU = 1e-6
"""IoU: a direction of stacking is preferred to an earlier one if it gains more; above rounding."""

MOST_ATTEMPTS = 4
"""Counterparts that a slice tries at most, one after another, until one can be made."""

GREATEST_BYTES = 1 << 29
"""Bytes: greatest size of a model's file, and of what a 3MF file, which is a zip, holds unpacked."""

GREATEST_TRIANGLES = 5_000_000
"""Triangles of a model, at most: bounds the memory that one file can take."""

GREATEST_COORDINATE_MM = 1e9
"""mm: a file with a greater coordinate is damaged, for no printer builds an object of 1000 km."""
