"""RIOT: reversible shape transforms."""
