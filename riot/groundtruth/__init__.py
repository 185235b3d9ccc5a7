"""Exact reversible pairs without end, to test against (theory §11)."""
