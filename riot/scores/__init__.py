"""Scores of one shape and of two: reversibility, candidate trunks, QCRS, CRS, and the index (paper §4.1, §4.2, §5)."""
