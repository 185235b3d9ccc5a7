"""Construction: conjugate trunks, the partition and its tree, exact transforms (theory §7, §8)."""

from riot.construct.choose import construct, construct_scored

__all__ = ["construct", "construct_scored"]
