"""Counterparts of a new shape, or of a solid's slices, in a mined collection."""
