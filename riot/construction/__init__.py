"""Construction: refined conjugate trunks, the partition and its tree, exact transforms (theory §7, §8)."""

from riot.construction.choose import alternatives, construct
from riot.construction.draft import Draft, draft_plan
from riot.construction.make import construct_plan
from riot.construction.pins import Pins, draw, keep, load_pins

__all__ = ["Draft", "Pins", "alternatives", "construct", "construct_plan", "draft_plan", "draw", "keep", "load_pins"]
